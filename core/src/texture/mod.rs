//! Pictures on surfaces, read when voxels are made and never again.
//!
//! In: the pixels of a picture and how they lie on a surface. Out: its mean colour around a place. A picture is kept with
//! halves of itself down to one pixel (Williams 1983), each pixel the mean of those that it covers, in linear light; a
//! read takes the halving in which a step of the reader is about a pixel, and blends the four pixels around the place.
//! Where another picture cuts the surface out, what it leaves counts ([`Maps`]).
//!
//! Texture coordinates are those of OBJ: (0, 0) is the lower left corner of the picture, v goes up.

#[cfg(feature = "images")]
mod decode;
mod maps;

use alloc::boxed::Box;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

use crate::color;

#[cfg(feature = "images")]
pub use decode::{MAX_IMAGE_SIDE, decode};
pub use maps::Maps;

/// How a picture lies on a surface, and how bright it is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Placement {
    /// `-s`: factor on the texture coordinates.
    pub scale: [f32; 3],
    /// `-o`: what is added to the scaled coordinates.
    pub offset: [f32; 3],
    /// `-clamp on`: no repetition outside 0 to 1.
    pub clamp: bool,
    /// `-mm`, first number: what is added to the scaled values.
    pub base: f32,
    /// `-mm`, second number: factor on the texture's values.
    pub gain: f32,
}

impl Default for Placement {
    /// As it is, again and again.
    fn default() -> Placement {
        Placement { scale: [1.0; 3], offset: [0.0; 3], clamp: false, base: 0.0, gain: 1.0 }
    }
}

/// Why pixels are no picture.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ImageError {
    /// The picture has no pixels, or not as many as its width and height say.
    Size {
        /// Pixels expected.
        expected: u64,
        /// Pixels there are.
        found: u64,
    },
    /// There is no memory for the halves.
    Memory {
        /// Bytes asked for.
        bytes: u64,
    },
}

impl core::fmt::Display for ImageError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            ImageError::Size { expected, found } => write!(f, "the picture has {found} pixels: expected {expected}"),
            ImageError::Memory { bytes } => write!(f, "out of memory: {bytes} bytes could not be had"),
        }
    }
}

impl core::error::Error for ImageError {}

/// Why a file gives no picture.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum DecodeError {
    /// What is wrong with it, for people.
    Picture(String),
    /// The picture takes more memory than allowed.
    Limit {
        /// Bytes that it takes while it is decoded.
        needed: u64,
    },
}

impl From<String> for DecodeError {
    fn from(why: String) -> DecodeError {
        DecodeError::Picture(why)
    }
}

/// A picture and its halves.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Image {
    /// The picture itself first.
    levels: Vec<Level>,
    /// Of all levels, row by row from the top: sRGB, red in the lowest byte, opacity in the highest.
    pixels: Vec<u32>,
    /// Whether a pixel is not opaque.
    has_opacity: bool,
    /// Whether colours count by their opacity, in halves and where they are read.
    is_weighted: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Level {
    width: u32,
    height: u32,
    start: usize,
}

impl Image {
    /// Takes `width * height` pixels, row by row from the top, red in the lowest byte of each, and adds the halves.
    pub fn new(width: u32, height: u32, pixels: Vec<u32>) -> Result<Image, ImageError> {
        Image::halved(width, height, pixels, false)
    }

