//! Normals against integers and Jacobi's eigenvectors, voxel by voxel.

use voxdag::materials::Single;
use voxdag::math::{add_scaled, cross, dot, normalize, sub};
use voxdag::normal::{Confidence, Normal, NormalKind, normal};
use voxdag::simd::Level;
use voxdag::trace::{Face, Hit, TopBuf, Tracer};
use voxdag::{Dag, Morton};

use super::Bytes;
use crate::eigen::jacobi;
use crate::octree::VoxelSet;
use crate::textbook::ernerfeldt;

/// A normal is a unit vector for any input, the same alone and among many, and the one that the documentation describes:
/// a plane, the textbook's plane, the gradient, a line's direction made perpendicular, or the entry face.
///
/// Byte 0: the lowest three bits are the kind, the next three (modulo 7) the face, the upper two where the
/// window lies: in the middle of a cube, at its first corner, at the last one of the deepest cube, or in a cube of side 4.
/// Then the voxel in the window of 7^3 (a u16, modulo 343), and the direction (see `Bytes::float`). The rest fills the
/// window around the voxel (3, 3, 3): a byte (modulo 4) for 0 a box set, 1 a box cleared (two u16 for corners, modulo 343),
/// 2 a slab set (normal of three i8, i8 for the offset, a byte for the thickness), 3 one voxel flipped (u16).
pub fn normals(data: &[u8]) {
    let mut bytes = Bytes(data);
    let choice = bytes.u8();
    let (kind, face) = (NormalKind::ALL[usize::from(choice & 7)], Face::ALL[usize::from(choice >> 3 & 7) % 7]);
    let (depth, corner) = match choice >> 6 {
        0 => (5, [13; 3]),
        1 => (4, [-3; 3]),
        2 => (21, [(1 << 21) - 5; 3]),
        _ => (2, [-1; 3]),
    };
    let place = cell(&mut bytes);
    let dir = bytes.floats(4.0);
    let mut window = [false; 343];
    while !bytes.is_empty() {
        fill(&mut window, &mut bytes);
    }

    // The window's voxels that lie in the cube.
    let in_cube = |v: &Voxel| v.iter().all(|&x| (0..1 << depth).contains(&x));
    let voxels: Vec<Voxel> = (0..343).filter(|&i| window[i]).map(|i| add(corner, cell_of(i))).filter(in_cube).collect();
    let voxel = add(corner, place);
    if voxel.iter().any(|x| !(0..1 << 21).contains(x)) {
        return;
    }
    let words = VoxelSet::new(voxels.iter().map(|v| v.map(|x| x as u32))).words(depth);
    let dag = Dag::new(&words).expect("the twin's words are a DAG");
    let code = Morton::encode(voxel.map(|x| x as u32)).expect("within the cube");
    let hit = Hit { voxel: code, from: None, t: 0.0, level: 0, face };
    let found = normal(&Tracer::new(dag), Single(0), &hit, dir, kind);
    let top = TopBuf::new(&dag, 2).unwrap();
    let tracer = Tracer::with_top(dag, top.as_top()).expect("the grid is this DAG's");
    assert_eq!(normal(&tracer, Single(0), &hit, dir, kind), found, "a top grid changes the normal");
    many(&tracer, &hit, dir, kind);
    let length2: f64 = found.direction.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
    assert!((length2 - 1.0).abs() < 1e-6, "no unit vector: {found:?}");
    if in_cube(&voxel) && dir.iter().all(|x| x.is_finite()) {
        let twin = Twin { voxels, voxel, dir: normalize(dir).unwrap_or([0.0; 3]), face: entry_face(face, dir) };
        twin.check(&found, kind);
    }
}

