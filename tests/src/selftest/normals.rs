//! Normals of neighbourhoods whose true ones are known, or known to turn with them (hard-cases, section 5). The textbook
//! fits a plane to absolute coordinates (Ernerfeldt 2017), in f32 and in f64.
//!
//! Of walls and half spaces (N4 to N7) the normal is an axis; a mirror image has the mirrored normal (N11); and where in
//! the cube a neighbourhood lies does not matter (N12). The textbook is wrong from 1 degree on, the core from any bit on,
//! but for the last digits of mirrored ones.

use voxdag::materials::Single;
use voxdag::math::{cross, dot, sqrt};
use voxdag::normal::{Normal, NormalKind, normal};
use voxdag::trace::{Face, Hit, Tracer};
use voxdag::{Dag, Morton};

use super::{Case, Tally, Unit};
use crate::octree::VoxelSet;
use crate::rng::Rng;
use crate::textbook::ernerfeldt;

type Voxel = [i64; 3];

/// Normals of a piece.
const NORMALS: u64 = 25;

/// The voxels within 2 of one that is filled, relative to it.
struct Around(Vec<Voxel>);

impl Around {
    fn new(filled: impl Fn(Voxel) -> bool) -> Around {
        let all = (0..125).map(|i| [i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2]);
        Around(all.filter(|v| *v == [0; 3] || filled(*v)).collect())
    }

    /// Scattered voxels, a slab or a half space of any slope.
    fn random(rng: &mut Rng) -> Around {
        let (shape, density, n) = (rng.below(3), 1 + rng.below(8), rng.direction());
        let drawn: Vec<u64> = (0..125).map(|_| rng.below(8)).collect();
        Around::new(|v| {
            let height: f64 = (0..3).map(|i| v[i] as f64 * n[i]).sum();
            let drawn = drawn[((v[2] + 2) * 25 + (v[1] + 2) * 5 + v[0] + 2) as usize];
            match shape {
                0 => drawn < density,
                1 => height.abs() < 0.6 && drawn > 0,
                _ => height <= 0.0,
            }
        })
    }

    fn map(&self, f: impl Fn(Voxel) -> Voxel) -> Around {
        Around(self.0.iter().map(|v| f(*v)).collect())
    }

    /// By the core, in a cube of side 2^21.
    fn ours(&self, at: Voxel, dir: [f64; 3]) -> Normal {
        let voxels = self.0.iter().map(|v| [0, 1, 2].map(|i| (at[i] + v[i]) as u32));
        let words = VoxelSet::new(voxels).words(21);
        let voxel = Morton::encode(at.map(|k| k as u32)).expect("the voxel lies in the cube");
        let hit = Hit { voxel, from: None, t: 0.0, level: 0, face: facing(dir) };
        normal(
            &Tracer::new(Dag::new(&words).expect("the twin's words are good")),
            Single(0),
            &hit,
            dir,
            NormalKind::Plane2,
        )
    }

    fn f32(&self, at: Voxel) -> Option<[f64; 3]> {
        let points: Vec<_> = self.0.iter().map(|v| [0, 1, 2].map(|i| (at[i] + v[i]) as f32 + 0.5)).collect();
        ernerfeldt(&points).map(|n| n.map(f64::from))
    }

    fn f64(&self, at: Voxel) -> Option<[f64; 3]> {
        let points: Vec<_> = self.0.iter().map(|v| [0, 1, 2].map(|i| (at[i] + v[i]) as f64 + 0.5)).collect();
        ernerfeldt(&points)
    }
}

/// The side that looks at the viewer most.
fn facing(dir: [f64; 3]) -> Face {
    let axis = (1..3).fold(0, |a, i| if dir[i].abs() > dir[a].abs() { i } else { a });
    let sides = [[Face::NegX, Face::PosX], [Face::NegY, Face::PosY], [Face::NegZ, Face::PosZ]];
    sides[axis][usize::from(dir[axis] < 0.0)]
}

/// Whether two normals, of either sign, are less than a degree apart; also if there is none in both cases.
fn near(a: Option<[f64; 3]>, b: Option<[f64; 3]>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => {
            let sine = cross(a, b);
            libm::atan2(sqrt(dot(sine, sine)), dot(a, b).abs()).to_degrees() < 1.0
        }
        (a, b) => a == b,
    }
}