    fn halved(width: u32, height: u32, mut pixels: Vec<u32>, is_weighted: bool) -> Result<Image, ImageError> {
        let (expected, found) = (u64::from(width) * u64::from(height), pixels.len() as u64);
        if expected != found || found == 0 {
            return Err(ImageError::Size { expected: expected.max(1), found });
        }
        let has_opacity = pixels.iter().any(|pixel| pixel >> 24 != 255);
        let mut levels = Vec::new();
        let mut level = Level { width, height, start: 0 };
        let missing = |bytes| move |_| ImageError::Memory { bytes };
        pixels.try_reserve(pixels.len() / 2 + 64).map_err(missing(2 * found))?;
        levels.try_reserve(32).map_err(missing(512))?;
        loop {
            levels.push(level);
            if level.width == 1 && level.height == 1 {
                return Ok(Image { levels, pixels, has_opacity, is_weighted });
            }
            let half =
                Level { width: (level.width / 2).max(1), height: (level.height / 2).max(1), start: pixels.len() };
            let area = half.width as usize * half.height as usize;
            pixels.try_reserve(area).map_err(missing(4 * area as u64))?;
            for y in 0..half.height {
                for x in 0..half.width {
                    let pixel = mean(
                        &pixels,
                        &level,
                        covered(x, half.width, level.width),
                        covered(y, half.height, level.height),
                        is_weighted,
                    );
                    pixels.push(pixel);
                }
            }
            level = half;
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.pixels[..]) as u64
    }
}

/// The pixels of `whole` that pixel `at` of `half` covers.
fn covered(at: u32, half: u32, whole: u32) -> core::ops::Range<u32> {
    let edge = |at: u32| (u64::from(at) * u64::from(whole) / u64::from(half)) as u32;
    edge(at)..edge(at + 1)
}

/// The mean of some pixels of a level, colours in linear light; with `by_opacity` each by that, unless all are transparent.
fn mean(
    pixels: &[u32],
    level: &Level,
    columns: core::ops::Range<u32>,
    rows: core::ops::Range<u32>,
    by_opacity: bool,
) -> u32 {
    let count = (columns.len() * rows.len()) as u64;
    let (mut plain, mut weighted, mut opacity) = ([0; 3], [0; 3], 0);
    for y in rows {
        for x in columns.clone() {
            let [r, g, b, weight] = pixels[level.start + y as usize * level.width as usize + x as usize].to_le_bytes();
            let weight = u64::from(weight);
            for (i, byte) in [r, g, b].into_iter().enumerate() {
                let linear = u64::from(color::LINEAR[usize::from(byte)]);
                plain[i] += linear;
                weighted[i] += weight * linear;
            }
            opacity += weight;
        }
    }
    let rounded = |sum: u64, of: u64| ((sum + of / 2) / of) as u32;
    let is_plain = !by_opacity || opacity == 0;
    let linear =
        if is_plain { plain.map(|sum| rounded(sum, count)) } else { weighted.map(|sum| rounded(sum, opacity)) };
    let [r, g, b] = linear.map(color::linear_to_srgb8);
    u32::from_le_bytes([r, g, b, rounded(opacity, count) as u8])
}

/// What a pixel counts that is cut out: nothing beside others, all where there are no others.
const LEAST_WEIGHT: f64 = 1e-6;

/// A picture as it lies on the surfaces of a material.
#[derive(Clone, Debug)]
pub struct Texture {
    image: Arc<Image>,
    placement: Placement,
    /// What each byte of the picture stands for, linear.
    light: Box<[f64; 256]>,
}

impl Texture {
    /// Lays a picture on surfaces. Numbers of `placement` that are not finite count as their defaults.
    pub fn new(image: Arc<Image>, placement: Placement) -> Texture {
        let finite = |x: f32, or: f32| if x.is_finite() { x } else { or };
        let placement = Placement {
            scale: placement.scale.map(|x| finite(x, 1.0)),
            offset: placement.offset.map(|x| finite(x, 0.0)),
            base: finite(placement.base, 0.0),
            gain: finite(placement.gain, 1.0),
            clamp: placement.clamp,
        };
        let (base, gain) = (f64::from(placement.base), f64::from(placement.gain));
        let light =
            core::array::from_fn(|byte| color::srgb_to_linear((base + gain * (byte as f64 / 255.0)).clamp(0.0, 1.0)));
        Texture { image, placement, light: Box::new(light) }
    }

    /// The picture, which other textures may show, too.
    pub fn image(&self) -> &Arc<Image> {
        &self.image
    }

