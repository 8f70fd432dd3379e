//! Phong's reflection model (Pineda 2021, section 2.1.1): what a lit surface sends to the viewer.
//!
//! In: a material, a unit normal, the point, the way to the viewer, lights. Out: linear red, green, blue, unclamped:
//! `Ia Ka + sum over lights (Id Kd (L.N) + Is Ks (V.R)^alpha)` with Id = Is = the light's colour. Differs from the
//! thesis: no highlight from behind (`L.N <= 0`) or off the mirror direction (`V.R <= 0`); a light at the very point
//! gives nothing. Ke, shadows and reflections are effects of their own and not part of this equation.
//!
//! Every term is skipped, not multiplied by 0, where it does not apply: a material without a highlight raises no power.

use glam::Vec3;

use crate::material::Material;
use crate::math;

/// Where a light is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum LightKind {
    /// At a position.
    Point([f64; 3]),
    /// Infinitely far away, in this direction as seen from the scene (any length).
    Directional([f64; 3]),
}

/// A light; its strength does not fall with distance.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Light {
    /// Where it is, in the coordinates of the points that it lights.
    pub kind: LightKind,
    /// Linear red, green, blue; 1 is white at full strength.
    pub color: [f32; 3],
}

impl Light {
    /// Unit vector from `point` towards the light; `None` if the light is at the point or nowhere.
    pub fn direction_from(&self, point: [f64; 3]) -> Option<[f64; 3]> {
        match self.kind {
            LightKind::Point(position) => math::normalize(math::sub(position, point)),
            LightKind::Directional(direction) => math::normalize(direction),
        }
    }
}

/// What is lit, and from where it is seen.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Surface {
    /// The point, in the coordinates of the lights.
    pub point: [f64; 3],
    /// Unit normal.
    pub normal: [f32; 3],
    /// Unit vector towards the viewer.
    pub view: [f32; 3],
}

/// The light that `surface` sends to the viewer: linear red, green, blue, 0 or more.
pub fn shade(material: &Material, surface: &Surface, ambient: [f32; 3], lights: &[Light]) -> [f32; 3] {
    let (normal, view) = (Vec3::from(surface.normal), Vec3::from(surface.view));
    let mut color = Vec3::from(ambient) * Vec3::from(material.ambient);
    for light in lights {
        let Some(l) = light.direction_from(surface.point) else { continue };
        let l = Vec3::from(l.map(|x| x as f32));
        let facing = l.dot(normal);
        if facing <= 0.0 {
            continue;
        }
        // The weight goes first: what vanishes stays 0 however strong the light.
        let strength = Vec3::from(light.color);
        color += Vec3::from(material.diffuse) * facing * strength;
        if has_highlight(material) {
            // V.R with R = 2 (L.N) N - L.
            let mirrored = 2.0 * facing * view.dot(normal) - view.dot(l);
            if mirrored > 0.0 {
                color += Vec3::from(material.specular) * power(mirrored, material.shininess) * strength;
            }
        }
    }
    color.to_array()
}

/// Whether a material has a highlight at all: illumination model 2 or above, and a Ks that is not 0.
#[inline]
pub fn has_highlight(material: &Material) -> bool {
    material.illum >= 2 && material.specular != [0.0; 3]
}

/// `base^exponent` for a base of 0 to 1 (larger ones count as 1), by squaring; in f64, as every step doubles the error.
pub fn power(base: f32, exponent: u32) -> f32 {
    let mut square = f64::from(base.clamp(0.0, 1.0));
    let mut result = 1.0;
    let mut left = exponent;
    while left != 0 {
        if left & 1 != 0 {
            result *= square;
        }
        square *= square;
        left >>= 1;
    }
    result as f32
}
