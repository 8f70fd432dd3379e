//! The lattice of voxels in the world: `world = origin + voxel_size * grid`.
//!
//! In: a box and a resolution, or an origin and a voxel size of the caller's choice. Out: the map between world and grid,
//! and vertices snapped **once**, in f64, to 1/256 of a voxel (`q = round_half_even((x - origin) * (256 / voxel_size))`).
//! Everything after snapping is integer, so whatever is built does not depend on order, threads or target.

use crate::morton::{BITS, MAX_RESOLUTION};

/// Snapped units per voxel.
pub const SUB: i64 = 256;

/// Where the voxels lie in the world.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Grid {
    /// World position of the corner of voxel (0, 0, 0).
    pub origin: [f64; 3],
    /// Side of a voxel in world units; finite and greater than 0.
    pub voxel_size: f64,
    /// Voxels along the longest axis, 1 to 2^21; coordinates are below it.
    pub resolution: u32,
}

/// An axis-parallel box in world units.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: [f64; 3],
    /// Largest coordinates.
    pub max: [f64; 3],
}

/// Which way is up in a model's own coordinates.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum UpAxis {
    /// +y is up, +z towards the viewer (most OBJ files).
    #[default]
    Y,
    /// +z is up, -y towards the viewer: the same model, turned by `(x, y, z) -> (x, -z, y)`.
    Z,
}

impl UpAxis {
    /// A vector given for y-up, as it is for this axis.
    pub fn turn(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            UpAxis::Y => [x, y, z],
            UpAxis::Z => [x, -z, y],
        }
    }
}

/// Why a grid cannot be laid out.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum GridError {
    /// The resolution is 0 or more than 2^21.
    Resolution {
        /// Voxels along the longest axis that were asked for or that the voxel size leads to.
        asked: f64,
    },
    /// The voxel size is not a finite number greater than 0, or so small that 256 / size overflows.
    VoxelSize {
        /// The voxel size in world units.
        size: f64,
    },
    /// The origin or the box is not finite, or the box is so large that its extent overflows.
    NotFinite,
    /// A vertex lies outside the grid.
    Outside {
        /// Index into the mesh's positions.
        vertex: u32,
    },
}

impl core::fmt::Display for GridError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            GridError::Resolution { asked } => {
                write!(
                    f,
                    "resolution {} is out of range: expected 1 to {MAX_RESOLUTION} voxels along the longest axis",
                    Short(*asked)
                )
            }
            GridError::VoxelSize { size } => {
                write!(f, "voxel size {} is out of range: expected a finite number greater than 0", Short(*size))
            }
            GridError::NotFinite => write!(f, "the grid's origin or the mesh's box is not finite"),
            GridError::Outside { vertex } => {
                write!(
                    f,
                    "vertex {vertex} (counted from 0) lies outside the grid: move the origin or raise the resolution"
                )
            }
        }
    }
}

impl core::error::Error for GridError {}

/// A number with an exponent where its digits would fill the line.
struct Short(f64);

impl core::fmt::Display for Short {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        if self.0 == 0.0 || (1e-4..1e16).contains(&self.0.abs()) { self.0.fmt(f) } else { write!(f, "{:e}", self.0) }
    }
}

impl Bounds {
    /// The centre.
    pub fn center(&self) -> [f64; 3] {
        core::array::from_fn(|i| self.min[i] + (self.max[i] - self.min[i]) * 0.5)
    }

    /// Half the diagonal, in world units.
    pub fn radius(&self) -> f64 {
        // Relative to the largest extent, so that no square over- or underflows.
        let largest = self.extent();
        if largest == 0.0 || !largest.is_finite() {
            return largest;
        }
        let e = crate::math::sub(self.max, self.min).map(|x| x / largest);
        0.5 * largest * crate::math::sqrt(crate::math::dot(e, e))
    }

    /// The largest of the three extents.
    pub fn extent(&self) -> f64 {
        (0..3).map(|i| self.max[i] - self.min[i]).fold(0.0, f64::max)
    }
}

impl Grid {
    /// The grid with `resolution` voxels along the longest axis of `bounds`, its origin at the box's minimum.
    /// A box without extent (a single point) gets a voxel size of 1.
    pub fn fit(bounds: &Bounds, resolution: u32) -> Result<Grid, GridError> {
        let extent = checked_extent(bounds)?;
        let voxel_size = if extent == 0.0 { 1.0 } else { extent / f64::from(resolution) };
        Grid { origin: bounds.min, voxel_size, resolution }.checked()
    }

    /// The grid of voxels of side `voxel_size` from the minimum of `bounds`, with as many voxels as cover the box.
    pub fn with_voxel_size(bounds: &Bounds, voxel_size: f64) -> Result<Grid, GridError> {
        if !(voxel_size > 0.0 && voxel_size.is_finite()) {
            return Err(GridError::VoxelSize { size: voxel_size });
        }
        let asked = libm::ceil(checked_extent(bounds)? / voxel_size).max(1.0);
        if asked > f64::from(MAX_RESOLUTION) {
            return Err(GridError::Resolution { asked });
        }
        Grid { origin: bounds.min, voxel_size, resolution: asked as u32 }.checked()
    }