    /// Texture coordinates in pixels of the picture, from its upper left corner. Those that are not finite are at 0.
    pub fn to_pixels(&self, uv: [f64; 2]) -> [f64; 2] {
        let [s, o] = [self.placement.scale, self.placement.offset];
        let Level { width, height, .. } = self.image.levels[0];
        let at = |i: usize| {
            let x = uv[i] * f64::from(s[i]) + f64::from(o[i]);
            if x.is_finite() { x } else { 0.0 }
        };
        [at(0) * f64::from(width), (1.0 - at(1)) * f64::from(height)]
    }

    /// The halving in which a step of so many pixels of the picture is one to two pixels.
    pub fn level(&self, step: f64) -> usize {
        let (mut level, mut step) = (0, step);
        while step >= 2.0 && level + 1 < self.image.levels.len() {
            (level, step) = (level + 1, 0.5 * step);
        }
        level
    }

    /// The linear colour at a place (as [`Texture::to_pixels`] gives it), blended from four pixels of a halving (of the
    /// last one if there is none of that number), times its weight, and the weight. So a mean over places is the sum of the
    /// colours over that of the weights, which is never 0. All weights are 1 but where [`Maps`] cut the surface out.
    pub fn read(&self, place: [f64; 2], level: usize) -> [f64; 4] {
        self.blend(place, level, |[r, g, b, opacity]| {
            let weight = if self.image.is_weighted { (f64::from(opacity) / 255.0).max(LEAST_WEIGHT) } else { 1.0 };
            let [r, g, b] = [r, g, b].map(|byte| weight * self.light[usize::from(byte)]);
            [r, g, b, weight]
        })
    }

    /// How much of the surface is there at a place, 0 to 1: the picture's opacity, or if it is opaque everywhere its
    /// brightness.
    pub fn opacity(&self, place: [f64; 2], level: usize) -> f64 {
        let Placement { base, gain, .. } = self.placement;
        let [opacity] = self.blend(place, level, |[r, g, b, opacity]| {
            let brightness = (f64::from(r) + f64::from(g) + f64::from(b)) / 3.0;
            let value = if self.image.has_opacity { f64::from(opacity) } else { brightness };
            [(f64::from(base) + f64::from(gain) * value / 255.0).clamp(0.0, 1.0)]
        });
        opacity
    }

    /// The blend of what the four pixels around a place stand for.
    #[inline]
    fn blend<const N: usize>(&self, place: [f64; 2], level: usize, value: impl Fn([u8; 4]) -> [f64; N]) -> [f64; N] {
        let levels = &self.image.levels;
        let Level { width, height, start } = levels[level.min(levels.len() - 1)];
        let x = Neighbours::of(place[0] / f64::from(levels[0].width), width, self.placement.clamp);
        let y = Neighbours::of(place[1] / f64::from(levels[0].height), height, self.placement.clamp);
        let mut sum = [0.0; N];
        for (row, share_of_row) in y.pixels {
            for (column, share) in x.pixels {
                let pixel = self.image.pixels[start + row as usize * width as usize + column as usize].to_le_bytes();
                for (sum, value) in sum.iter_mut().zip(value(pixel)) {
                    *sum += share_of_row * share * value;
                }
            }
        }
        sum
    }
}

/// The two pixels around a place along one axis, and the share of each.
struct Neighbours {
    pixels: [(u32, f64); 2],
}

