//! The flags that several commands share, and how their values are read. Defaults stand in the help texts; a flag that
//! was not given stays `None` where its absence matters.

use std::fmt;
use std::path::Path;

use clap::{Args, ValueEnum};
use voxdag::camera::Camera;
use voxdag::geometry::Geometry;
use voxdag::materials::AnyMaterials;
use voxdag::normal::NormalKind;
use voxdag::render::{Samples, Supersample};
use voxdag::trace::Arithmetic;

use crate::error::{Error, Kind};
use crate::memory::Memory;
use crate::report::number as number_text;

/// How the mesh becomes voxels.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Building")]
pub struct BuildArgs {
    /// Voxels along the longest axis, 1 to 2097152 [default: 512]
    #[arg(short, long, value_name = "N", value_parser = resolution, allow_negative_numbers = true)]
    pub resolution: Option<u32>,

    /// Side of a voxel in the mesh's units, instead of a resolution
    #[arg(long, value_name = "S", value_parser = positive, allow_hyphen_values = true)]
    pub voxel_size: Option<f64>,

    /// World position of the corner of voxel (0, 0, 0) [default: the minimum of the mesh's box]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub origin: Option<[f64; 3]>,

    /// Which voxels a triangle fills [default: exact]
    #[arg(long, value_name = "COVER", value_enum)]
    pub cover: Option<CoverArg>,

    /// How the filled voxels are laid out [default: dag]
    #[arg(long, value_name = "KIND", value_enum)]
    pub geometry: Option<GeometryArg>,

    /// What is kept of the surfaces [default: tree]
    #[arg(long, value_name = "KIND", value_enum)]
    pub materials: Option<MaterialsArg>,

    /// The axis that points up; kept in the file for `render` [default: y]
    #[arg(long, value_name = "AXIS", value_enum)]
    pub up_axis: Option<UpAxisArg>,
}

impl BuildArgs {
    /// Refuses flags that contradict each other.
    pub fn check(&self) -> Result<(), Error> {
        if self.resolution.is_some() && self.voxel_size.is_some() && self.origin.is_none() {
            return Err(Error::usage("--resolution and --voxel-size together leave open where the grid lies")
                .hint("give one of the two, or add --origin X,Y,Z"));
        }
        Ok(())
    }

    /// Refuses what no file holds.
    pub fn must_be_for_files(&self) -> Result<(), Error> {
        let refused = |flag: &str, kinds: &str| {
            Err(Error::usage(format_args!("{flag}: that is built in memory only, for `render` and `bench`"))
                .hint(format_args!("a file takes {kinds}")))
        };
        if self.geometry.is_some_and(|geometry| !geometry.is_for_files()) {
            return refused("--geometry", "dag or ssvdag");
        }
        if self.materials.is_some_and(|materials| !materials.is_for_files()) {
            return refused("--materials", "tree, table, table-normals, ranked or none");
        }
        Ok(())
    }

    /// Refuses flags of building for a scene that was built before.
    pub fn must_be_absent(&self, scene: &Path) -> Result<(), Error> {
        match self.given() {
            Some(flag) => Err(Error::usage(format_args!("{flag}: {} is built already", scene.display()))
                .hint("leave the flag away, or name the mesh instead of the scene")),
            None => Ok(()),
        }
    }

