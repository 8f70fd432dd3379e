//! Which voxels the textbook's overlap test marks: 13 separating axes (Akenine-Moeller 2001) in f32 and in f64, beside
//! the exact cover, on the mesh after snapping.
//!
//! In: triangles and their grid. Out: bricks of voxels in Morton order. The test's boxes are closed, ours half-open: voxels
//! that are only touched count as extra. To the textbook's advantage, the way down to bricks is in f64 and made for it.

use rayon::prelude::*;
use voxdag::voxelize::{Cover, VoxelizeError, Voxelizer};
use voxdag::{Grid, Mesh, Morton};
use voxdag_oracle::clip::{self, Cell};
use voxdag_oracle::textbook::akenine_moller;

/// What to do where there is no room for it.
pub const HINT: &str = "take a smaller -r, or raise --memory-limit";

/// A brick's first voxel, and its filled ones.
pub type Brick = (Morton, u64);

/// A triangle, snapped, in voxels, and the first voxel of a brick that it comes within a voxel of.
#[derive(Clone, Copy)]
pub struct Near {
    pub corners: [[f64; 3]; 3],
    pub brick: [u32; 3],
}

impl Near {
    /// The brick's voxels that a test marks, given the triangle and the middle of a voxel of side 1.
    fn mask(&self, test: impl Fn([[f64; 3]; 3], [f64; 3]) -> bool) -> u64 {
        (0..64).fold(0, |mask, bit| {
            let [x, y, z] = Morton(bit).decode();
            let middle = [self.brick[0] + x, self.brick[1] + y, self.brick[2] + z].map(|k| f64::from(k) + 0.5);
            mask | u64::from(test(self.corners, middle)) << bit
        })
    }

    pub fn f32(&self) -> u64 {
        self.mask(|t, middle| akenine_moller(t.map(|p| p.map(|x| x as f32)), middle.map(|x| x as f32), [0.5; 3]))
    }

    pub fn f64(&self) -> u64 {
        self.mask(|t, middle| akenine_moller(t, middle, [0.5; 3]))
    }

    /// By the oracle: rational clipping.
    pub fn oracle(&self) -> u64 {
        let units = self.corners.map(|p| p.map(|x| (x * clip::SUB as f64) as i64));
        self.mask(|_, middle| clip::meets_voxel(&units, middle.map(|x| x as i64), Cell::HalfOpen))
    }

    /// Of the brick's first voxel.
    pub fn code(&self) -> Morton {
        Morton::encode(self.brick).unwrap_or(Morton(0))
    }
}

/// Every triangle with every brick near it; on the threads of the current pool.
pub fn near(mesh: &Mesh<'_>, grid: &Grid) -> Vec<Near> {
    snapped(mesh, grid)
        .flat_map_iter(|corners| {
            let mut near = Vec::new();
            each_brick(corners, grid, |brick| near.push(Near { corners, brick }));
            near
        })
        .collect()
}

/// About how many bytes [`near`] and [`bricks`] take; on the threads of the current pool.
pub fn bytes(mesh: &Mesh<'_>, grid: &Grid) -> u64 {
    let count = snapped(mesh, grid).map(|corners| {
        let mut count = 0;
        each_brick(corners, grid, |_| count += 1);
        count
    });
    // While the list is put together there are two of it; lists of masks come after that.
    2 * size_of::<Near>() as u64 * count.sum::<u64>()
}

/// Triangles, snapped, in voxels.
fn snapped(mesh: &Mesh<'_>, grid: &Grid) -> impl ParallelIterator<Item = [[f64; 3]; 3]> {
    let snapped = |p| grid.snap(p).map_or([0.0; 3], |q| q.map(|x| f64::from(x) / clip::SUB as f64));
    mesh.triangles.par_iter().map(move |t| t.map(|v| snapped(mesh.positions[v as usize])))
}

