//! Triangles against voxels (hard-cases, section 2): rational clipping decides, for half-open voxels what the core says,
//! for closed ones what the 13-axis test says in f32 and f64 (Akenine-Moeller 2001).
//!
//! Each triangle is asked about 27 voxels around a point of it, so that scene-long ones cost no more than small ones.
//! Vertices are multiples of 2^-23 of the scene, f32 numbers all of them: what goes wrong is arithmetic, not input.

use voxdag::voxelize::{Cover, Voxelizer};
use voxdag::{Mesh, Morton};

use super::{Case, Tally, Unit};
use crate::clip::{self, Cell, SUB, Triangle};
use crate::rng::Rng;
use crate::subject::unit_grid;
use crate::textbook::akenine_moller;

const CLASSES: [&str; 6] =
    ["random large", "scene-long slivers", "vertices on corners", "planes x + y + z = c", "small", "no area"];
const DEPTHS: [u8; 3] = [10, 16, 21];
/// Triangles of a piece.
const TRIANGLES: u64 = 10;

pub(super) fn cases() -> Vec<Case> {
    let all = DEPTHS.into_iter().flat_map(|depth| (0..CLASSES.len()).map(move |class| (class, depth)));
    all.map(|(class, depth)| {
        let name = format!("{}, 2^{depth}", CLASSES[class]);
        Case::new("overlap", name, Unit::Voxels, [4, 400], Box::new(move |piece| ask(class, depth, piece)))
    })
    .collect()
}

/// A triangle of a class in 1/256 voxels.
fn draw(class: usize, depth: u8, rng: &mut Rng) -> Triangle {
    let side = SUB << depth;
    // 2^-23 of the scene, or 1/256 voxel.
    let step = (side >> 23).max(1);
    let anywhere = |rng: &mut Rng| [(); 3].map(|()| rng.between(0, side / step - 1) * step);
    let corner = |rng: &mut Rng| [(); 3].map(|()| rng.between(0, (1 << depth) - 1) * SUB);
    let near = |rng: &mut Rng, p: [i64; 3], reach: i64| {
        p.map(|x| ((x + rng.between(-reach, reach)) / step * step).clamp(0, side - step))
    };
    match class {
        0 => [(); 3].map(|()| anywhere(rng)),
        1 => {
            // The third corner beside the line of the others, at most some steps away: no side is short.
            let (a, b, t) = (anywhere(rng), anywhere(rng), rng.between(1, 255));
            let on: [i64; 3] = core::array::from_fn(|i| a[i] + (b[i] - a[i]) / 256 * t);
            [a, b, near(rng, on, 4 * step)]
        }
        2 => [(); 3].map(|()| corner(rng)),
        3 => {
            let c = rng.between(1, (1 << depth) - 1);
            let p = [(); 3].map(|()| rng.between(0, (1 << depth) - 1 - c));
            [0, 1, 2].map(|tip| core::array::from_fn(|i| SUB * (p[i] + if i == tip { c } else { 0 })))
        }
        4 => {
            let p = anywhere(rng);
            [(); 3].map(|()| near(rng, p, 3 * SUB / 2))
        }
        // Points, and segments given by two equal or three collinear vertices, on the lattice of half voxels.
        _ => {
            let half = |rng: &mut Rng| [(); 3].map(|()| rng.between(0, (1 << depth) - 1) * SUB / 2);
            let (a, b) = (half(rng), half(rng));
            match rng.below(3) {
                0 => [a; 3],
                1 => [a, b, b],
                _ => [a, b, core::array::from_fn(|i| (a[i] + b[i]) / 2)],
            }
        }
    }
}

fn ask(class: usize, depth: u8, piece: u64) -> Tally {
    let mut tally = Tally::default();
    let mut rng = Rng::new(piece << 8 | (class as u64) << 5 | u64::from(depth));
    for _ in 0..TRIANGLES {
        let mut triangle = draw(class, depth, &mut rng);
        rng.shuffle(&mut triangle);
        check(&triangle, depth, &mut rng, &mut tally);
    }
    tally
}

/// The voxels around a point of a triangle: by the oracle, by the textbook, by the core.
fn check(triangle: &Triangle, depth: u8, rng: &mut Rng, tally: &mut Tally) {
    let positions = triangle.map(|p| p.map(|x| x as f64 / SUB as f64));
    let mesh = Mesh { positions: &positions, triangles: &[[0, 1, 2]], ..Mesh::default() };
    let voxelizer = Voxelizer::new(&mesh, &unit_grid(1 << depth), Cover::Exact);

    const ONE: i64 = 1 << 20;
    let [mut u, mut v] = [rng.between(0, ONE), rng.between(0, ONE)];
    if u + v > ONE {
        (u, v) = (ONE - u, ONE - v);
    }
    let at = |i: usize| (triangle[0][i] * u + triangle[1][i] * v + triangle[2][i] * (ONE - u - v)) / (ONE * SUB);
    for k in 0..27 {
        let voxel = [at(0) + k % 3 - 1, at(1) + k / 3 % 3 - 1, at(2) + k / 9 - 1];
        if voxel.iter().any(|k| !(0..1 << depth).contains(k)) {
            continue;
        }
        let code = Morton::encode(voxel.map(|k| k as u32)).expect("the voxel lies in the cube");
        let brick = Morton(code.0 & !63);
        let found = voxelizer.as_ref().is_ok_and(|all| all.brick(0, brick) >> (code.0 & 63) & 1 == 1);
        let ours = voxelizer.is_ok() && found == clip::meets_voxel(triangle, voxel, Cell::HalfOpen);
        let closed = clip::meets_voxel(triangle, voxel, Cell::Closed);
        let middle = voxel.map(|k| k as f64 + 0.5);
        let f64 = akenine_moller(positions, middle, [0.5; 3]) == closed;
        let single = |p: [f64; 3]| p.map(|x| x as f32);
        let f32 = akenine_moller(positions.map(single), single(middle), [0.5; 3]) == closed;
        tally.count(f32, f64, ours, || format!("triangle {triangle:?} (1/256 voxel), voxel {voxel:?}, 2^{depth}"));
    }
}