    /// The first of these flags that was given, as it is typed.
    fn given(&self) -> Option<&'static str> {
        let flags = [
            (self.resolution.is_some(), "--resolution"),
            (self.voxel_size.is_some(), "--voxel-size"),
            (self.origin.is_some(), "--origin"),
            (self.cover.is_some(), "--cover"),
            (self.geometry.is_some(), "--geometry"),
            (self.materials.is_some(), "--materials"),
            (self.up_axis.is_some(), "--up-axis"),
        ];
        flags.into_iter().find_map(|(given, flag)| given.then_some(flag))
    }

    /// The flags that were given, as they can be typed again after other words for `build`, which makes files.
    pub fn typed(&self) -> String {
        fn name<T: ValueEnum>(value: T) -> String {
            value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
        }
        let flags = [
            self.resolution.map(|n| format!(" -r {n}")),
            self.voxel_size.map(|s| format!(" --voxel-size {}", number_text(s))),
            self.origin.map(|[x, y, z]| format!(" --origin {},{},{}", number_text(x), number_text(y), number_text(z))),
            self.cover.map(|cover| format!(" --cover {}", name(cover))),
            self.geometry.filter(|geometry| geometry.is_for_files()).map(|g| format!(" --geometry {}", name(g))),
            self.materials
                .filter(|materials| materials.is_for_files())
                .map(|materials| format!(" --materials {}", name(materials))),
            self.up_axis.map(|axis| format!(" --up-axis {}", name(axis))),
        ];
        flags.into_iter().flatten().collect()
    }
}

/// Which voxels a triangle fills.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum CoverArg {
    /// Every voxel that the triangle meets: no gap
    #[default]
    Exact,
    /// Fewer: a thin sheet (6-separating) whose edges let some rays through
    Thin,
    /// A little more, so that it also covers the vertices before they are snapped to the grid
    Inflated,
}

/// What is kept of the surfaces.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum MaterialsArg {
    /// A tree over space: the smallest and the fastest
    #[default]
    Tree,
    /// A table from voxel to material
    Table,
    /// A table from voxel to material and normal
    TableNormals,
    /// Packed numbers in the order of the voxels, found by rank
    Ranked,
    /// The same in blocks with palettes of their own; in memory only
    Palette,
    /// Williams's moxel table; in memory only
    Moxel,
    /// Williams's moxel table with normals; in memory only
    MoxelNormals,
    /// Shape only
    None,
}

impl MaterialsArg {
    /// Whether a file can hold it.
    fn is_for_files(self) -> bool {
        !matches!(self, MaterialsArg::Palette | MaterialsArg::Moxel | MaterialsArg::MoxelNormals)
    }
}

impl GeometryArg {
    /// Whether a file can hold it.
    fn is_for_files(self) -> bool {
        matches!(self, GeometryArg::Dag | GeometryArg::Ssvdag)
    }
}

/// How the filled voxels are laid out.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum GeometryArg {
    /// The sparse voxel DAG: the fastest
    #[default]
    Dag,
    /// Merged up to mirrors, too, and packed: about 0.4 of the bytes, rays take 1.1 of the time
    Ssvdag,
    /// The octree without sharing; in memory only
    Svo,
    /// The DAG with offsets in its pointers; in memory only
    Offsets,
    /// Williams's moxel DAG; in memory only
    Moxel,
}

/// The axis that points up.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum UpAxisArg {
    /// As most modelling programs write OBJ
    #[default]
    Y,
    /// As CAD, GIS and Blender's own axes
    Z,
}

/// From where the scene is seen.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Picture")]
pub struct CameraArgs {
    /// Where the camera stands [default: in front, to the right and above, twice half the box's diagonal away]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,

    /// What it looks at [default: the centre of the mesh's box]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub target: Option<[f64; 3]>,

    /// Which way is up in the picture [default: the up axis]
    ///
    /// If the view runs along it, the axis that is farthest from the view is up, z before y before x.
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    pub view_up: Option<[f64; 3]>,

    /// Vertical field of view in degrees, above 0 and below 180 [default: 45]
    #[arg(long, value_name = "DEG", value_parser = field_of_view, allow_hyphen_values = true)]
    pub fov: Option<f64>,
}

