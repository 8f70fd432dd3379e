//! What a renderer sees instead of what it draws: one ray through the middle of each pixel, one colour or number of each
//! ray.
//!
//! In: what [`super::render_rows`] takes; of the settings size, normals and arithmetic count. Out: a word per pixel:
//! RGBA8, or where a view has numbers, the bits of an f32, infinite where there is nothing. Numbers become colours once
//! the range of all rows is known ([`Show::paint`]), so rows can be worked out anywhere. Colours are those of the file, no
//! light; black is a ray that met nothing.

use core::ops::Range;

use super::{Counters, RenderError, Settings, View, each_pixel};
use crate::geometry::Geometry;
use crate::material::MaterialId;
use crate::materials::Materials;
use crate::math;
use crate::normal::normal;
use crate::trace::{Face, Hit, Query};

/// What is shown.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Show {
    /// The surface's direction: red, green, blue are half of x, y, z plus a half.
    Normals,
    /// Distance from the eye along the ray, in world units: white is the nearest, dark grey the farthest.
    Depth,
    /// Level of the largest empty octree cube around the voxel before the hit: the brighter, the larger. The root's where
    /// the ray comes from outside, and 0 for an eye inside a voxel.
    Level,
    /// Rounds of the walk of each ray, hit or not: dark is 0, then red, yellow, white. They depend on the tracer's layout
    /// and top grid.
    Iterations,
    /// A colour per material.
    Material,
}

/// The finite ones among some numbers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Spread {
    /// The smallest.
    pub min: f64,
    /// The mean, in the order of the numbers.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

/// Works out `rows` (row 0 is the top) into `out`, a word per pixel.
pub fn show_rows<M: Materials, G: Geometry>(
    view: &View<'_, M, G>,
    settings: &Settings,
    show: Show,
    rows: Range<u32>,
    out: &mut [u32],
) -> Result<Counters, RenderError> {
    let Settings { width, height, normals, arithmetic, .. } = *settings;
    let geometry = view.tracer.geometry();
    let mut counters = Counters::default();
    each_pixel(&view.camera, &view.grid, [width, height], rows, out, |pixel| {
        let query = pixel.query([0.5; 2]);
        let (hit, steps) = view.tracer.trace_counted(arithmetic, &query);
        counters.primary += 1;
        counters.hits += u64::from(hit.is_some());
        let number = match (show, &hit) {
            (Show::Iterations, _) => steps.rounds as f32,
            (Show::Depth, Some(hit)) => distance(&query, hit, view.grid.voxel_size),
            (Show::Level, Some(hit)) => level(geometry, hit).into(),
            (Show::Depth | Show::Level, None) => f32::INFINITY,
            (Show::Material, Some(hit)) => return material_colour(view.materials.id(hit.voxel)),
            (Show::Normals, Some(hit)) => {
                let normal = normal(&view.tracer, view.materials, hit, query.dir, normals).direction;
                return rgba(normal.map(|n| n * 0.5 + 0.5));
            }
            (Show::Material | Show::Normals, None) => return BLACK,
        };
        number.to_bits()
    })?;
    Ok(counters)
}

impl Show {
    /// Whether words are the bits of numbers; they are colours otherwise.
    pub fn has_numbers(self) -> bool {
        matches!(self, Show::Depth | Show::Level | Show::Iterations)
    }

    /// The range of the numbers in words of this view; `None` if there are none.
    pub fn spread(self, words: &[u32]) -> Option<Spread> {
        let words = if self.has_numbers() { words } else { &[] };
        let (mut spread, mut count) = (Spread { min: f64::INFINITY, mean: 0.0, max: f64::NEG_INFINITY }, 0u64);
        for value in words.iter().map(|&word| f32::from_bits(word)).filter(|value| value.is_finite()).map(f64::from) {
            spread.min = spread.min.min(value);
            spread.max = spread.max.max(value);
            spread.mean += value;
            count += 1;
        }
        spread.mean /= count as f64;
        (count > 0).then_some(spread)
    }