    /// The same grid, or what is wrong with it. A grid made by hand must pass here before it is used.
    pub fn checked(self) -> Result<Grid, GridError> {
        if self.resolution == 0 || self.resolution > MAX_RESOLUTION {
            return Err(GridError::Resolution { asked: f64::from(self.resolution) });
        }
        // Sizes of 0, below 0, infinite, and no number at all have no such scale either.
        let scale = SUB as f64 / self.voxel_size;
        if !(scale.is_finite() && scale > 0.0) {
            return Err(GridError::VoxelSize { size: self.voxel_size });
        }
        if !self.origin.iter().all(|x| x.is_finite()) {
            return Err(GridError::NotFinite);
        }
        // Both zeros are the same place, and are to be the same bytes.
        Ok(Grid { origin: self.origin.map(|x| x + 0.0), ..self })
    }

    /// Octree levels: the smallest L with `2^L >= resolution`, 0 to 21.
    pub fn depth(&self) -> u8 {
        (u32::BITS - self.resolution.saturating_sub(1).leading_zeros()).min(BITS) as u8
    }

    /// A world position in grid coordinates (voxel k spans k to k + 1).
    #[inline]
    pub fn to_grid(&self, p: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| (p[i] - self.origin[i]) / self.voxel_size)
    }

    /// A grid position in world coordinates.
    #[inline]
    pub fn to_world(&self, p: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| self.origin[i] + p[i] * self.voxel_size)
    }

    /// World position `p` in 1/256 voxels, each coordinate 0 to `256 N - 1`; `None` if it lies outside or is not finite.
    ///
    /// The far border `256 N` belongs to the last voxel, so that planes on voxel boundaries stay where they are.
    pub fn snap(&self, p: [f64; 3]) -> Option<[i32; 3]> {
        let last = SUB * i64::from(self.resolution) - 1;
        Some(self.snap_nearest(p)?.map(|q| q.min(last as i32)))
    }

    /// [`Grid::snap`] with the far border left at `256 N`, so that nothing moves by more than half a unit.
    pub(crate) fn snap_nearest(&self, p: [f64; 3]) -> Option<[i32; 3]> {
        let scale = SUB as f64 / self.voxel_size;
        let border = (SUB * i64::from(self.resolution)) as f64;
        let mut q = [0; 3];
        for i in 0..3 {
            let x = libm::rint((p[i] - self.origin[i]) * scale);
            if !(x >= 0.0 && x <= border) {
                return None;
            }
            q[i] = x as i32;
        }
        Some(q)
    }
}

fn checked_extent(bounds: &Bounds) -> Result<f64, GridError> {
    let all = bounds.min.iter().chain(&bounds.max);
    let extent = bounds.extent();
    if all.into_iter().all(|x| x.is_finite()) && extent.is_finite() { Ok(extent) } else { Err(GridError::NotFinite) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_the_smallest_power_of_two_that_holds_the_resolution() {
        let depth = |resolution| Grid { origin: [0.0; 3], voxel_size: 1.0, resolution }.depth();
        assert_eq!([1, 2, 3, 4, 5, 512, 513, 1 << 21].map(depth), [0, 1, 2, 2, 3, 9, 10, 21]);
    }

    #[test]
    fn voxel_planes_stay_where_they_are() {
        for n in [1u32, 7, 1000, 1024] {
            let bounds = Bounds { min: [0.0; 3], max: [f64::from(n), 1.0, 1.0] };
            let grid = Grid::fit(&bounds, n).unwrap();
            for k in 0..n {
                assert_eq!(grid.snap([f64::from(k), 0.0, 0.0]).unwrap()[0], 256 * k as i32);
            }
            assert_eq!(grid.snap([f64::from(n), 0.0, 0.0]).unwrap()[0], 256 * n as i32 - 1);
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let b = Bounds { min: [0.0; 3], max: [1.0; 3] };
        assert!(matches!(Grid::fit(&b, 0), Err(GridError::Resolution { .. })));
        assert!(matches!(Grid::fit(&b, MAX_RESOLUTION + 1), Err(GridError::Resolution { .. })));
        assert!(matches!(Grid::with_voxel_size(&b, f64::NAN), Err(GridError::VoxelSize { .. })));
        assert!(matches!(Grid::with_voxel_size(&b, 1e-9), Err(GridError::Resolution { .. })));
        for size in [0.0, -0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e-310] {
            let refused = Grid { origin: [0.0; 3], voxel_size: size, resolution: 4 }.checked();
            assert!(matches!(refused, Err(GridError::VoxelSize { .. })), "{size}");
        }
        for origin in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let grid = Grid { origin: [0.0, origin, 0.0], voxel_size: 1.0, resolution: 4 };
            assert_eq!(grid.checked(), Err(GridError::NotFinite));
        }
        let huge = Bounds { min: [-1.7e308; 3], max: [1.7e308; 3] };
        assert_eq!(Grid::fit(&huge, 4), Err(GridError::NotFinite));
        let grid = Grid::fit(&b, 4).unwrap();
        assert_eq!(grid.snap([f64::NAN, 0.0, 0.0]), None);
        assert_eq!(grid.snap([-0.1, 0.0, 0.0]), None);
    }
}