/// How the scene is seen and lit.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Picture")]
pub struct PictureArgs {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = picture_size, allow_hyphen_values = true)]
    pub size: [u32; 2],

    #[command(flatten)]
    pub camera: CameraArgs,

    /// A point light and its colour; may be repeated [default: one white light above the eye]
    #[arg(long = "light", value_name = "X,Y,Z[,R,G,B]", value_parser = light, allow_hyphen_values = true)]
    pub lights: Vec<LightArg>,

    /// Light from everywhere: one number or three
    #[arg(long, value_name = "R,G,B", default_value = "0.2", value_parser = colour, allow_hyphen_values = true)]
    pub ambient: [f32; 3],

    /// Where the surface's direction is taken from
    #[arg(long, value_name = "KIND", value_enum, default_value_t)]
    pub normals: NormalsArg,

    /// Rays per pixel: 1, 4, 5 (centre and four around it), 16 or 64 [default: 4, with --supersample 16]
    #[arg(long, value_name = "N", value_parser = samples, allow_negative_numbers = true)]
    pub samples: Option<Samples>,

    /// Pixels that take all these rays: all, near[:SHARE], region:X0,Y0,X1,Y1, adaptive[:DEGREES] [default: all]
    ///
    /// near:     the middle shows the nearer SHARE (0.5) of the voxels along the view; one ray elsewhere
    /// region:   columns X0 to X1 and rows Y0 to Y1, the last ones excluded; one ray elsewhere
    /// adaptive: the corners do not see one smooth surface, of one material and with normals within DEGREES (2);
    ///           these four rays elsewhere
    #[arg(long, value_name = "WHICH", value_parser = supersample, verbatim_doc_comment, allow_hyphen_values = true)]
    pub supersample: Option<SupersampleArg>,

    /// How rays are followed
    #[arg(long, value_name = "KIND", value_enum, default_value_t)]
    pub arithmetic: ArithmeticArg,
}

impl PictureArgs {
    /// The samples per pixel that the flags ask for, if they do not contradict each other.
    pub fn samples(&self) -> Result<Samples, Error> {
        let Some(which) = self.supersample else { return Ok(self.samples.unwrap_or(Samples::Four)) };
        let samples = self.samples.unwrap_or(Samples::Sixteen);
        let [width, height] = self.size;
        match which {
            SupersampleArg::All => Ok(samples),
            _ if samples == Samples::One => {
                Err(Error::usage(format_args!("--supersample {which}: --samples 1 leaves no more to take"))
                    .hint("leave --samples away, or take 4, 5, 16 or 64"))
            }
            SupersampleArg::Adaptive(_) if samples.count() < 16 => Err(Error::usage(format_args!(
                "--supersample {which}: it begins with 4 rays per pixel, which leaves nothing to gain with --samples {}",
                samples.count()
            ))
            .hint("leave --samples away, or take 16 or 64")),
            SupersampleArg::Region([_, _, x1, y1]) if x1 > width || y1 > height => {
                Err(Error::usage(format_args!("--supersample {which} reaches beyond a picture of {width}x{height}"))
                    .hint("make --size larger or the region smaller"))
            }
            _ => Ok(samples),
        }
    }

    /// The core's name for the pixels that take all samples.
    pub fn supersample(&self, geometry: impl Geometry, camera: &Camera) -> Supersample {
        match self.supersample {
            None | Some(SupersampleArg::All) => Supersample::All,
            Some(SupersampleArg::Near(share)) => Supersample::near(geometry, camera, share),
            Some(SupersampleArg::Region([x0, y0, x1, y1])) => Supersample::Region { from: [x0, y0], to: [x1, y1] },
            Some(SupersampleArg::Adaptive(degrees)) => Supersample::Adaptive { degrees },
        }
    }
}

/// Which pixels take all samples, as it is typed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum SupersampleArg {
    All,
    /// The share of the voxels' range, 0 to 1.
    Near(f64),
    /// First column and row, and those after the last ones.
    Region([u32; 4]),
    /// Degrees, 0 to 90.
    Adaptive(f32),
}

impl fmt::Display for SupersampleArg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SupersampleArg::All => f.write_str("all"),
            SupersampleArg::Near(share) => write!(f, "near:{share}"),
            SupersampleArg::Region([x0, y0, x1, y1]) => write!(f, "region:{x0},{y0},{x1},{y1}"),
            SupersampleArg::Adaptive(degrees) => write!(f, "adaptive:{degrees}"),
        }
    }
}