/// Normals at many hits, of which this is the first, are those one by one: the same voxel through all faces, and those
/// before and after it on the Morton curve.
fn many(tracer: &Tracer<'_, Dag<'_>>, hit: &Hit, dir: [f64; 3], kind: NormalKind) {
    let hits: [Hit; 40] = core::array::from_fn(|i| match i {
        0..7 => Hit { face: Face::ALL[(i + Face::ALL.iter().position(|f| *f == hit.face).unwrap_or(0)) % 7], ..*hit },
        _ => Hit { voxel: Morton(hit.voxel.0.wrapping_add(i as u64 - 7).wrapping_sub(16) & u64::MAX >> 1), ..*hit },
    });
    let bits = |n: Normal| (n.direction.map(f32::to_bits), n.confidence);
    let alone = hits.map(|hit| normal(tracer, Single(0), &hit, dir, kind));
    for level in [None].into_iter().chain(Level::all().map(Some)) {
        let mut found = hits.map(|_| Normal { direction: [0.0; 3], confidence: Confidence::Stored });
        voxdag::normal::normals(level, tracer, Single(0), &hits, &[dir; 40], kind, &mut found);
        assert_eq!(found.map(bits), alone.map(bits), "many at once with {:?}", level.map(Level::name));
    }
}

type Voxel = [i64; 3];

fn cell_of(i: usize) -> Voxel {
    [i % 7, i / 7 % 7, i / 49].map(|x| x as i64)
}

fn cell(bytes: &mut Bytes<'_>) -> Voxel {
    cell_of(usize::from(bytes.u16()) % 343)
}

fn add(a: Voxel, b: Voxel) -> Voxel {
    core::array::from_fn(|i| a[i] + b[i])
}

fn fill(window: &mut [bool; 343], bytes: &mut Bytes<'_>) {
    let kind = bytes.u8() % 4;
    match kind {
        0 | 1 => {
            let (a, b) = (cell(bytes), cell(bytes));
            let inside = |v: Voxel| (0..3).all(|i| (a[i].min(b[i])..=a[i].max(b[i])).contains(&v[i]));
            (0..343).filter(|&i| inside(cell_of(i))).for_each(|i| window[i] = kind == 0);
        }
        2 => {
            let n = bytes.array::<3>().map(|x| i64::from(x as i8));
            let (offset, thick) = (i64::from(bytes.u8() as i8), i64::from(bytes.u8()));
            let height = |v: Voxel| (0..3).map(|i| n[i] * (v[i] - 3)).sum::<i64>() - offset;
            (0..343).filter(|&i| (0..=thick).contains(&height(cell_of(i)))).for_each(|i| window[i] = true);
        }
        _ => {
            let i = usize::from(bytes.u16()) % 343;
            window[i] = !window[i];
        }
    }
}

/// Unit normal of the side of entry; of a ray that starts inside that against its largest component, the first of equals.
fn entry_face(face: Face, dir: [f64; 3]) -> [f64; 3] {
    if face != Face::Inside {
        return face.normal().map(f64::from);
    }
    let largest = dir.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
    let axis = dir.iter().position(|x| x.abs() == largest).expect("one of them is the largest");
    core::array::from_fn(|i| if i != axis { 0.0 } else { if dir[i] > 0.0 { -1.0 } else { 1.0 } })
}

struct Twin {
    voxels: Vec<Voxel>,
    voxel: Voxel,
    /// Unit length, or 0.
    dir: [f64; 3],
    face: [f64; 3],
}

/// What a normal must be.
enum Expected {
    Known([f64; 3]),
    /// It is nothing but rounding errors.
    Unknown,
    /// Either side, or the entry face: the evidence for a side is within rounding of none.
    Close([f64; 3]),
    Face,
}

