//! Where samples lie in a pixel, and which pixels take all of them.
//!
//! The centre's rule (Pineda 2021, section 4.4) takes all samples where a pixel shows the nearer half of the scene;
//! regions are those of its section 5.4.3.3. Differs from the thesis: half of the range that the filled voxels span, not
//! of the grid, and along the axis that the camera looks along, not z.
//!
//! The adaptive rule is none of the thesis's. It first takes the corners of the pattern: a straight edge between any two
//! samples also parts the corners, as they span all of them, so that only what is thinner than a pixel or ends in it
//! can hide. Where the corners see one smooth surface they are the pixel, elsewhere the other samples follow.

use glam::Vec3;

use crate::camera::Camera;
use crate::geometry::Geometry;
use crate::material::MaterialId;
use crate::math;
use crate::morton::Morton;

/// Samples per pixel, at fixed places that every float holds exactly.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Samples {
    /// The centre.
    #[default]
    One,
    /// A rotated grid: four rows, four columns.
    Four,
    /// [`Samples::Four`] and the centre.
    Five,
    /// Centres of 4 x 4 cells.
    Sixteen,
    /// Centres of 8 x 8 cells.
    SixtyFour,
}

impl Samples {
    /// The pattern of 1, 4, 5, 16 or 64 samples; `None` for other numbers.
    pub const fn new(count: u32) -> Option<Samples> {
        match count {
            1 => Some(Samples::One),
            4 => Some(Samples::Four),
            5 => Some(Samples::Five),
            16 => Some(Samples::Sixteen),
            64 => Some(Samples::SixtyFour),
            _ => None,
        }
    }

    /// How many there are.
    pub const fn count(self) -> u32 {
        match self {
            Samples::One => 1,
            Samples::Four => 4,
            Samples::Five => 5,
            Samples::Sixteen => 16,
            Samples::SixtyFour => 64,
        }
    }

    /// Where sample `i` (below [`Samples::count`]) lies in its pixel: x and y, above 0 and below 1.
    pub fn position(self, i: u32) -> [f64; 2] {
        const ROTATED: [[f64; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];
        let cells = |side: u32| [i % side, i / side].map(|k| (f64::from(k) + 0.5) / f64::from(side));
        match self {
            Samples::One => CENTER,
            Samples::Four | Samples::Five => ROTATED.get(i as usize).copied().unwrap_or(CENTER),
            Samples::Sixteen => cells(4),
            Samples::SixtyFour => cells(8),
        }
    }

    /// All samples, one bit each.
    const fn all(self) -> u64 {
        u64::MAX >> (64 - self.count())
    }

    /// The sample in the centre; none where the pattern has none there.
    pub(super) const fn center(self) -> u64 {
        match self {
            Samples::One => 1,
            Samples::Five => 1 << 4,
            Samples::Four | Samples::Sixteen | Samples::SixtyFour => 0,
        }
    }

    /// The four corners of a grid of samples; all of the other patterns.
    const fn corners(self) -> u64 {
        match self {
            Samples::Sixteen => 1 | 1 << 3 | 1 << 12 | 1 << 15,
            Samples::SixtyFour => 1 | 1 << 7 | 1 << 56 | 1 << 63,
            _ => self.all(),
        }
    }
}

/// The place of [`Samples::One`].
const CENTER: [f64; 2] = [0.5; 2];

/// Which pixels take all of a picture's [`Samples`].
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum Supersample {
    /// Every pixel.
    #[default]
    All,
    /// Pixels whose centre shows a voxel in some layers; the others take their centre. The colours are those of the
    /// picture with all samples and of the one with [`Samples::One`]. Costs a ray for the centre of each pixel that
    /// the pattern has not itself. See [`Supersample::near`].
    Slab {
        /// 0 to 2: x, y, z.
        axis: u8,
        /// First layer.
        from: u32,
        /// The layer after the last one.
        to: u32,
    },
    /// Pixels of a rectangle; the others take their centre.
    Region {
        /// First column and row.
        from: [u32; 2],
        /// The column and the row after the last ones.
        to: [u32; 2],
    },
    /// Pixels whose corner samples do not all see one smooth surface, or nothing; the others take these four. The same
    /// as [`Supersample::All`] for patterns of fewer than 16 samples, and where surfaces mirror or are transparent.
    ///
    /// One smooth surface: one material, normals within some degrees of the first sample's, and voxels within two
    /// voxels and these degrees of its tangent plane.
    Adaptive {
        /// The angle, 0 to 90.
        degrees: f32,
    },
}

impl Supersample {
    /// Pixels that show the nearer `share` (0 to 1) of the filled voxels' range along the axis on which the camera looks
    /// most; of equal axes the first. The range is exact in grids of up to 1024 voxels a side and to 1/1024 of the side
    /// in larger ones.
    pub fn near<G: Geometry>(geometry: G, camera: &Camera, share: f64) -> Supersample {
        let ahead = math::sub(camera.target, camera.eye);
        let axis = (1..3).fold(0, |axis, i| if ahead[i].abs() > ahead[axis].abs() { i } else { axis });
        let Some([first, last]) = geometry.extent(geometry.depth().saturating_sub(10)) else {
            return Supersample::Slab { axis: 0, from: 0, to: 0 };
        };
        let (first, end) = (first[axis], last[axis] + 1);
        // Whole layers, so that of an odd number the middle one is far: the thesis's `z > (n - 1) / 2`.
        let layers = (f64::from(end - first) * share.clamp(0.0, 1.0)) as u32;
        let (from, to) = if ahead[axis] > 0.0 { (first, first + layers) } else { (end - layers, end) };
        Supersample::Slab { axis: axis as u8, from, to }
    }
    /// The samples of the pixel in the column and row `place`.
    pub(super) fn plan(self, samples: Samples, place: [u32; 2]) -> Plan {
        let one = (Samples::One, Samples::One.all());
        let (first, others) = match self {
            Supersample::All => ((samples, samples.all()), 0),
            Supersample::Slab { .. } => (one, samples.all() & !samples.center()),
            Supersample::Region { from, to } if (0..2).all(|i| (from[i]..to[i]).contains(&place[i])) => {
                ((samples, samples.all()), 0)
            }
            Supersample::Region { .. } => return Plan { turns: [one, (samples, 0)], all: false },
            Supersample::Adaptive { .. } => ((samples, samples.corners()), samples.all() & !samples.corners()),
        };
        Plan { turns: [first, (samples, others)], all: others == 0 }
    }

