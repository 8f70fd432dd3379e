//! A pinhole camera in the world, and its rays.
//!
//! In: eye, target, up and the vertical field of view. Out: one direction per place in the picture; pixel (x, y) spans
//! x to x + 1 and y to y + 1, row 0 on top. Everything in f64; the tangent is libm's.

use crate::grid::{Bounds, UpAxis};
use crate::math;
use crate::shade::{Light, LightKind};
use crate::trace::Tile;

/// A pinhole camera.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Camera {
    /// Where it is, in the world.
    pub eye: [f64; 3],
    /// What it looks at: the middle of the picture.
    pub target: [f64; 3],
    /// What points upwards in the picture, of any length. Parallel to the view it says nothing; see
    /// [`Camera::checked`].
    pub up: [f64; 3],
    /// Angle between the picture's top and bottom in degrees, above 0 and below 180.
    pub fov_y: f64,
}

/// Why a camera sees nothing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum CameraError {
    /// A coordinate is not finite, or eye and target are too far apart for f64.
    NotFinite,
    /// Eye and target are the same point.
    NoDirection,
    /// The field of view is not above 0 and below 180 degrees.
    FieldOfView,
}

impl core::fmt::Display for CameraError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            CameraError::NotFinite => "the camera's eye, target or up is not finite: expected numbers within f64",
            CameraError::NoDirection => "the camera's eye and target are the same point: move one of them",
            CameraError::FieldOfView => {
                "the camera's field of view is out of range: expected degrees above 0, below 180"
            }
        })
    }
}

impl core::error::Error for CameraError {}

impl Camera {
    /// The default view of a box: from twice half its diagonal away, from the right, above and in front.
    pub fn framing(bounds: &Bounds, up: UpAxis) -> Camera {
        let target = bounds.center();
        // A single point is looked at from 2 units away.
        let radius = if bounds.radius() > 0.0 { bounds.radius() } else { 1.0 };
        let offset = [1.0, 0.6, 1.2];
        let distance = 2.0 * radius / math::sqrt(math::dot(offset, offset));
        Camera {
            eye: math::add_scaled(target, up.turn(offset), distance),
            target,
            up: up.turn([0.0, 1.0, 0.0]),
            fov_y: 45.0,
        }
    }

    /// The default light: white, `height` above the eye (half the diagonal of what is looked at).
    pub fn headlight(&self, height: f64) -> Light {
        let up = math::normalize(self.up).unwrap_or([0.0; 3]);
        Light { kind: LightKind::Point(math::add_scaled(self.eye, up, height)), color: [1.0; 3] }
    }

    /// The same camera, its up a unit vector at right angles to the view, or what is wrong with it.
    ///
    /// An up that is zero or parallel to the view is replaced by the axis farthest from the view, z before y before x.
    pub fn checked(&self) -> Result<Camera, CameraError> {
        let forward = math::sub(self.target, self.eye);
        if !self.eye.iter().chain(&self.up).chain(&forward).all(|x| x.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        if !(self.fov_y > 0.0 && self.fov_y < 180.0) {
            return Err(CameraError::FieldOfView);
        }
        let forward = math::normalize(forward).ok_or(CameraError::NoDirection)?;
        let upright = |up: [f64; 3]| math::normalize(math::add_scaled(up, forward, -math::dot(up, forward)));
        // Nearer than this to the view, what is left of up is rounding error.
        let clear = |up: &[f64; 3]| math::dot(*up, forward).abs() < 1.0 - 1e-12;
        let up = match math::normalize(self.up).filter(clear) {
            Some(up) => upright(up),
            None => {
                let f = forward.map(f64::abs);
                let axis = if f[2] <= f[0] && f[2] <= f[1] {
                    2
                } else if f[1] <= f[0] {
                    1
                } else {
                    0
                };
                let mut up = [0.0; 3];
                up[axis] = 1.0;
                upright(up)
            }
        };
        Ok(Camera { up: up.ok_or(CameraError::NoDirection)?, ..*self })
    }

    /// The rays of a picture of `width` x `height` pixels (at least 1 each).
    pub fn rays(&self, width: u32, height: u32) -> Result<Rays, CameraError> {
        let camera = self.checked()?;
        let forward = math::normalize(math::sub(camera.target, camera.eye)).ok_or(CameraError::NoDirection)?;
        let right = math::cross(forward, camera.up);
        let (w, h) = (f64::from(width.max(1)), f64::from(height.max(1)));
        let half_height = libm::tan(camera.fov_y * (core::f64::consts::PI / 360.0));
        let pixel = 2.0 * half_height / h;
        let left = math::add_scaled(forward, right, -0.5 * pixel * w);
        Ok(Rays {
            corner: math::add_scaled(left, camera.up, half_height),
            dx: right.map(|x| x * pixel),
            dy: camera.up.map(|x| -x * pixel),
        })
    }
}

/// Directions through a picture, in the world's axes; those of a grid are the same.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Rays {
    corner: [f64; 3],
    dx: [f64; 3],
    dy: [f64; 3],
}

impl Rays {
    /// The direction, not of unit length, through (x, y) in pixels from the picture's upper left corner.
    #[inline]
    pub fn direction(&self, x: f64, y: f64) -> [f64; 3] {
        math::add_scaled(math::add_scaled(self.corner, self.dx, x), self.dy, y)
    }

    /// The rays from `eye`, in grid coordinates, through such places, to be traced together.
    pub fn tile<'a>(&self, eye: [f64; 3], places: &'a [[f64; 2]]) -> Tile<'a> {
        Tile { origin: eye, corner: self.corner, dx: self.dx, dy: self.dy, places }
    }
}
