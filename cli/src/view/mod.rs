//! View files: camera, lights, background and a camera path in TOML (`--view`; docs/view.md has the format).
//!
//! In: a file. Out: what flags would have given, and the path. Values are checked as those of flags are, and a key that
//! is not known is refused; an error names file and line. An area light becomes point lights on a grid of it.

mod path;
mod table;

use std::io::Read;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use toml::de::DeValue;
use voxdag::math;
use voxdag::shade::LightKind;

use crate::error::{Error, Result};
use crate::input;
use crate::options::values::{LAST_FRAME, colour_of, direction_of, field_of_view_of, triple_of};
use crate::options::{CameraArgs, LightArg, LightingArgs, ViewArgs};
use path::{CameraPath, Key};
use table::{Problem, Table, number, numbers, switch, whole};

/// Most bytes of a view file: far more than a path of a key per frame takes.
const MOST_BYTES: u64 = 1 << 22;
/// Most lights, each point of an area light counted.
const MOST_LIGHTS: usize = 1024;

/// What a view file says; without a file nothing.
#[derive(Debug, Default)]
pub struct View {
    /// The file.
    pub file: Option<PathBuf>,
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
        let text = String::from_utf8(bytes).ok().filter(|text| text.len() as u64 <= MOST_BYTES);
        let text = text.ok_or_else(|| Error::input(path, "is not a view file: not a TOML text of at most 4 MiB"))?;
        let view = View::parse(&text).map_err(|problem| problem.in_file(path, &text))?;
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