/// Visits every brick near a triangle.
fn each_brick(corners: [[f64; 3]; 3], grid: &Grid, mut visit: impl FnMut([u32; 3])) {
    let mut open = vec![([0; 3], 1u32 << grid.depth().max(2))];
    while let Some((corner, side)) = open.pop() {
        let half = f64::from(side) / 2.0;
        if !akenine_moller(corners, corner.map(|k: u32| f64::from(k) + half), [half + 1.0; 3]) {
            continue;
        }
        if side == 4 {
            visit(corner);
            continue;
        }
        let side = side / 2;
        open.extend((0..8).map(|octant| (std::array::from_fn(|i| corner[i] + (octant >> i & 1) * side), side)));
    }
}

/// The bricks that a test gives, by what it gives for each triangle; on the threads of the current pool.
pub fn bricks(near: &[Near], test: impl Fn(&Near) -> u64 + Sync) -> Vec<Brick> {
    let mut masks: Vec<Brick> = near.par_iter().map(|near| (near.code(), test(near))).filter(|b| b.1 != 0).collect();
    masks.par_sort_unstable_by_key(|brick| brick.0);
    masks.dedup_by(|next, last| {
        let same = next.0 == last.0;
        if same {
            last.1 |= next.1;
        }
        same
    });
    masks
}

/// The bricks of the exact cover.
pub fn exact(mesh: &Mesh<'_>, grid: &Grid) -> Result<Vec<Brick>, VoxelizeError> {
    let voxelizer = Voxelizer::new(mesh, grid, Cover::Exact)?;
    let parts: Result<Vec<_>, _> =
        (0..voxelizer.subtrees()).into_par_iter().map(|part| subtree(&voxelizer, part)).collect();
    Ok(parts?.concat())
}

/// The bricks of a subtree, with their places in the whole grid.
fn subtree(voxelizer: &Voxelizer<'_>, part: usize) -> Result<Vec<Brick>, VoxelizeError> {
    let (base, mut bricks) = (voxelizer.subtree_code(part).0, Vec::new());
    voxelizer.voxelize::<VoxelizeError>(part, |brick| {
        bricks.push((Morton(base | brick.code.0), brick.mask));
        Ok(())
    })?;
    Ok(bricks)
}

/// Voxels of `truth` that `found` lacks, and voxels that it has beside them. Both in Morton order.
pub fn differing(truth: &[Brick], found: &[Brick]) -> [u64; 2] {
    let (mut missing, mut extra) = (0, 0);
    let (mut truth, mut found) = (truth.iter().peekable(), found.iter().peekable());
    loop {
        let next = match (truth.peek(), found.peek()) {
            (Some(a), Some(b)) => a.0.min(b.0),
            (Some(a), None) => a.0,
            (None, Some(b)) => b.0,
            (None, None) => return [missing, extra],
        };
        let a = truth.next_if(|brick| brick.0 == next).map_or(0, |brick| brick.1);
        let b = found.next_if(|brick| brick.0 == next).map_or(0, |brick| brick.1);
        missing += u64::from((a & !b).count_ones());
        extra += u64::from((b & !a).count_ones());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_for_what_is_near() {
        let shape = voxdag_oracle::scenes::sphere([0.0; 3], 1.0, 3);
        let grid = Grid::fit(&shape.mesh().validate().unwrap(), 64).unwrap();
        let near = near(&shape.mesh(), &grid);
        // Around the surface, 4 pi 8^2 bricks and their neighbours, of one to several triangles each.
        assert!((800..8000).contains(&near.len()), "{}", near.len());
        assert_eq!(bytes(&shape.mesh(), &grid), 2 * size_of_val(&near[..]) as u64);
    }

    #[test]
    fn what_lacks_and_what_is_too_much() {
        let at = |code: u64, mask| (Morton(64 * code), mask);
        let truth = [at(1, 0b1111), at(3, 0b1), at(4, 0b11)];
        let found = [at(0, 0b1), at(1, 0b0111), at(4, 0b111)];
        assert_eq!(differing(&truth, &found), [2, 2]);
        assert_eq!(differing(&found, &truth), [2, 2]);
        assert_eq!(differing(&truth, &truth), [0, 0]);
        assert_eq!(differing(&[], &found), [0, 7]);
    }
}
