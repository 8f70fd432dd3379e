//! The flags of pictures: from where a scene is seen, how it is lit, and with how many rays of what kind.

use std::fmt;

use clap::{Args, ValueEnum};
use voxdag::camera::Camera;
use voxdag::effects::Effects;
use voxdag::geometry::Geometry;
use voxdag::normal::NormalKind;
use voxdag::render::{Samples, Settings, Supersample};
use voxdag::shade::LightKind;
use voxdag::trace::Arithmetic;

use super::values::{
    colour, direction, effects, field_of_view, lift, light, picture_size, samples, sun, supersample, triple,
};
use crate::error::Error;
use crate::report::number;

/// From where the scene is seen.
#[derive(Args, Clone, PartialEq, Debug, Default)]
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

impl CameraArgs {
    /// These flags, and `other` ones where they were not given.
    pub fn or(&self, other: &CameraArgs) -> CameraArgs {
        CameraArgs {
            eye: self.eye.or(other.eye),
            target: self.target.or(other.target),
            view_up: self.view_up.or(other.view_up),
            fov: self.fov.or(other.fov),
        }
    }

    /// The flags that give a camera.
    pub fn typed_of(camera: &Camera) -> String {
        let Camera { eye, target, up, fov_y } = *camera;
        CameraArgs { eye: Some(eye), target: Some(target), view_up: Some(up), fov: Some(fov_y) }.typed()
    }

    /// The flags that were given, as they can be typed again.
    pub fn typed(&self) -> String {
        let CameraArgs { eye, target, view_up, fov } = self;
        let places = [("eye", eye), ("target", target), ("view-up", view_up)];
        let mut flags: Vec<_> =
            places.iter().filter_map(|(name, v)| Some(format!("--{name}={}", numbers((**v)?)))).collect();
        flags.extend(fov.map(|fov| format!("--fov {}", number(fov))));
        flags.join(" ")
    }
}

/// Numbers as flags take them.
fn numbers(numbers: impl IntoIterator<Item = impl Into<f64>>) -> String {
    numbers.into_iter().map(|x| number(x.into())).collect::<Vec<_>>().join(",")
}

/// How the scene is lit.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Picture")]
pub struct LightingArgs {
    /// A point light and its colour; may be repeated [default: one white light above the eye]
    #[arg(long = "light", value_name = "X,Y,Z[,R,G,B]", value_parser = light, allow_hyphen_values = true)]
    pub lights: Vec<LightArg>,

    /// A light infinitely far away in this direction, and its colour; may be repeated
    #[arg(long = "sun", value_name = "X,Y,Z[,R,G,B]", value_parser = sun, allow_hyphen_values = true)]
    pub suns: Vec<LightArg>,

    /// Let all lights cast shadows, the default one included: a ray from each surface to each light that it faces
    #[arg(long)]
    pub shadows: bool,

    /// Light from everywhere: one number or three [default: 0.2]
    #[arg(long, value_name = "R,G,B", value_parser = colour, allow_hyphen_values = true)]
    pub ambient: Option<[f32; 3]>,

    /// Colour where there is nothing, as linear light: one number or three [default: 0.73,0.76,0.79]
    #[arg(long, value_name = "R,G,B", value_parser = colour, allow_hyphen_values = true)]
    pub background: Option<[f32; 3]>,
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

    #[command(flatten)]
    pub lighting: LightingArgs,

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

    /// Effects to draw, of those that the scene calls for: auto, phong, or such as -mirror [default: auto]
    ///
    /// auto, all: all of them
    /// phong:     highlights alone, as in Pineda's thesis
    /// -NAME and +NAME, by commas, take from auto, or after `phong,` add to it:
    /// specular, shadows, mirror, transparency, refraction, emission, textures
    #[arg(long, value_name = "SET", value_parser = effects, verbatim_doc_comment, allow_hyphen_values = true)]
    pub effects: Option<Effects>,

    /// How high above a surface rays to lights and mirrored ones start, in heights of its steps [default: 1]
    ///
    /// Where the way there is free. At 0 thin shadows begin at once, and a surface's steps shade each other.
    #[arg(long, value_name = "H", value_parser = lift, allow_hyphen_values = true)]
    pub lift: Option<f32>,

    /// Level of detail: voxels 2^L times as large, of which one is filled if anything in it is
    #[arg(long, value_name = "L", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=20))]
    pub lod: u8,
}

impl LightingArgs {
    /// These flags, and `other` ones where they were not given; the lights are all from one of the two.
    pub fn or(&self, other: &LightingArgs) -> LightingArgs {
        let from = if self.is_without_lights() { other } else { self };
        LightingArgs {
            lights: from.lights.clone(),
            suns: from.suns.clone(),
            shadows: self.shadows || other.shadows,
            ambient: self.ambient.or(other.ambient),
            background: self.background.or(other.background),
        }
    }

    /// Whether the default light is to shine.
    pub fn is_without_lights(&self) -> bool {
        self.lights.is_empty() && self.suns.is_empty()
    }

    /// Linear light from everywhere.
    pub fn ambient(&self) -> [f32; 3] {
        self.ambient.unwrap_or(Settings::default().ambient)
    }

    /// Linear colour where there is nothing.
    pub fn background(&self) -> [f32; 3] {
        self.background.unwrap_or(Settings::default().background)
    }

    /// These flags, as they can be typed again.
    pub fn typed(&self) -> String {
        let mut flags: Vec<_> = self.lights.iter().chain(&self.suns).map(LightArg::typed).collect();
        flags.extend(self.shadows.then(|| "--shadows".to_owned()));
        flags.extend(self.ambient.map(|colour| format!("--ambient {}", numbers(colour))));
        flags.extend(self.background.map(|colour| format!("--background {}", numbers(colour))));
        flags.join(" ")
    }
}

impl PictureArgs {
    /// The effects that may be drawn.
    pub fn effects(&self) -> Effects {
        self.effects.unwrap_or(Effects::ALL)
    }

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

/// A light as it is typed, or as a view file has it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LightArg {
    /// In the world.
    pub kind: LightKind,
    /// Linear light, 0 and up.
    pub color: [f32; 3],
    /// Whether it casts shadows, also without `--shadows`; only files say so.
    pub shadow: bool,
}

impl LightArg {
    /// The flag that gives it, but for its own shadow.
    pub fn typed(&self) -> String {
        let colour = if self.color == [1.0; 3] { String::new() } else { format!(",{}", numbers(self.color)) };
        let (flag, place) = match self.kind {
            LightKind::Point(position) => ("light", position),
            LightKind::Directional(towards) => ("sun", towards),
        };
        format!("--{flag}={}{colour}", numbers(place))
    }
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
    /// The core's name for it, if the scene can give it: whether its materials have `stored` normals.
    pub fn kind(self, stored: bool) -> Result<NormalKind, Error> {
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
    /// Rounded coarsely where many rays are followed at once: a preview
    F32,
}

impl ArithmeticArg {
    /// The core's name for it.
    pub fn kind(self) -> Arithmetic {
        match self {
            ArithmeticArg::Exact => Arithmetic::Exact,
            ArithmeticArg::F64 => Arithmetic::F64,
            ArithmeticArg::F32 => Arithmetic::F32,
        }
    }
}
