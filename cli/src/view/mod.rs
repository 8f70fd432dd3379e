//! View files: camera, lights, background, effects and a camera path in TOML (`--view`; docs/view.md has the format).
//!
//! In: a file. Out: what flags would have given, and the path. Values are checked as those of flags are, and a key that
//! is not known is refused; an error names file and line. An area light becomes point lights on a grid of it.

mod path;
mod table;

use std::io::Read;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use toml::de::DeValue;
use voxdag::effects::Effects;
use voxdag::math;
use voxdag::shade::LightKind;

use crate::error::{Error, Result};
use crate::input;
use crate::options::values::{LAST_FRAME, colour_of, direction_of, effects, field_of_view_of, triple_of};
use crate::options::{CameraArgs, LightArg, LightingArgs, ViewArgs};
use path::{CameraPath, Key};
use table::{Problem, Table, number, numbers, switch, text_of, whole};

/// Most bytes of a view file: far more than a path of a key per frame takes.
const MOST_BYTES: u64 = 1 << 22;
/// Most lights, each point of an area light counted.
const MOST_LIGHTS: usize = 1024;

/// What a view file says; without a file nothing.
#[derive(Debug, Default)]
pub struct View {
    /// The file.
    pub file: Option<PathBuf>,
    /// Those that may be drawn, where flags do not say.
    pub effects: Option<Effects>,
    camera: CameraArgs,
    lighting: LightingArgs,
    path: CameraPath,
}

impl View {
    /// Reads the file that the flag names.
    pub fn read(args: &ViewArgs) -> Result<View> {
        let Some(path) = &args.view else { return Ok(View::default()) };
        let mut bytes = Vec::new();
        let found = input::open(path)?.0.take(MOST_BYTES + 1).read_to_end(&mut bytes);
        found.map_err(|cause| input::unreadable(path, &cause))?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(Error::input(path, format_args!("is no view file: it has more than {MOST_BYTES} bytes")));
        }
        let text = str::from_utf8(&bytes).map_err(|error| Problem::new(error.valid_up_to(), "expected UTF-8"));
        let view = text.and_then(View::parse).map_err(|problem| problem.in_file(path, &bytes))?;
        Ok(View { file: Some(path.clone()), ..view })
    }

    /// The camera, where flags were not given.
    pub fn camera(&self, flags: &CameraArgs) -> CameraArgs {
        flags.or(&self.camera)
    }

    /// The lights and what goes with them, where flags were not given.
    pub fn lighting(&self, flags: &LightingArgs) -> LightingArgs {
        flags.or(&self.lighting)
    }

    /// The camera at a frame of the path, where flags were not given.
    pub fn camera_at(&self, frame: u32, flags: &CameraArgs) -> CameraArgs {
        flags.or(&self.path.camera(frame)).or(&self.camera)
    }

    /// The frames of the camera path, if there is one.
    pub fn frames(&self) -> Option<RangeInclusive<u32>> {
        self.path.frames()
    }

    fn parse(text: &str) -> Result<View, Problem> {
        let mut file = Table::parse(text)?;
        let mut view = View::default();
        view.lighting.ambient = file.take("ambient", colour)?;
        view.lighting.background = file.take("background", colour)?;
        view.effects = file.take("effects", |value| effects(&text_of(value)?))?;
        if let Some(mut table) = file.table("camera")? {
            view.camera = camera(&mut table)?;
            table.finish()?;
        }
        for table in file.tables("light")? {
            light(table, &mut view.lighting.lights)?;
        }
        for mut table in file.tables("path")? {
            let frame = table.need("frame", |value| whole(value, LAST_FRAME))?;
            if let Some(before) = view.path.0.last().filter(|key| key.frame >= frame) {
                let expected = "expected each frame once, in their order";
                return Err(table.problem(format_args!("frame {frame} after frame {}: {expected}", before.frame)));
            }
            view.path.0.push(Key { frame, camera: camera(&mut table)? });
            table.finish()?;
        }
        file.finish()?;
        Ok(view)
    }
}

