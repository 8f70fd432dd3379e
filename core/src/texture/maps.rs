//! The textures of a material, and what one of them cuts out of the other.
//!
//! Colours under what is cut out are seldom meant to be seen: leaves are drawn on white, or on black. So where both pictures
//! lie alike, the one with the colours takes over how much of each of its pixels is left, and its colours count by that,
//! in its halves and where it is read.

use alloc::sync::Arc;
use alloc::vec::Vec;

use super::{Image, ImageError, Level, Placement, Texture};

/// The textures of a material.
#[derive(Clone, Debug, Default)]
pub struct Maps {
    diffuse: Option<Texture>,
    dissolve: Option<Texture>,
}

impl Maps {
    /// The textures of a material: `diffuse` (map_Kd) is the colour of its voxels, `dissolve` (map_d) says where it has voxels
    /// at all: a voxel that the surface fills by less than half is left empty. Takes [`Maps::bytes_for`] where both are there.
    pub fn new(diffuse: Option<Texture>, dissolve: Option<Texture>) -> Result<Maps, ImageError> {
        let left = match (&diffuse, &dissolve) {
            (Some(color), Some(cut)) if lie_alike(color, cut) => Some(what_is_left(color, cut)?),
            _ => None,
        };
        Ok(Maps { diffuse: left.or(diffuse), dissolve })
    }

    /// Bytes that [`Maps::new`] takes for a picture of its own; 0 where it takes none.
    pub fn bytes_for(diffuse: Option<&Texture>, dissolve: Option<&Texture>) -> u64 {
        match (diffuse, dissolve) {
            (Some(color), Some(cut)) if lie_alike(color, cut) => color.image.bytes(),
            _ => 0,
        }
    }

    /// The colour of the material's voxels.
    pub fn diffuse(&self) -> Option<&Texture> {
        self.diffuse.as_ref()
    }

    /// Where the material has voxels.
    pub fn dissolve(&self) -> Option<&Texture> {
        self.dissolve.as_ref()
    }
}

/// Whether two pictures have the same place on every surface.
fn lie_alike(a: &Texture, b: &Texture) -> bool {
    let place = |texture: &Texture| {
        let Placement { scale: [su, sv, _], offset: [ou, ov, _], clamp, .. } = texture.placement;
        ([su, sv, ou, ov], clamp)
    };
    place(a) == place(b)
}

/// The colours with how much is left of each pixel as its opacity.
fn what_is_left(color: &Texture, cut: &Texture) -> Result<Texture, ImageError> {
    let (Level { width, height, .. }, other) = (color.image.levels[0], cut.image.levels[0]);
    let count = width as usize * height as usize;
    let mut pixels = Vec::new();
    pixels.try_reserve_exact(count).map_err(|_| ImageError::Memory { bytes: 4 * count as u64 })?;
    // One pixel of the colours in pixels of the other picture.
    let step = [f64::from(other.width) / f64::from(width), f64::from(other.height) / f64::from(height)];
    let level = cut.level(step[0].max(step[1]));
    for y in 0..height {
        for x in 0..width {
            let place = [(f64::from(x) + 0.5) * step[0], (f64::from(y) + 0.5) * step[1]];
            let [r, g, b, _] = color.image.pixels[pixels.len()].to_le_bytes();
            let opacity = (cut.opacity(place, level) * 255.0 + 0.5) as u8;
            pixels.push(u32::from_le_bytes([r, g, b, opacity]));
        }
    }
    let image = Image::halved(width, height, pixels, true)?;
    Ok(Texture { image: Arc::new(image), placement: color.placement, light: color.light.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GREEN: u32 = 0xff00_ff00;
    const CLEAR_WHITE: u32 = 0x00ff_ffff;

    fn row(pixels: &[u32], placement: Placement) -> Texture {
        let image = Image::new(pixels.len() as u32, 1, pixels.to_vec()).unwrap();
        Texture::new(Arc::new(image), Placement { clamp: true, ..placement })
    }

    /// A green leaf on white that is cut away is green at every size, however the cutting is given.
    #[test]
    fn what_is_cut_out_lends_no_colour() {
        let plain = Placement::default();
        let by_itself = row(&[GREEN, GREEN, GREEN, CLEAR_WHITE], plain);
        let opaque = row(&[GREEN, GREEN, GREEN, 0xffff_ffff], plain);
        let mask = row(&[0xffff_ffff, 0xffff_ffff, 0xffff_ffff, 0xff00_0000], plain);
        let turned = Placement { base: 1.0, gain: -1.0, ..plain };
        let holes = row(&[0xff00_0000, 0xff00_0000, 0xff00_0000, 0xffff_ffff], turned);
        for (color, cut) in [(&by_itself, &by_itself), (&opaque, &mask), (&opaque, &holes)] {
            let maps = Maps::new(Some(color.clone()), Some(cut.clone())).unwrap();
            let leaf = maps.diffuse().unwrap();
            let Image { levels, pixels, .. } = &**leaf.image();
            let firsts: Vec<_> = levels.iter().map(|level| pixels[level.start].to_le_bytes()).collect();
            assert_eq!(firsts, [[0, 255, 0, 255], [0, 255, 0, 255], [0, 255, 0, 192]]);
            assert_eq!(pixels[levels[1].start + 1].to_le_bytes(), [0, 255, 0, 128]);
            let [r, g, b, weight] = leaf.read([3.0, 0.5], 0);
            assert!(r < 2e-6 && b < 2e-6 && (g - 0.5).abs() < 2e-6 && (weight - 0.5).abs() < 2e-6);
            // Where nothing is left, what is there all the same.
            let [r, g, b, weight] = leaf.read([3.5, 0.5], 0);
            assert!(weight > 0.0 && [r, g, b].iter().all(|x| (x / weight - 1.0).abs() < 1e-9));
        }
    }

    /// Without a picture that cuts, or with one that lies otherwise, opacity says nothing about colours.
    #[test]
    fn opacity_alone_changes_no_colour() {
        let leaf = row(&[GREEN, CLEAR_WHITE], Placement::default());
        let shifted = row(&[GREEN, CLEAR_WHITE], Placement { offset: [0.5, 0.0, 0.0], ..Placement::default() });
        for cut in [None, Some(shifted)] {
            assert_eq!(Maps::bytes_for(Some(&leaf), cut.as_ref()), 0);
            let maps = Maps::new(Some(leaf.clone()), cut).unwrap();
            let texture = maps.diffuse().unwrap();
            assert!(Arc::ptr_eq(texture.image(), leaf.image()));
            assert_eq!(texture.read([1.0, 0.5], 0), [0.5, 1.0, 0.5, 1.0]);
        }
        let itself = Maps::bytes_for(Some(&leaf), Some(&leaf));
        assert_eq!(itself, leaf.image().bytes());
    }
}