/// Somewhere in the cube, at least 8 voxels from its border.
fn somewhere(rng: &mut Rng) -> Voxel {
    [(); 3].map(|()| rng.between(8, (1 << 21) - 9))
}

/// A permutation of the axes with signs.
fn turn(rng: &mut Rng) -> impl Fn(Voxel) -> Voxel + use<> {
    let mut order = [0, 1, 2];
    rng.shuffle(&mut order);
    let signs = [(); 3].map(|()| rng.pick(&[-1, 1]));
    move |v| [0, 1, 2].map(|i| signs[i] * v[order[i]])
}

fn turned(v: [f64; 3], turn: impl Fn(Voxel) -> Voxel) -> [f64; 3] {
    // Column by column: where the unit vectors go.
    let columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(&turn);
    [0, 1, 2].map(|i| (0..3).map(|k| columns[k][i] as f64 * v[k]).sum())
}

/// Walls of one to three layers, two sheets with a gap, half spaces (N4 to N7).
fn walls(rng: &mut Rng, tally: &mut Tally) {
    let (kind, turn, at) = (rng.below(4), turn(rng), somewhere(rng));
    let wall = Around::new(|[_, _, z]| match kind {
        0 => z == 0,
        1 => z == 0 || z == -1,
        2 => z == 0 || z == -2,
        _ => z <= 0,
    });
    let wall = wall.map(&turn);
    let up = turned([0.0, 0.0, 1.0], &turn);
    let dir = turned([0.6, 0.5, -0.9], &turn);
    let ours = wall.ours(at, dir).direction.map(f64::from) == up;
    let what = || format!("wall {kind} around {at:?}, normal {up:?}");
    tally.count(near(wall.f32([0; 3]), Some(up)), near(wall.f64([0; 3]), Some(up)), ours, what);
}

/// Images of any neighbourhood under the symmetries of the cube (N11).
fn images(rng: &mut Rng, tally: &mut Tally) {
    let (plain, turn, at, dir) = (Around::random(rng), turn(rng), [1 << 20; 3], rng.direction());
    let image = plain.map(&turn);
    let (n, m) = (plain.ours(at, dir), image.ours(at, turned(dir, &turn)));
    let expected = turned(n.direction.map(f64::from), &turn);
    let ours = m.confidence == n.confidence && (0..3).all(|i| (f64::from(m.direction[i]) - expected[i]).abs() < 1e-6);
    let f32 = near(image.f32([0; 3]), plain.f32([0; 3]).map(|n| turned(n, &turn)));
    let f64 = near(image.f64([0; 3]), plain.f64([0; 3]).map(|n| turned(n, &turn)));
    tally.count(f32, f64, ours, || format!("{n:?} became {m:?}, of {:?} seen along {dir:?}", plain.0));
}

/// Any neighbourhood near the corner of the cube and far from it (N12).
fn places(rng: &mut Rng, tally: &mut Tally) {
    let (voxels, at, dir) = (Around::random(rng), somewhere(rng), rng.direction());
    let ours = voxels.ours([8; 3], dir) == voxels.ours(at, dir);
    let what = || format!("at {at:?}: {:?} seen along {dir:?}", voxels.0);
    tally.count(near(voxels.f32([0; 3]), voxels.f32(at)), near(voxels.f64([0; 3]), voxels.f64(at)), ours, what);
}

pub(super) fn cases() -> Vec<Case> {
    type Draw = fn(&mut Rng, &mut Tally);
    let all: [(&str, Draw); 3] =
        [("walls, sheets and half spaces", walls), ("mirror images and turns", images), ("anywhere in 2^21", places)];
    let case = |(name, draw): (&str, Draw)| {
        let ask = move |piece: u64| {
            let (mut tally, mut rng) = (Tally::default(), Rng::new(piece));
            (0..NORMALS).for_each(|_| draw(&mut rng, &mut tally));
            tally
        };
        Case::new("normals", name.to_owned(), Unit::Normals, [8, 800], Box::new(ask))
    };
    all.map(case).into()
}