impl Neighbours {
    /// Of a place in units of the picture.
    fn of(place: f64, size: u32, clamp: bool) -> Neighbours {
        let last = f64::from(size - 1);
        if clamp {
            let at = (place.clamp(0.0, 1.0) * f64::from(size) - 0.5).clamp(0.0, last);
            let low = libm::floor(at);
            let high = (low + 1.0).min(last);
            return Neighbours { pixels: [(low as u32, 1.0 - (at - low)), (high as u32, at - low)] };
        }
        let at = (place - libm::floor(place)) * f64::from(size) - 0.5;
        let low = libm::floor(at);
        // -1 is the last pixel, and the one behind the last is the first.
        let low_pixel = if low < 0.0 { size - 1 } else { (low as u32).min(size - 1) };
        let high_pixel = if low_pixel + 1 < size { low_pixel + 1 } else { 0 };
        Neighbours { pixels: [(low_pixel, 1.0 - (at - low)), (high_pixel, at - low)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: u32 = 0xff00_00ff;
    const GREEN: u32 = 0xff00_ff00;
    const BLUE: u32 = 0xffff_0000;
    const WHITE: u32 = 0xffff_ffff;

    fn texture(pixels: [u32; 4], placement: Placement) -> Texture {
        Texture::new(Arc::new(Image::new(2, 2, pixels.to_vec()).unwrap()), placement)
    }

    fn at(texture: &Texture, uv: [f64; 2]) -> [f64; 3] {
        let [r, g, b, weight] = texture.read(texture.to_pixels(uv), 0);
        assert_eq!(weight, 1.0);
        [r, g, b]
    }

    #[test]
    fn v_goes_up_and_pictures_repeat() {
        let card = texture([RED, GREEN, BLUE, WHITE], Placement::default());
        for [i, j] in [[0.0, 0.0], [1.0, -2.0], [-7.0, 3.0]] {
            assert_eq!(at(&card, [i + 0.25, j + 0.75]), [1.0, 0.0, 0.0]);
            assert_eq!(at(&card, [i + 0.75, j + 0.75]), [0.0, 1.0, 0.0]);
            assert_eq!(at(&card, [i + 0.25, j + 0.25]), [0.0, 0.0, 1.0]);
            assert_eq!(at(&card, [i + 0.75, j + 0.25]), [1.0; 3]);
            // Between the columns, and around the edge.
            assert_eq!(at(&card, [i + 0.5, j + 0.75]), [0.5, 0.5, 0.0]);
            assert_eq!(at(&card, [i, j + 0.75]), [0.5, 0.5, 0.0]);
        }
    }

    #[test]
    fn clamped_pictures_end_in_their_borders() {
        let card = texture([RED, GREEN, BLUE, WHITE], Placement { clamp: true, ..Placement::default() });
        assert_eq!(at(&card, [-5.0, 9.0]), [1.0, 0.0, 0.0]);
        assert_eq!(at(&card, [5.0, -9.0]), [1.0; 3]);
        assert_eq!(at(&card, [f64::NAN, 1e300]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn scale_offset_base_and_gain_are_obeyed() {
        let moved = Placement { scale: [2.0, 2.0, 1.0], offset: [0.5, 0.0, 0.0], ..Placement::default() };
        let card = texture([RED, GREEN, BLUE, WHITE], moved);
        // (0.125, 0.375) is at (0.75, 0.75).
        assert_eq!(at(&card, [0.125, 0.375]), [0.0, 1.0, 0.0]);
        let dim = texture([RED; 4], Placement { base: 0.25, gain: 0.5, ..Placement::default() });
        let expected = [0.75, 0.25, 0.25].map(color::srgb_to_linear);
        assert_eq!(at(&dim, [0.3, 0.3]), expected);
    }

    #[test]
    fn halves_keep_the_mean_light() {
        // One pixel of 32 is white: up to the rounding of bytes every halving has as much light.
        let mut pixels = [0xff00_0000u32; 32].to_vec();
        pixels[13] = WHITE;
        let image = Image::new(8, 4, pixels).unwrap();
        let sizes = |image: &Image| image.levels.iter().map(|l| (l.width, l.height)).collect::<Vec<_>>();
        assert_eq!(sizes(&image), [(8, 4), (4, 2), (2, 1), (1, 1)]);
        let last = image.pixels[image.levels[3].start].to_le_bytes();
        let expected = color::linear_to_srgb8(color::WHITE / 32);
        assert!(last[..3].iter().all(|byte| byte.abs_diff(expected) <= 1), "{last:?}, expected {expected}");
        assert_eq!(sizes(&Image::new(5, 3, [0; 15].to_vec()).unwrap()), [(5, 3), (2, 1), (1, 1)]);
        assert_eq!(Image::new(2, 2, [0; 3].to_vec()), Err(ImageError::Size { expected: 4, found: 3 }));
        assert_eq!(Image::new(0, 0, Vec::new()), Err(ImageError::Size { expected: 1, found: 0 }));
    }
}
