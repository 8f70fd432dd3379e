//! What a scene calls for beyond matte surfaces, read from its materials and lights; what it does not call for costs
//! nothing.
//!
//! In: materials by the illumination models of MTL ("MTL material format", Alias|Wavefront 1995), lights. Out: a set of
//! effects, and for one surface how much it reflects and lets through. Differs from the description: where d is below 1 a
//! surface of any model is transparent, as every viewer shows it; Tf colours what the models of glass (4, 6, 7, 9) let
//! through and is at its default if it is 1, whatever the model. The table of models stands in docs/effects.md.

use crate::material::Material;
use crate::shade::{self, Light};

/// A set of effects.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Effects(u8);

impl Effects {
    /// Matte surfaces in light that nothing keeps away.
    pub const NONE: Effects = Effects(0);
    /// Highlights: Ks above 0 in the models 2 and above.
    pub const SPECULAR: Effects = Effects(1);
    /// Shadows of the lights that cast them.
    pub const SHADOWS: Effects = Effects(1 << 1);
    /// Reflections: Ks above 0 in the models 3 to 7.
    pub const MIRROR: Effects = Effects(1 << 2);
    /// Seeing through: d below 1, or in the models of glass a Tf that is neither white nor black.
    pub const TRANSPARENCY: Effects = Effects(1 << 3);
    /// Rays that bend where they enter and leave: transparent surfaces of the models 6 and 7 with an Ni other than 1.
    pub const REFRACTION: Effects = Effects(1 << 4);
    /// Light of its own: Ke above 0.
    pub const EMISSION: Effects = Effects(1 << 5);
    /// Colours of textures: materials that have one.
    pub const TEXTURES: Effects = Effects(1 << 6);
    /// The thesis's shading: highlights and nothing else.
    pub const PHONG: Effects = Effects::SPECULAR;
    /// All there are.
    pub const ALL: Effects = Effects((1 << NAMES.len()) - 1);

    /// What materials and lights call for: to draw them with these effects or with more gives the same picture.
    pub fn needed(materials: &[Material], lights: &[Light]) -> Effects {
        let mut needed = materials.iter().fold(Effects::NONE, |sum, material| sum.union(Effects::of(material)));
        if lights.is_empty() {
            needed = needed.difference(Effects::SPECULAR);
        }
        if lights.iter().any(|light| light.shadow) {
            needed = needed.union(Effects::SHADOWS);
        }
        needed
    }

    /// What a material calls for.
    #[inline]
    pub fn of(material: &Material) -> Effects {
        let is_clear = opacity(material) < 1.0;
        let when = |called_for: bool, effect: Effects| if called_for { effect.0 } else { 0 };
        Effects(
            when(shade::has_highlight(material), Effects::SPECULAR)
                | when(matches!(material.illum, 3..=7) && material.specular != [0.0; 3], Effects::MIRROR)
                | when(is_clear, Effects::TRANSPARENCY)
                | when(is_clear && bends(material), Effects::REFRACTION)
                | when(material.emission != [0.0; 3], Effects::EMISSION)
                | when(material.textured, Effects::TEXTURES),
        )
    }

    /// Whether all of `other` are in the set.
    #[inline]
    pub const fn contains(self, other: Effects) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether any of `other` is in the set.
    #[inline]
    pub const fn intersects(self, other: Effects) -> bool {
        self.0 & other.0 != 0
    }

    /// Whether there are none.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Those in one of the sets.
    #[inline]
    pub const fn union(self, other: Effects) -> Effects {
        Effects(self.0 | other.0)
    }

    /// Those in both sets.
    #[inline]
    pub const fn intersection(self, other: Effects) -> Effects {
        Effects(self.0 & other.0)
    }

    /// Those not in the other.
    #[inline]
    pub const fn difference(self, other: Effects) -> Effects {
        Effects(self.0 & !other.0)
    }

    /// The set's effects one by one, in the order of [`Effects::names`].
    pub fn iter(self) -> impl Iterator<Item = Effects> {
        (0..NAMES.len()).map(|i| Effects(1 << i)).filter(move |effect| self.contains(*effect))
    }

    /// The names of the set's effects: of `specular`, `shadows`, `mirror`, `transparency`, `refraction`, `emission`,
    /// `textures`, in this order.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        self.iter().map(|effect| NAMES[effect.0.trailing_zeros() as usize])
    }

    /// The effect of a name; `None` if none is called so.
    pub fn named(name: &str) -> Option<Effects> {
        NAMES.iter().position(|known| *known == name).map(|i| Effects(1 << i))
    }
}

/// By bit.
const NAMES: [&str; 7] = ["specular", "shadows", "mirror", "transparency", "refraction", "emission", "textures"];

impl core::fmt::Debug for Effects {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_set().entries(self.names()).finish()
    }
}

/// Whether Tf belongs to a material's model, and its polish stays whole however much it lets through.
fn is_glass(material: &Material) -> bool {
    matches!(material.illum, 4 | 6 | 7 | 9)
}

/// Whether rays through a material bend.
fn bends(material: &Material) -> bool {
    matches!(material.illum, 6 | 7) && material.refraction > 0.0 && material.refraction != 1.0
}

/// Whether a material's model reflects the more, the flatter one looks at it (Fresnel).
fn is_fresnel(material: &Material) -> bool {
    matches!(material.illum, 5 | 7)
}