/// A light as it is typed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LightArg {
    /// World position.
    pub position: [f64; 3],
    /// Linear light, 0 and up.
    pub color: [f32; 3],
}

/// Where the surface's direction is taken from.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum NormalsArg {
    /// The voxel's side through which the ray came in
    Face,
    /// The triangle's, kept by `--materials table-normals`
    Stored,
    /// The six neighbours
    Gradient,
    /// A plane through the 3^3 voxels around
    Plane1,
    /// A plane through the 5^3 voxels around
    #[default]
    Plane2,
    /// A plane through the 7^3 voxels around
    Plane3,
    /// A plane through the 3^3 voxels around by weighted regressions, as in Pineda's thesis
    Ernerfeldt1,
    /// The same through the 5^3 voxels around
    Ernerfeldt2,
}

impl NormalsArg {
    /// The core's name for it, if the scene's materials can give it.
    pub fn kind(self, materials: &AnyMaterials<'_>) -> Result<NormalKind, Error> {
        let stored = materials.has_normals();
        Ok(match self {
            NormalsArg::Face => NormalKind::Face,
            NormalsArg::Stored if stored => NormalKind::Stored,
            NormalsArg::Stored => {
                return Err(Error::usage("--normals stored: the scene has no stored normals")
                    .hint("build it with --materials table-normals (or moxel-normals, in memory)"));
            }
            NormalsArg::Gradient => NormalKind::Gradient,
            NormalsArg::Plane1 => NormalKind::Plane1,
            NormalsArg::Plane2 => NormalKind::Plane2,
            NormalsArg::Plane3 => NormalKind::Plane3,
            NormalsArg::Ernerfeldt1 => NormalKind::Ernerfeldt1,
            NormalsArg::Ernerfeldt2 => NormalKind::Ernerfeldt2,
        })
    }
}

/// How rays are followed.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum ArithmeticArg {
    /// Right for every ray
    #[default]
    Exact,
    /// Rounded; may miss by a voxel where a ray runs along an edge
    F64,
}

impl ArithmeticArg {
    /// The core's name for it.
    pub fn kind(self) -> Arithmetic {
        match self {
            ArithmeticArg::Exact => Arithmetic::Exact,
            ArithmeticArg::F64 => Arithmetic::F64,
        }
    }
}

/// What the machine may give.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Machine")]
pub struct MachineArgs {
    /// Threads to work with [default: all cores]
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<u16>,

    /// Most memory to take, such as 512M, 4G or 1.5GiB; a run that needs more stops before it takes it
    ///
    /// Counted are, as far as they are held together: the files that are read; about what parsing a mesh takes; the
    /// mesh; what building takes (sorted triangles, owners of voxels, DAG, other layouts, materials); the scene; and
    /// the picture (8 bytes a pixel). The program itself is not counted: a few MiB.
    #[arg(long, value_name = "SIZE", verbatim_doc_comment, value_parser = memory_size, allow_hyphen_values = true)]
    pub memory_limit: Option<u64>,
}

impl MachineArgs {
    /// The account of `--memory-limit`.
    pub fn memory(&self) -> Memory {
        Memory::new(self.memory_limit)
    }

    /// The threads that the run works on.
    pub fn pool(&self) -> Result<rayon::ThreadPool, Error> {
        rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.unwrap_or(0).into())
            .build()
            .map_err(|cause| Error::new(Kind::Failure, cause).hint("try fewer --threads"))
    }
}

/// How the result is printed.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct ReportArgs {
    /// Print the result as JSON to stdout
    #[arg(long)]
    pub json: bool,
}

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("`{text}` is not a finite number")),
        Err(_) => Err(format!("`{text}` is not a number")),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(number).collect()
}

