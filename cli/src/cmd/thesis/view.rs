//! From where a scene is seen: the thesis's five as in its figure 5.1, as far as the text tells, all others as a whole.

use voxdag::camera::Camera;
use voxdag::grid::{Bounds, UpAxis};

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
    ("bunny", Inside { eye: [0.5, 0.5, 0.98], target: [0.5, 0.46, 0.5], light: [0.66, 0.86, 0.94], fov: 60.0 }),
    ("buddha", Inside { eye: [0.5, 0.5, 0.99], target: [0.5, 0.44, 0.5], light: [0.7, 0.86, 0.94], fov: 80.0 }),
    ("dragon", Inside { eye: [0.5, 0.5, 2.2], target: [0.5, 0.45, 0.5], light: [0.74, 0.83, 0.91], fov: 42.0 }),
    ("sponza", Inside { eye: [0.06, 0.2, 0.5], target: [0.5, 0.28, 0.5], light: [0.2, 0.5, 0.5], fov: 65.0 }),
    ("conference", Inside { eye: [0.89, 0.46, 0.9], target: [0.49, 0.16, 0.5], light: [0.7, 0.8, 0.7], fov: 60.0 }),
];

/// Camera and light of a scene: what the flags say, then what suits the thesis's scene.
pub fn of(
    published: Option<&Published>,
    bounds: &Bounds,
    up: UpAxis,
    flags: &CameraArgs,
) -> (CameraArgs, Vec<LightArg>) {
    let place = |part: [f64; 3]| core::array::from_fn(|i| bounds.min[i] + part[i] * (bounds.max[i] - bounds.min[i]));
    let known = published.and_then(|scene| INSIDE.iter().find(|(name, _)| *name == scene.name));
    let by_hand = flags.eye.is_some() || flags.target.is_some();
    match known {
        Some((_, inside)) if !by_hand => {
            let (eye, target) = (Some(place(inside.eye)), Some(place(inside.target)));
            let light = LightArg { position: place(inside.light), color: [1.0; 3] };
            (CameraArgs { eye, target, view_up: flags.view_up, fov: inside.fov }, vec![light])
        }
        _ => {
            let framing = Camera::framing(bounds, up);
            let eye = flags.eye.unwrap_or(framing.eye);
            (CameraArgs { eye: Some(eye), ..flags.clone() }, Vec::new())
        }
    }
}