/// A camera, or what of it is said.
fn camera(table: &mut Table<'_>) -> Result<CameraArgs, Problem> {
    let camera = CameraArgs {
        eye: table.take("eye", point)?,
        target: table.take("target", point)?,
        view_up: table.take("up", direction)?,
        fov: table.take("fov", |value| field_of_view_of(number(value)?))?,
    };
    if camera.eye.is_some() && camera.eye == camera.target {
        return Err(table.problem("eye and target are the same point: move one of them"));
    }
    Ok(camera)
}

/// A light of any kind, after those before it.
fn light(mut table: Table<'_>, lights: &mut Vec<LightArg>) -> Result<(), Problem> {
    let kinds = [
        table.take("point", point)?.map(|position| vec![LightKind::Point(position)]),
        table.take("direction", direction)?.map(|towards| vec![LightKind::Directional(towards)]),
        table.table("area")?.map(area).transpose()?,
    ];
    let color = table.take("color", colour)?.unwrap_or([1.0; 3]);
    let shadow = table.take("shadow", switch)?.unwrap_or(false);
    let kinds: Vec<_> = kinds.into_iter().flatten().collect();
    let [places] = &kinds[..] else {
        let found = kinds.len();
        return Err(table.problem(format_args!("expected one of point, direction and area, found {found} of them")));
    };
    if lights.len() + places.len() > MOST_LIGHTS {
        let expected = format_args!("expected at most {MOST_LIGHTS} in all, each sample of an area counted");
        return Err(table.problem(format_args!("{} lights: {expected}", lights.len() + places.len())));
    }
    let color = color.map(|channel| channel / places.len() as f32);
    lights.extend(places.iter().map(|&kind| LightArg { kind, color, shadow }));
    table.finish()
}

/// The points that stand for a parallelogram: the middles of n x n equal parts of it, row by row.
fn area(mut table: Table<'_>) -> Result<Vec<LightKind>, Problem> {
    let corner = table.need("corner", point)?;
    let [along, across] = table.need("edges", edges)?;
    let n = table.need("samples", square)?;
    table.finish()?;
    let part = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    let place = |i, j| math::add_scaled(math::add_scaled(corner, along, part(i)), across, part(j));
    Ok((0..n).flat_map(|j| (0..n).map(move |i| LightKind::Point(place(i, j)))).collect())
}

fn point(value: &DeValue<'_>) -> Result<[f64; 3], String> {
    triple_of(&numbers(value)?)
}

fn direction(value: &DeValue<'_>) -> Result<[f64; 3], String> {
    direction_of(&numbers(value)?)
}

fn colour(value: &DeValue<'_>) -> Result<[f32; 3], String> {
    colour_of(&numbers(value)?)
}

/// Reads the two edges of a parallelogram at a corner.
fn edges(value: &DeValue<'_>) -> Result<[[f64; 3]; 2], String> {
    let expected = || "expected two edges, such as [[1, 0, 0], [0, 0, 1]]".to_owned();
    let found = value.as_array().ok_or_else(expected)?;
    let found = found.iter().map(|edge| point(edge.get_ref())).collect::<Result<Vec<_>, _>>()?;
    <[[f64; 3]; 2]>::try_from(found).map_err(|_| expected())
}