fn triple(text: &str) -> Result<[f64; 3], String> {
    let found = numbers(text)?;
    <[f64; 3]>::try_from(found).map_err(|found| format!("expected three numbers x,y,z, found {}", found.len()))
}

fn linear(parts: &[f64]) -> Result<[f32; 3], String> {
    let mut color = [0.0; 3];
    for (to, &from) in color.iter_mut().zip(parts) {
        *to = from as f32;
        if from < 0.0 || !to.is_finite() {
            let from = number_text(from);
            return Err(format!("a colour of {from}: expected 0 (none), 1 (full) or more, at most 3.4e38"));
        }
    }
    Ok(color)
}

fn colour(text: &str) -> Result<[f32; 3], String> {
    match numbers(text)?[..] {
        [grey] => linear(&[grey; 3]),
        [r, g, b] => linear(&[r, g, b]),
        ref found => Err(format!("expected one number or three r,g,b, found {}", found.len())),
    }
}

fn light(text: &str) -> Result<LightArg, String> {
    match numbers(text)?[..] {
        [x, y, z] => Ok(LightArg { position: [x, y, z], color: [1.0; 3] }),
        [x, y, z, r, g, b] => Ok(LightArg { position: [x, y, z], color: linear(&[r, g, b])? }),
        ref found => Err(format!("expected three numbers x,y,z or six x,y,z,r,g,b, found {}", found.len())),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    let x = number(text)?;
    if x > 0.0 { Ok(x) } else { Err("expected a number greater than 0".to_owned()) }
}

fn field_of_view(text: &str) -> Result<f64, String> {
    let x = number(text)?;
    if x > 0.0 && x < 180.0 { Ok(x) } else { Err("expected degrees above 0 and below 180".to_owned()) }
}

fn direction(text: &str) -> Result<[f64; 3], String> {
    match triple(text)? {
        [0.0, 0.0, 0.0] => Err("expected a direction, such as 0,1,0: it cannot be 0,0,0".to_owned()),
        v => Ok(v),
    }
}

fn resolution(text: &str) -> Result<u32, String> {
    let found = text.parse().ok().filter(|n| (1..=1 << 21).contains(n));
    found.ok_or_else(|| "expected a whole number from 1 to 2097152".to_owned())
}

fn threads(text: &str) -> Result<u16, String> {
    let found = text.parse().ok().filter(|n| (1..=1024).contains(n));
    found.ok_or_else(|| "expected a whole number from 1 to 1024".to_owned())
}

fn samples(text: &str) -> Result<Samples, String> {
    text.parse().ok().and_then(Samples::new).ok_or_else(|| "expected 1, 4, 5, 16 or 64".to_owned())
}

/// Reads which pixels take all samples.
pub fn supersample(text: &str) -> Result<SupersampleArg, String> {
    let (name, value) = text.split_once(':').map_or((text, None), |(name, value)| (name, Some(value)));
    let within = |value: Option<&str>, usual: f64, largest: f64| match value.map_or(Ok(usual), number)? {
        x if (0.0..=largest).contains(&x) => Ok(x),
        _ => Err(format!("expected a number from 0 to {largest} after `{name}:`")),
    };
    match (name, value) {
        ("all", None) => Ok(SupersampleArg::All),
        ("near", _) => Ok(SupersampleArg::Near(within(value, 0.5, 1.0)?)),
        ("adaptive", _) => Ok(SupersampleArg::Adaptive(within(value, 2.0, 90.0)? as f32)),
        ("region", Some(value)) => {
            let expected = || "expected region:X0,Y0,X1,Y1 in pixels, X0 below X1 and Y0 below Y1".to_owned();
            let corners =
                value.split(',').map(|x| x.parse().ok()).collect::<Option<Vec<u32>>>().ok_or_else(expected)?;
            match corners[..] {
                [x0, y0, x1, y1] if x0 < x1 && y0 < y1 => Ok(SupersampleArg::Region([x0, y0, x1, y1])),
                _ => Err(expected()),
            }
        }
        _ => Err("expected all, near[:SHARE], region:X0,Y0,X1,Y1 or adaptive[:DEGREES]".to_owned()),
    }
}

/// Largest side of a picture: PNG readers and graphics cards stop there.
const MAX_SIDE: u32 = 32768;

/// Reads `WIDTHxHEIGHT`.
pub fn picture_size(text: &str) -> Result<[u32; 2], String> {
    let expected = || format!("expected WIDTHxHEIGHT, such as 1280x720, each 1 to {MAX_SIDE}");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(expected)?;
    let side = |text: &str| text.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n)).ok_or_else(expected);
    Ok([side(width)?, side(height)?])
}