    /// Whether the pixel whose centre shows a voxel takes all samples because of that.
    pub(super) fn chooses(self, voxel: Morton) -> bool {
        let Supersample::Slab { axis, from, to } = self else { return false };
        voxel.decode().get(usize::from(axis)).is_some_and(|layer| (from..to).contains(layer))
    }
}

/// The samples of a pixel, in two turns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plan {
    /// A pattern, and which of its samples, one bit each: to begin with, and where what these saw calls for more.
    turns: [(Samples, u64); 2],
    /// Whether the pixel takes both turns.
    pub all: bool,
}

impl Plan {
    /// The places of the samples of turn 0 or 1.
    #[inline]
    pub fn places(&self, turn: usize) -> impl Iterator<Item = [f64; 2]> + use<> {
        let (pattern, mut left) = self.turns[turn];
        if turn == 1 && !self.all {
            left = 0;
        }
        core::iter::from_fn(move || {
            let i = left.trailing_zeros();
            left &= left.wrapping_sub(1);
            (i < 64).then(|| pattern.position(i))
        })
    }
}

/// What a sample sees of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub voxel: Morton,
    pub material: MaterialId,
    pub normal: [f32; 3],
}

/// How far apart two samples of one smooth surface may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Smooth {
    cosine: f32,
    sine: f32,
}

/// How far, in voxels, the voxels of a plane may lie off it.
const ROUGHNESS: f32 = 2.0;

impl Smooth {
    pub(super) fn within(degrees: f32) -> Smooth {
        let radians = f64::from(degrees) * (core::f64::consts::PI / 180.0);
        Smooth { cosine: libm::cos(radians) as f32, sine: libm::sin(radians) as f32 }
    }

    /// Whether `b` sees what `a` sees: nothing, or the same surface.
    pub(super) fn joins(&self, a: Option<Seen>, b: Option<Seen>) -> bool {
        let (a, b) = match (a, b) {
            (Some(a), Some(b)) => (a, b),
            (None, None) => return true,
            _ => return false,
        };
        let [p, q] = [a.voxel, b.voxel].map(Morton::decode);
        let way = Vec3::from_array(core::array::from_fn(|i| q[i] as f32 - p[i] as f32));
        let normal = Vec3::from(a.normal);
        a.material == b.material
            && normal.dot(Vec3::from(b.normal)) >= self.cosine
            && normal.dot(way).abs() <= ROUGHNESS + self.sine * way.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_span_the_grids() {
        for samples in [Samples::One, Samples::Four, Samples::Five, Samples::Sixteen, Samples::SixtyFour] {
            assert_eq!(samples.all().count_ones(), samples.count());
            let corners = (0..samples.count()).filter(|i| samples.corners() >> i & 1 != 0).map(|i| samples.position(i));
            let extreme = |p: [f64; 2]| {
                (0..samples.count()).all(|i| (0..2).all(|k| (samples.position(i)[k] - 0.5).abs() <= (p[k] - 0.5).abs()))
            };
            match samples {
                Samples::Sixteen | Samples::SixtyFour => {
                    assert!(corners.clone().count() == 4 && corners.clone().all(extreme))
                }
                _ => assert_eq!(samples.corners(), samples.all()),
            }
        }
    }

    #[test]
    fn surfaces_end_at_materials_edges_and_steps() {
        let at = |x, y, normal, material| Some(Seen { voxel: Morton::encode([x, y, 500]).unwrap(), material, normal });
        let tilted =
            |degrees: f64| [libm::sin(degrees.to_radians()) as f32, libm::cos(degrees.to_radians()) as f32, 0.0];
        let (smooth, up) = (Smooth::within(3.0), tilted(0.0));
        let floor = at(500, 500, up, 1);
        for (other, joined) in [
            (at(500, 500, up, 1), true),
            (at(900, 502, up, 1), true),
            (at(500, 500, up, 2), false),
            (None, false),
            (at(501, 500, tilted(2.9), 1), true),
            (at(501, 500, tilted(3.1), 1), false),
            // A step of three voxels ends the floor nearby; far away it is within the angle.
            (at(503, 503, up, 1), false),
            (at(503, 497, up, 1), false),
            (at(560, 503, up, 1), true),
        ] {
            assert_eq!(smooth.joins(floor, other), joined, "{other:?}");
        }
        assert!(smooth.joins(None, None) && !smooth.joins(None, floor));
        // No angle at all joins nothing, and so does none that is a number.
        assert!(!Smooth::within(f32::NAN).joins(floor, floor));
    }
}
