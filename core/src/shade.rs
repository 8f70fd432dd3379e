//! Phong's reflection model (Pineda 2021, section 2.1.1): what a lit surface sends to the viewer.
//!
//! In: a material, a unit normal, the point, the way to the viewer, lights. Out: linear red, green, blue, unclamped:
//! `Ia Ka + sum over lights (Id Kd (L.N) + Is Ks (V.R)^alpha)` with Id = Is = the light's colour. Differs from the
//! thesis: no highlight from behind (`L.N <= 0`) or off the mirror direction (`V.R <= 0`); a light at the very point
//! gives nothing. Ke and reflections are effects of their own ([`crate::effects`]) and not part of this equation. Nor is what
//! stands in the way of a light: a renderer that casts shadows adds, one by one, the lights that it finds to reach the surface.
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
    /// Whether what stands in its way casts a shadow, hard-edged, in a picture.
    pub shadow: bool,
}

impl Light {
    /// Unit vector from `point` towards the light; `None` if the light is at the point or nowhere.
    pub fn direction_from(&self, point: [f64; 3]) -> Option<[f64; 3]> {
        match self.kind {
            LightKind::Point(position) => math::normalize(math::sub(position, point)),
            LightKind::Directional(direction) => math::normalize(direction),
        }
    }

    /// How its light falls on `surface` if nothing is in the way; `None` if the surface faces away from it.
    pub fn falls_on(&self, surface: &Surface) -> Option<Incidence> {
        self.falls_at(surface.point, surface.normal)
    }

    /// The same by point and normal.
    #[inline]
    pub(crate) fn falls_at(&self, point: [f64; 3], normal: [f32; 3]) -> Option<Incidence> {
        let direction = self.direction_from(point)?.map(|x| x as f32);
        let cosine = Vec3::from(direction).dot(Vec3::from(normal));
        (cosine > 0.0).then_some(Incidence { direction, cosine })
    }
}

/// How light falls on a surface that faces it. See [`Light::falls_on`].
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Incidence {
    /// Unit vector towards the light.
    pub direction: [f32; 3],
    /// Of the angle between it and the normal: above 0.
    pub cosine: f32,
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

/// The light that `surface` sends to the viewer if nothing stands between it and the lights: linear red, green, blue, 0 or
/// more. The sum of [`glow`] and [`reflect`] of each light that falls on it.
pub fn shade(material: &Material, surface: &Surface, ambient: [f32; 3], lights: &[Light]) -> [f32; 3] {
    let falling = lights.iter().filter_map(|light| Some((light, light.falls_on(surface)?)));
    falling
        .fold(glow(material, ambient), |color, (light, incidence)| reflect(color, material, surface, light, incidence))
}

/// What a material sends back of the light that comes from everywhere.
#[inline]
pub fn glow(material: &Material, ambient: [f32; 3]) -> [f32; 3] {
    (Vec3::from(ambient) * Vec3::from(material.ambient)).to_array()
}

/// `color`, and what `surface` sends to the viewer of a light that falls on it.
pub fn reflect(
    color: [f32; 3],
    material: &Material,
    surface: &Surface,
    light: &Light,
    incidence: Incidence,
) -> [f32; 3] {
    let color = matte(color, material, light, incidence);
    if has_highlight(material) {
        highlight(color, material, (surface.normal, surface.view), light, incidence).unwrap_or(color)
    } else {
        color
    }
}

/// `color`, and what a matte surface sends everywhere of a light that falls on it.
#[inline]
pub(crate) fn matte(color: [f32; 3], material: &Material, light: &Light, incidence: Incidence) -> [f32; 3] {
    // The weight goes first: what vanishes stays 0 however strong the light.
    (Vec3::from(color) + Vec3::from(material.diffuse) * incidence.cosine * Vec3::from(light.color)).to_array()
}

/// `color`, and the highlight of a light on a surface, by its normal and the way to the viewer, whose material has one; `None`
/// off the mirror direction.
#[inline]
pub(crate) fn highlight(
    color: [f32; 3],
    material: &Material,
    (normal, view): ([f32; 3], [f32; 3]),
    light: &Light,
    Incidence { direction, cosine }: Incidence,
) -> Option<[f32; 3]> {
    // V.R with R = 2 (L.N) N - L.
    let view = Vec3::from(view);
    let mirrored = 2.0 * cosine * view.dot(Vec3::from(normal)) - view.dot(Vec3::from(direction));
    (mirrored > 0.0).then(|| {
        let share = Vec3::from(material.specular) * power(mirrored, material.shininess);
        (Vec3::from(color) + share * Vec3::from(light.color)).to_array()
    })
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