    /// Turns words that are numbers into RGBA8: those of some rows of a picture whose numbers span `min` to `max`, of a
    /// geometry of this `depth`. Colours stay as they are.
    pub fn paint(self, [min, max]: [f32; 2], depth: u8, words: &mut [u32]) {
        let colour: &dyn Fn(f32) -> [f32; 3] = match self {
            Show::Level => &|level| heat(part(level, [0.0, depth.into()])),
            Show::Iterations => &|rounds| heat(part(rounds, [0.0, max])),
            Show::Depth => &|depth| [1.0 - 0.85 * part(depth, [min, max]); 3],
            Show::Material | Show::Normals => return,
        };
        for word in words {
            let value = f32::from_bits(*word);
            *word = if value.is_finite() { rgba(colour(value)) } else { BLACK };
        }
    }
}

/// Along the ray, in world units.
fn distance(query: &Query, hit: &Hit, voxel_size: f64) -> f32 {
    let unit = math::sqrt(math::dot(query.dir, query.dir)) * voxel_size;
    (hit.t * unit) as f32
}

fn level(geometry: impl Geometry, hit: &Hit) -> u8 {
    match hit.from {
        Some(voxel) => geometry.empty_level(voxel).unwrap_or(0),
        None if hit.face == Face::Inside => 0,
        None => geometry.depth(),
    }
}

const BLACK: u32 = 0xff00_0000;

fn rgba(colour: [f32; 3]) -> u32 {
    let [red, green, blue] = colour.map(|x| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
    u32::from_le_bytes([red, green, blue, 255])
}

/// Where a value lies in a range, 0 to 1.
fn part(value: f32, [from, to]: [f32; 2]) -> f32 {
    if to > from { (value - from) / (to - from) } else { 0.0 }
}

/// Dark red, red, yellow, white.
fn heat(part: f32) -> [f32; 3] {
    let x = 0.3 + 2.7 * part;
    [x, x - 1.0, x - 2.0].map(|channel| channel.clamp(0.0, 1.0))
}

/// The colour map of the PASCAL VOC segmentation data: the bits of the number, lowest first, go to the highest bits of
/// red, green and blue in turn. So no two materials look the same. Its entry 0 is black, so materials start at 1.
fn material_colour(id: MaterialId) -> u32 {
    let number = u32::from(id) + 1;
    let mut colour = [0u8; 3];
    for bit in 0..17 {
        colour[bit % 3] |= (number >> bit & 1) as u8 * (0x80 >> (bit / 3));
    }
    u32::from_le_bytes([colour[0], colour[1], colour[2], 255])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(feature = "alloc")]
    #[cfg_attr(miri, ignore = "too long for an interpreter")]
    fn every_material_has_a_colour_of_its_own() {
        let colours: alloc::collections::BTreeSet<_> = (0..=MaterialId::MAX).map(material_colour).collect();
        assert_eq!(colours.len(), 1 << 16);
        assert!(!colours.contains(&BLACK));
        assert_eq!(material_colour(0).to_le_bytes(), [128, 0, 0, 255]);
        assert_eq!(material_colour(2).to_le_bytes(), [128, 128, 0, 255]);
    }

    #[test]
    fn heat_grows_brighter() {
        let brightness = |x: f32| heat(x).iter().sum::<f32>();
        assert!((1..=100).all(|i| brightness(i as f32 / 100.0) > brightness((i - 1) as f32 / 100.0)));
        assert_eq!(rgba(heat(1.0)), 0xffff_ffff);
    }

    #[test]
    fn numbers_become_colours_and_colours_stay() {
        let numbers = [1.0f32, 3.0, f32::INFINITY, 2.0].map(f32::to_bits);
        let spread = Show::Depth.spread(&numbers);
        assert_eq!(spread, Some(Spread { min: 1.0, mean: 2.0, max: 3.0 }));
        let mut depth = numbers;
        Show::Depth.paint([1.0, 3.0], 9, &mut depth);
        assert_eq!(depth, [0xffff_ffff, 0xff26_2626, BLACK, 0xff93_9393]);
        for show in [Show::Normals, Show::Material] {
            let mut words = numbers;
            show.paint([0.0, 1.0], 9, &mut words);
            assert_eq!((words, show.spread(&words)), (numbers, None));
        }
        assert_eq!(Show::Level.spread(&[f32::INFINITY.to_bits()]), None);
    }
}