fn memory_size(text: &str) -> Result<u64, String> {
    let expected = || "expected a size such as 512M, 4G or 1.5GiB (K, M, G, T: powers of 1024)".to_owned();
    let unit_at = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (value, unit) = text.split_at(unit_at);
    let scale: u64 = match unit.to_ascii_lowercase().as_str() {
        "" | "b" => 1,
        "k" | "kib" => 1 << 10,
        "m" | "mib" => 1 << 20,
        "g" | "gib" => 1 << 30,
        "t" | "tib" => 1 << 40,
        "kb" => 1_000,
        "mb" => 1_000_000,
        "gb" => 1_000_000_000,
        "tb" => 1_000_000_000_000,
        _ => return Err(expected()),
    };
    let bytes = value.parse::<f64>().map_err(|_| expected())? * scale as f64;
    if bytes >= 1.0 && bytes < u64::MAX as f64 { Ok(bytes as u64) } else { Err(expected()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_memory() {
        assert_eq!(memory_size("512M"), Ok(512 << 20));
        assert_eq!(memory_size("1.5GiB"), Ok(3 << 29));
        assert_eq!(memory_size("2gb"), Ok(2_000_000_000));
        assert_eq!(memory_size("77"), Ok(77));
        for wrong in ["", "0", "G", "4X", "-1G", "1e3", "1..2", "99999999999T"] {
            assert!(memory_size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn vectors_are_finite_and_have_the_right_length() {
        assert_eq!(triple("-1,2.5,3e2"), Ok([-1.0, 2.5, 300.0]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,nan", "inf,0,0", "1e999,0,0", "a,b,c", "1,,2"] {
            assert!(triple(wrong).is_err(), "{wrong}");
        }
        assert_eq!(colour("0.5"), Ok([0.5; 3]));
        assert!(colour("-0.1").is_err() && colour("1,2").is_err() && colour("1e300").is_err());
        assert_eq!(light("1,2,3").unwrap().color, [1.0; 3]);
        assert!(light("1,2,3,4").is_err());
    }

    #[test]
    fn pixels_to_supersample() {
        use SupersampleArg::*;
        for (text, which) in [
            ("all", All),
            ("near", Near(0.5)),
            ("near:0.25", Near(0.25)),
            ("region:0,1,2,3", Region([0, 1, 2, 3])),
            ("adaptive", Adaptive(2.0)),
            ("adaptive:7.5", Adaptive(7.5)),
        ] {
            assert_eq!(supersample(text), Ok(which));
            assert_eq!(supersample(&which.to_string()), Ok(which));
        }
        for wrong in ["", "none", "all:1", "near:", "near:1.5", "near:-1", "near:nan", "adaptive:91", "adaptive:x"] {
            assert!(supersample(wrong).is_err(), "{wrong}");
        }
        for wrong in
            ["region", "region:1,2,3", "region:1,2,3,4,5", "region:3,0,3,9", "region:0,9,9,0", "region:-1,0,3,9"]
        {
            assert!(supersample(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_of_pictures() {
        assert_eq!(picture_size("640x480"), Ok([640, 480]));
        for wrong in ["640", "0x1", "1x0", "40000x1", "-1x5", "axb"] {
            assert!(picture_size(wrong).is_err(), "{wrong}");
        }
    }
}
