//! From where a scene is seen: the thesis's five from places chosen by eye after its figure 5.1, all others as a whole.

use voxdag::camera::Camera;
use voxdag::grid::{Bounds, UpAxis};
use voxdag::shade::LightKind;

use super::published::Published;
use crate::options::{CameraArgs, LightArg};

/// Places in parts of the mesh's box: 0 is its minimum, 1 its maximum.
struct Inside {
    eye: [f64; 3],
    target: [f64; 3],
    light: [f64; 3],
    fov: f64,
}

const INSIDE: [(&str, Inside); 5] = [
    ("bunny", Inside { eye: [0.5, 0.5, 0.98], target: [0.44, 0.46, 0.5], light: [0.66, 0.86, 0.94], fov: 60.0 }),
    ("buddha", Inside { eye: [0.5, 0.5, 0.99], target: [0.5, 0.51, 0.5], light: [0.7, 0.86, 0.94], fov: 100.0 }),
    ("dragon", Inside { eye: [0.5, 0.5, 2.2], target: [0.5, 0.45, 0.5], light: [0.74, 0.83, 0.91], fov: 42.0 }),
    ("sponza", Inside { eye: [0.06, 0.2, 0.5], target: [0.5, 0.28, 0.5], light: [0.12, 0.35, 0.5], fov: 65.0 }),
    ("conference", Inside { eye: [0.89, 0.46, 0.9], target: [0.49, 0.16, 0.5], light: [0.85, 0.75, 0.85], fov: 60.0 }),
];

/// A camera and its lights; none stands for the usual one, above the eye.
pub struct View {
    pub camera: CameraArgs,
    pub lights: Vec<LightArg>,
    /// Whether it is the place that the thesis's scene is seen from.
    pub built_in: bool,
}

impl View {
    /// What the flags say; without any, what suits the thesis's scene.
    pub fn of(published: Option<&Published>, bounds: &Bounds, up: UpAxis, flags: &CameraArgs) -> View {
        let place =
            |part: [f64; 3]| core::array::from_fn(|i| bounds.min[i] + part[i] * (bounds.max[i] - bounds.min[i]));
        let by_hand = flags.eye.is_some() || flags.target.is_some() || flags.view_up.is_some() || flags.fov.is_some();
        match published.and_then(|scene| INSIDE.iter().find(|(name, _)| *name == scene.name)) {
            Some((_, inside)) if !by_hand => {
                let (eye, target) = (Some(place(inside.eye)), Some(place(inside.target)));
                let light = LightArg { kind: LightKind::Point(place(inside.light)), color: [1.0; 3], shadow: false };
                let camera = CameraArgs { eye, target, view_up: None, fov: Some(inside.fov) };
                View { camera, lights: vec![light], built_in: true }
            }
            _ => {
                let framing = Camera::framing(bounds, up);
                let target = flags.target.unwrap_or(framing.target);
                let eye = core::array::from_fn(|i| target[i] + (framing.eye[i] - framing.target[i]));
                let camera = CameraArgs {
                    eye: Some(flags.eye.unwrap_or(eye)),
                    target: Some(target),
                    view_up: flags.view_up,
                    fov: Some(flags.fov.unwrap_or(framing.fov_y)),
                };
                View { camera, lights: Vec::new(), built_in: false }
            }
        }
    }

    /// The flags of `render` that draw from there.
    pub fn flags(&self, [width, height]: [u32; 2]) -> String {
        let mut flags = format!("--size {width}x{height} --effects phong {}", self.camera.typed());
        for light in &self.lights {
            flags += &format!(" {}", light.typed());
        }
        flags
    }
}