/// Reads how many parts a side has of the square number of them.
fn square(value: &DeValue<'_>) -> Result<u32, String> {
    let samples = whole(value, MOST_LIGHTS as u32)?;
    let side = (1..).take_while(|n| n * n <= samples).last().filter(|n| n * n == samples);
    side.ok_or_else(|| format!("{samples} samples: expected a square number, such as 1, 4, 9 or 16"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn parse(text: &str) -> View {
        View::parse(text).unwrap_or_else(|problem| panic!("{problem:?}\n{text}"))
    }

    #[test]
    fn a_file_is_what_flags_give() {
        let view = parse(
            "background = 0.5\nambient = [0, 0.1, 1e0]\neffects = \"phong,+mirror\"\n\
             [camera]\neye = [1, -2.5, 0x10]\nup = [0, 0, 1]\nfov = 60\n\
             [[light]]\npoint = [1, 2, 3]\nshadow = true\n\
             [[light]]\ndirection = [0, 1, 0]\ncolor = [1, 2, 3]\n",
        );
        let camera = CameraArgs {
            eye: Some([1.0, -2.5, 16.0]),
            view_up: Some([0.0, 0.0, 1.0]),
            fov: Some(60.0),
            ..CameraArgs::default()
        };
        assert_eq!((&view.camera, view.frames()), (&camera, None));
        assert_eq!((view.effects, parse("").effects), (Some(Effects::PHONG.union(Effects::MIRROR)), None));
        let lighting = &view.lighting;
        assert_eq!((lighting.background(), lighting.ambient()), ([0.5; 3], [0.0, 0.1, 1.0]));
        let lights = [
            LightArg { kind: LightKind::Point([1.0, 2.0, 3.0]), color: [1.0; 3], shadow: true },
            LightArg { kind: LightKind::Directional([0.0, 1.0, 0.0]), color: [1.0, 2.0, 3.0], shadow: false },
        ];
        assert_eq!((&lighting.lights[..], lighting.shadows), (&lights[..], false));

        // Flags win, part by part; an empty file changes nothing.
        let flags = CameraArgs { eye: Some([0.0; 3]), ..CameraArgs::default() };
        assert_eq!(view.camera(&flags), CameraArgs { eye: Some([0.0; 3]), ..camera });
        let flags = LightingArgs { lights: vec![lights[1]], ambient: Some([7.0; 3]), ..LightingArgs::default() };
        let both = view.lighting(&flags);
        assert_eq!((both.lights, both.ambient, both.background), (vec![lights[1]], Some([7.0; 3]), Some([0.5; 3])));
        assert_eq!(parse("").camera, CameraArgs::default());
    }

    #[test]
    fn an_area_is_the_middles_of_its_parts() {
        let area = "[[light]]\ncolor = [4, 8, 0]\n\
                    area = { corner = [1, 2, 3], edges = [[4, 0, 0], [0, 0, 8]], samples = 4 }\n";
        let found: Vec<_> = parse(area).lighting.lights.iter().map(|light| (light.kind, light.color)).collect();
        let points = [[2.0, 2.0, 5.0], [4.0, 2.0, 5.0], [2.0, 2.0, 9.0], [4.0, 2.0, 9.0]];
        assert_eq!(found, points.map(|point| (LightKind::Point(point), [1.0, 2.0, 0.0])));
    }

    #[test]
    fn between_a_path_and_the_camera() {
        let view = parse(
            "[camera]\neye = [9, 9, 9]\nfov = 30\n\
             [[path]]\nframe = 2\ntarget = [0, 0, 0]\n[[path]]\nframe = 4\ntarget = [2, 4, 8]\n",
        );
        assert_eq!(view.frames(), Some(2..=4));
        let middle = view.camera_at(3, &CameraArgs { fov: Some(50.0), ..CameraArgs::default() });
        assert_eq!((middle.target, middle.eye, middle.fov), (Some([1.0, 2.0, 4.0]), Some([9.0; 3]), Some(50.0)));
    }

    #[test]
    fn what_is_wrong_has_its_line() {
        let area = |rest: &str| format!("\n[[light]]\n[light.area]\ncorner = [0, 0, 0]\n{rest}");
        let edges = "edges = [[1, 0, 0], [0, 1, 0]]\n";
        let lights = format!("{}{}", "[[light]]\npoint = [1, 2, 3]\n".repeat(1000), &area(edges)[1..]);
        let cases = [
            // Not TOML.
            ("ambient = 1\n[camera\n".to_owned(), 2, "is not TOML"),
            ("ambient = 1\nambient = 2".to_owned(), 2, "is not TOML: duplicate key"),
            ("ambient = \"".to_owned(), 1, "is not TOML"),
            (format!("\nambient = {}", "[".repeat(100_000)), 2, "is not TOML"),
            // Unknown keys.
            (
                "\n\nlights = 1\n".to_owned(),
                3,
                "unknown key `lights`: expected ambient, background, effects, camera, light, path",
            ),
            ("[camera]\nfov = 9\nview_up = 1\n".to_owned(), 3, "camera: unknown key `view_up`: expected eye, target"),
            ("[[light]]\npoint = [1, 2, 3]\ncolour = 1\n".to_owned(), 3, "light 1: unknown key `colour`"),
            ("[[path]]\nframe = 1\nroll = 1\n".to_owned(), 3, "path 1: unknown key `roll`"),
            (area(&format!("{edges}samples = 4\nshadow = true\n")), 7, "light 1: area: unknown key `shadow`"),
            // Wrong types.
            ("ambient = \"bright\"".to_owned(), 1, "ambient: expected a number, found a string"),
            ("ambient = 1979-05-27".to_owned(), 1, "a date or time"),
            ("camera = 5".to_owned(), 1, "camera: expected a table, found a number"),
            ("\n[light]\npoint = [1, 2, 3]".to_owned(), 2, "light: expected [[light]], found a table"),
            ("path = [1]".to_owned(), 1, "path 1: expected a table, found a number"),
            ("[camera]\n\neye = [1, 2]".to_owned(), 3, "camera: eye: expected three numbers x,y,z, found 2"),
            ("[camera]\neye = [1, true, 2]".to_owned(), 2, "camera: eye: expected a number, found true or false"),
            ("[[light]]\npoint = [1, 2, 3]\nshadow = 1".to_owned(), 3, "light 1: shadow: expected true or false"),
            (area("edges = [[1, 0, 0]]\nsamples = 4\n"), 5, "light 1: area: edges: expected two edges"),
            ("\neffects = true".to_owned(), 2, "effects: expected a string, found true or false"),
            ("effects = [\"phong\"]".to_owned(), 1, "effects: expected a string, found an array"),
            // Out of range.
            ("ambient = 1\neffects = \"phong,mirror\"".to_owned(), 2, "effects: expected auto, phong or all, or +NAME"),
            ("background = [0, -1, 0]".to_owned(), 1, "background: a colour of -1"),
            ("ambient = nan".to_owned(), 1, "ambient: expected a finite number"),
            ("ambient = 1e999".to_owned(), 1, "ambient: expected a finite number"),
            ("[camera]\nfov = 180".to_owned(), 2, "camera: fov: expected degrees above 0 and below 180"),
            ("[camera]\nup = [0, 0, 0]".to_owned(), 2, "camera: up: expected a direction"),
            ("\n[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]".to_owned(), 2, "camera: eye and target are the same"),
            ("[[light]]\ndirection = [0, 0, 0]".to_owned(), 2, "light 1: direction: expected a direction"),
            (area(&format!("{edges}samples = 15\n")), 6, "light 1: area: samples: 15 samples: expected a square"),
            (area(&format!("{edges}samples = 2000\n")), 6, "samples: expected a whole number from 1 to 1024"),
            (format!("{lights}samples = 25\n"), 2001, "light 1001: 1025 lights: expected at most 1024"),
            ("[[path]]\nframe = 0".to_owned(), 2, "path 1: frame: expected a whole number from 1 to 9999"),
            ("[[path]]\nframe = 1.5".to_owned(), 2, "path 1: frame: expected a whole number"),
            ("[[path]]\nframe = 4\n[[path]]\nframe = 4".to_owned(), 3, "path 2: frame 4 after frame 4"),
            // What is missing, or there twice.
            ("[[path]]\neye = [1, 2, 3]".to_owned(), 1, "path 1: expected frame = ..."),
            (area(edges), 3, "light 1: area: expected samples = ..."),
            ("[[light]]\npoint = [1, 2, 3]\n[[light]]".to_owned(), 3, "light 2: expected one of point, direction and"),
            ("[[light]]\npoint = [1, 2, 3]\ndirection = [1, 2, 3]".to_owned(), 1, "area, found 2 of them"),
        ];
        for (text, line, expected) in cases {
            let error = View::parse(&text).expect_err(expected).in_file(Path::new("v.toml"), text.as_bytes());
            let start = format!("v.toml:{line}: ");
            let found = error.message();
            assert!(found.starts_with(&start) && found.contains(expected), "{found}\nexpected {start}...{expected}");
        }
    }
}