/// How much of a surface is there: d; where that is 1, glass with a Tf of its own is what the brightest channel leaves.
pub(crate) fn opacity(material: &Material) -> f32 {
    let tf = material.transmission;
    if material.opacity < 1.0 {
        material.opacity
    } else if is_glass(material) && tf != [1.0; 3] {
        1.0 - tf[0].max(tf[1]).max(tf[2]).min(1.0)
    } else {
        1.0
    }
}

/// The share of the light from behind that comes through, per channel.
pub(crate) fn through(material: &Material) -> [f32; 3] {
    let clear = if material.opacity < 1.0 { 1.0 - material.opacity } else { 1.0 };
    if is_glass(material) { material.transmission.map(|tf| clear * tf.min(1.0)) } else { [clear; 3] }
}

/// The share of the light from the mirrored direction that is sent back, per channel, to a viewer at an angle of this
/// `cosine` to the normal: Ks, in the models 5 and 7 growing to 1 at grazing angles (Schlick 1994). Where one `sees_through`
/// what is no glass, it is of as much as is there.
pub(crate) fn mirrored(material: &Material, cosine: f32, sees_through: bool) -> [f32; 3] {
    let grazing = 1.0 - cosine.clamp(0.0, 1.0);
    let rise = if is_fresnel(material) { grazing * grazing * grazing * grazing * grazing } else { 0.0 };
    let whole = if sees_through && !is_glass(material) { material.opacity } else { 1.0 };
    material.specular.map(|ks| {
        let ks = ks.min(1.0);
        whole * (ks + (1.0 - ks) * rise)
    })
}

/// What is left to come through of what is not mirrored: all, but in the models of Fresnel.
pub(crate) fn passed(material: &Material, mirrored: [f32; 3]) -> [f32; 3] {
    let through = through(material);
    if is_fresnel(material) { core::array::from_fn(|i| through[i] * (1.0 - mirrored[i])) } else { through }
}

/// A transparent material as its surface is shaded, lights and highlights: what it sends of its own is as much as is
/// there of it, but glass is polished all over.
pub(crate) fn faded(material: &Material) -> Material {
    let d = opacity(material);
    let fade = |color: [f32; 3]| color.map(|x| x * d);
    Material {
        ambient: fade(material.ambient),
        diffuse: fade(material.diffuse),
        emission: fade(material.emission),
        specular: if is_glass(material) { material.specular } else { fade(material.specular) },
        ..*material
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_have_names_and_an_order() {
        assert!(Effects::ALL.names().eq(NAMES));
        assert!(NAMES.iter().all(|name| Effects::named(name).unwrap().names().eq([*name])));
        assert_eq!(Effects::named("phong"), None);
        let two = Effects::EMISSION.union(Effects::SHADOWS);
        assert!(two.names().eq(["shadows", "emission"]));
        assert_eq!(Effects::ALL.difference(two).intersection(two), Effects::NONE);
        assert!(two.contains(Effects::SHADOWS) && two.intersects(Effects::ALL) && !two.contains(Effects::ALL));
        assert!(Effects::NONE.is_empty() && Effects::ALL.contains(Effects::NONE));
    }

    #[test]
    fn what_comes_through_and_what_is_mirrored() {
        let base = Material { specular: [0.5, 0.25, 2.0], transmission: [1.0, 0.5, 0.25], ..Material::GREY };
        let glass = |illum, opacity| Material { illum, opacity, ..base };
        assert_eq!((opacity(&glass(4, 0.25)), through(&glass(4, 0.25))), (0.25, [0.75, 0.375, 0.1875]));
        assert_eq!((opacity(&glass(2, 0.25)), through(&glass(2, 0.25))), (0.25, [0.75; 3]));
        assert_eq!((opacity(&glass(4, 1.0)), through(&glass(4, 1.0))), (0.0, [1.0, 0.5, 0.25]));
        assert_eq!(opacity(&glass(2, 1.0)), 1.0);
        // Black is as good a default as white.
        for tf in [0.0, 1.0] {
            assert_eq!(opacity(&Material { transmission: [tf; 3], ..glass(9, 1.0) }), 1.0);
        }
        assert_eq!(mirrored(&glass(3, 0.5), 0.0, true), [0.25, 0.125, 0.5]);
        assert_eq!(mirrored(&glass(4, 0.5), 0.0, true), [0.5, 0.25, 1.0]);
        assert_eq!(mirrored(&glass(3, 0.5), 0.0, false), [0.5, 0.25, 1.0]);
        let fresnel = |cosine| mirrored(&glass(7, 0.5), cosine, true);
        assert_eq!((fresnel(1.0), fresnel(0.0)), ([0.5, 0.25, 1.0], [1.0; 3]));
        assert_eq!(passed(&glass(7, 0.5), [0.5, 0.25, 1.0]), [0.25, 0.1875, 0.0]);
        assert_eq!(passed(&glass(6, 0.5), [1.0; 3]), through(&glass(6, 0.5)));
        let [dissolved, polished] = [2, 4].map(|illum| faded(&glass(illum, 0.5)));
        assert_eq!((dissolved.diffuse, dissolved.specular), ([0.25; 3], [0.25, 0.125, 1.0]));
        assert_eq!((polished.diffuse, polished.specular), ([0.25; 3], base.specular));
    }
}