impl Twin {
    fn check(&self, found: &Normal, kind: NormalKind) {
        let radius = match kind {
            NormalKind::Face => return self.agree(found, Expected::Face, "asked for"),
            NormalKind::Gradient => return self.agree(found, self.gradient(), "gradient"),
            NormalKind::Plane1 | NormalKind::Ernerfeldt1 => 1,
            NormalKind::Stored | NormalKind::Plane2 | NormalKind::Ernerfeldt2 => 2,
            NormalKind::Plane3 => 3,
        };
        let near: Vec<Voxel> = self
            .voxels
            .iter()
            .map(|v| core::array::from_fn(|i| v[i] - self.voxel[i]))
            .filter(|v: &Voxel| v.iter().all(|x| x.abs() <= radius))
            .collect();
        let Some(&first) = near.first() else { return self.agree(found, Expected::Face, "no voxel") };
        let Some(line) = near.iter().map(|&v| minus(v, first)).find(|&v| v != [0; 3]) else {
            return self.agree(found, Expected::Face, "one voxel");
        };
        if near.iter().all(|&v| integer_cross(line, minus(v, first)) == [0; 3]) {
            let line = line.map(|x| x as f64);
            let across = cross(line, cross(self.dir, line));
            let against = self.dir.map(|x| -x);
            return self.agree(found, expected(across, against, dot(line, line)), "line");
        }

        // Relative to the voxel, so that its own place does not matter.
        let n = near.len() as f64;
        if matches!(kind, NormalKind::Ernerfeldt1 | NormalKind::Ernerfeldt2) {
            // By n, so that the textbook's centre of the points has no rounding error, nor has what it makes of them.
            let points: Vec<_> = near.iter().map(|v| v.map(|x| n * x as f64)).collect();
            let axis = ernerfeldt(&points).expect("the voxels span a plane");
            return self.agree(found, expected(axis, self.face, 1.0), "regression");
        }
        let points: Vec<_> = near.iter().map(|v| v.map(|x| x as f64)).collect();
        let center: [f64; 3] = core::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / n);
        let covariance = core::array::from_fn(|i| {
            core::array::from_fn(|j| points.iter().map(|p| (p[i] - center[i]) * (p[j] - center[j])).sum::<f64>())
        });
        let [(l0, axis), (l1, _), _] = jacobi(covariance);
        let ratio = l0.max(0.0) / l1;
        let outwards = sub(add_scaled(self.face, self.dir, -1.0), center);
        let plane = expected(axis, outwards, 1.0);
        match found.confidence {
            Confidence::Plane { ratio: found_ratio } => {
                assert!(ratio < 0.6 + 1e-9, "too thick for a plane: {ratio}, {found:?}");
                assert!((f64::from(found_ratio) - ratio).abs() < 1e-5, "ratio {ratio}: {found:?}");
                self.agree(found, plane, "plane");
            }
            _ if ratio > 0.6 - 1e-9 => self.agree(found, self.gradient(), "solid"),
            _ => {
                assert!(!matches!(plane, Expected::Known(_)), "a plane was not found: {ratio}, {found:?}");
                self.agree(found, Expected::Face, "plane at right angles");
            }
        }
    }

    fn gradient(&self) -> Expected {
        let filled = |axis: usize, step: i64| {
            let mut v = self.voxel;
            v[axis] += step;
            f64::from(u8::from(self.voxels.contains(&v)))
        };
        let gradient: [f64; 3] = core::array::from_fn(|i| filled(i, -1) - filled(i, 1));
        expected(gradient, sub(self.face, self.dir), 1.0)
    }

    fn agree(&self, found: &Normal, expected: Expected, what: &str) {
        let direction = found.direction.map(f64::from);
        let near = |n: [f64; 3]| (0..3).all(|i| (direction[i] - n[i]).abs() < 2e-6);
        let right = match expected {
            Expected::Known(n) => near(n) && found.confidence != Confidence::Face,
            Expected::Close(n) => near(n) || near(n.map(|x| -x)) || near(self.face),
            Expected::Unknown => true,
            Expected::Face => near(self.face) && found.confidence == Confidence::Face,
        };
        assert!(right, "{what}: {found:?} at {:?}, direction {:?}, face {:?}", self.voxel, self.dir, self.face);
    }
}

/// The unit vector along `n` on the side of `outwards`; `scale` is how large `n` and its rounding errors may be.
fn expected(n: [f64; 3], outwards: [f64; 3], scale: f64) -> Expected {
    let Some(unit) = normalize(n) else { return Expected::Face };
    if dot(n, n).sqrt() < 1e-9 * scale {
        return Expected::Unknown;
    }
    let side = dot(unit, outwards);
    if side.abs() < 1e-9 {
        return Expected::Close(unit);
    }
    Expected::Known(if side > 0.0 { unit } else { unit.map(|x| -x) })
}

fn minus(a: Voxel, b: Voxel) -> Voxel {
    core::array::from_fn(|i| a[i] - b[i])
}

fn integer_cross(a: Voxel, b: Voxel) -> Voxel {
    core::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}
