//! The textbook methods that the core is compared with, as they are usually written: rounding errors and all.
//!
//! In: the same questions as the oracles get. Out: the usual answers. Overlap is closed (touching counts), the tracer
//! accumulates t in f32. They show what exactness costs and what its lack costs, and nothing else uses them.

use num_traits::Float;

type V<F> = [F; 3];

fn sub<F: Float>(a: V<F>, b: V<F>) -> V<F> {
    core::array::from_fn(|i| a[i] - b[i])
}

fn cross<F: Float>(a: V<F>, b: V<F>) -> V<F> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot<F: Float>(a: V<F>, b: V<F>) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Triangle against closed box by 13 separating axes (Akenine-Moeller 2001), relative to the box's centre; the plane is
/// held against one corner, as published, since all three have the same distance from it, but for rounding.
pub fn akenine_moller<F: Float>(triangle: [V<F>; 3], centre: V<F>, half: V<F>) -> bool {
    let v = triangle.map(|p| sub(p, centre));
    let edges = [sub(v[1], v[0]), sub(v[2], v[1]), sub(v[0], v[2])];
    let separates = |axis: V<F>| {
        let p = v.map(|q| dot(axis, q));
        let r = half[0] * axis[0].abs() + half[1] * axis[1].abs() + half[2] * axis[2].abs();
        p[0].min(p[1]).min(p[2]) > r || p[0].max(p[1]).max(p[2]) < -r
    };
    let (zero, one) = (F::zero(), F::one());
    let axes = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    let nine = edges.iter().flat_map(|&e| axes.map(|a| cross(a, e)));
    let n = cross(edges[0], edges[1]);
    let apart = dot(n, v[0]).abs() > half[0] * n[0].abs() + half[1] * n[1].abs() + half[2] * n[2].abs();
    !apart && !axes.into_iter().chain(nine).any(separates)
}

/// Triangle against the closed box `corner .. corner + size` by plane and three projections (Schwarz and Seidel 2010),
/// in f32 and absolute coordinates, as voxelisers on graphics cards do.
pub fn schwarz_seidel(triangle: [V<f32>; 3], corner: V<f32>, size: V<f32>) -> bool {
    let v = triangle;
    let edges = [sub(v[1], v[0]), sub(v[2], v[1]), sub(v[0], v[2])];
    let n = cross(edges[0], edges[1]);
    for i in 0..3 {
        let (lo, hi) = (v[0][i].min(v[1][i]).min(v[2][i]), v[0][i].max(v[1][i]).max(v[2][i]));
        if hi < corner[i] || lo > corner[i] + size[i] {
            return false;
        }
    }
    // The plane must pass between the two corners that are extreme along the normal.
    let critical: V<f32> = core::array::from_fn(|i| if n[i] > 0.0 { size[i] } else { 0.0 });
    let d1 = dot(n, sub(critical, v[0]));
    let d2 = dot(n, sub(sub(size, critical), v[0]));
    let np = dot(n, corner);
    if (np + d1) * (np + d2) > 0.0 {
        return false;
    }
    // In each projection every edge function must reach 0 at the corner that is extreme along the edge's normal.
    for (a, b, c) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        let sign = if n[c] < 0.0 { -1.0 } else { 1.0 };
        for k in 0..3 {
            let normal = [-edges[k][b] * sign, edges[k][a] * sign];
            let d = -(normal[0] * v[k][a] + normal[1] * v[k][b])
                + (size[a] * normal[0]).max(0.0)
                + (size[b] * normal[1]).max(0.0);
            if normal[0] * corner[a] + normal[1] * corner[b] + d < 0.0 {
                return false;
            }
        }
    }
    true
}

/// What [`dda_f32_hit`] meets.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct DdaHit {
    /// The voxel.
    pub voxel: [u32; 3],
    /// Time of entry, as it was accumulated.
    pub t: f32,
    /// The axis whose plane was crossed last; `None` if the ray starts in the voxel.
    pub axis: Option<usize>,
}

/// The first filled voxel of the cube of side 2^`depth` by a DDA that accumulates t in f32 (Amanatides and Woo 1987);
/// `None` also after 3 * 2^`depth` steps.
pub fn dda_f32(origin: V<f32>, dir: V<f32>, depth: u8, filled: impl Fn([u32; 3]) -> bool) -> Option<[u32; 3]> {
    dda_f32_hit(origin, dir, 0.0, depth, filled).map(|hit| hit.voxel)
}

/// [`dda_f32`] from time `t_min` on, with the time and the axis of entry.
pub fn dda_f32_hit(
    origin: V<f32>,
    dir: V<f32>,
    t_min: f32,
    depth: u8,
    filled: impl Fn([u32; 3]) -> bool,
) -> Option<DdaHit> {
    let side = (1u32 << depth) as f32;
    let (mut enter, mut leave) = (t_min, f32::INFINITY);
    let mut entered = None;
    for i in 0..3 {
        let (a, b) = ((0.0 - origin[i]) / dir[i], (side - origin[i]) / dir[i]);
        if a.min(b) > enter {
            (enter, entered) = (a.min(b), Some(i));
        }
        leave = leave.min(a.max(b));
    }
    if enter > leave {
        return None;
    }
    let mut voxel: [i64; 3] =
        core::array::from_fn(|i| ((origin[i] + enter * dir[i]).floor() as i64).clamp(0, (1 << depth) - 1));
    let delta: V<f32> = core::array::from_fn(|i| (1.0 / dir[i]).abs());
    let mut next: V<f32> = core::array::from_fn(|i| {
        let plane = if dir[i] > 0.0 { voxel[i] + 1 } else { voxel[i] };
        if dir[i] == 0.0 { f32::INFINITY } else { (plane as f32 - origin[i]) / dir[i] }
    });
    let mut hit = DdaHit { voxel: [0; 3], t: enter, axis: entered };
    for _ in 0..3u64 << depth {
        if voxel.iter().any(|&k| !(0..1 << depth).contains(&k)) {
            return None;
        }
        hit.voxel = voxel.map(|k| k as u32);
        if filled(hit.voxel) {
            return Some(hit);
        }
        let axis = if next[0] < next[1] && next[0] < next[2] { 0 } else { 1 + usize::from(next[2] <= next[1]) };
        (hit.t, hit.axis) = (next[axis], Some(axis));
        voxel[axis] += if dir[axis] > 0.0 { 1 } else { -1 };
        next[axis] += delta[axis];
    }
    None
}

/// The first filled voxel of the cube of side 2^`depth` in f32, by the sparse voxel octree traversal of graphics cards
/// (Laine and Karras 2010, appendix A, without contours): the cube is `[1, 2)`, planes are `t = k coef - bias`, and
/// components of the direction below 2^-23 are replaced by it. `any(h, corner)` says whether a cube of side 2^h holds a
/// filled voxel.
pub fn esvo_f32(
    origin: V<f32>,
    dir: V<f32>,
    t_max: f32,
    depth: u8,
    any: impl Fn(u8, [u32; 3]) -> bool,
) -> Option<[u32; 3]> {
    const EPSILON: f32 = 1.0 / (1u32 << 23) as f32;
    let size = (1u32 << depth) as f32;
    let longest = dir[0].abs().max(dir[1].abs()).max(dir[2].abs());
    if !(longest > 0.0 && longest.is_finite()) {
        return None;
    }
    // Unit length along the longest axis, so that EPSILON means what it meant to its authors.
    let d: V<f32> = dir.map(|x| {
        let x = x / longest;
        if x.abs() < EPSILON { EPSILON.copysign(x) } else { x }
    });
    let p = origin.map(|x| x / size + 1.0);
    let up: [bool; 3] = core::array::from_fn(|i| d[i] > 0.0);
    let coef: V<f32> = d.map(|x| -1.0 / x.abs());
    // Mirrored so that every ray heads downwards.
    let bias: V<f32> = core::array::from_fn(|i| if up[i] { 3.0 * coef[i] - coef[i] * p[i] } else { coef[i] * p[i] });
    let at = |i: usize, k: u32| (1.0 + k as f32 / size) * coef[i] - bias[i];
    let full = 1u32 << depth;
    let mut t = at(0, full).max(at(1, full)).max(at(2, full)).max(0.0);
    let end = at(0, 0).min(at(1, 0)).min(at(2, 0)).min(t_max * longest / size);

    // Cubes are asked for by their corner, so that no stack is needed.
    let (mut level, mut corner) = (depth, [0u32; 3]);
    loop {
        if !(t <= end) {
            return None;
        }
        let side = 1u32 << level;
        let real: [u32; 3] = core::array::from_fn(|i| if up[i] { full - side - corner[i] } else { corner[i] });
        if any(level, real) {
            if level == 0 {
                return Some(real);
            }
            let half = side / 2;
            level -= 1;
            for i in 0..3 {
                // Below the middle plane, unless the ray crosses it later.
                corner[i] += if at(i, corner[i] + half) > t { half } else { 0 };
            }
            continue;
        }
        // Step over all planes that are crossed first, and up to the lowest cube that holds both places.
        let leave: V<f32> = core::array::from_fn(|i| at(i, corner[i]));
        let first = leave[0].min(leave[1]).min(leave[2]);
        let mut changed = 0;
        for i in (0..3).filter(|&i| leave[i] <= first) {
            if corner[i] == 0 {
                return None;
            }
            let next = corner[i] - side;
            changed |= corner[i] ^ next;
            corner[i] = next;
        }
        t = first.max(t);
        level = (31 - changed.leading_zeros()) as u8;
        corner = corner.map(|k| k >> level << level);
    }
}

/// The normal of a plane through points (Ernerfeldt 2017): the three cofactor directions, weighted by their squared
/// determinants. `None` if the points do not span a plane.
pub fn ernerfeldt<F: Float>(points: &[V<F>]) -> Option<V<F>> {
    let n = F::from(points.len())?;
    let zero = [F::zero(); 3];
    let sum = points.iter().fold(zero, |s, p| core::array::from_fn(|i| s[i] + p[i]));
    let mean = sum.map(|x| x / n);
    let mut c = [zero; 3];
    for p in points {
        let r = sub(*p, mean);
        for i in 0..3 {
            for j in 0..3 {
                c[i][j] = c[i][j] + r[i] * r[j];
            }
        }
    }
    let mut total = zero;
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let det = c[j][j] * c[k][k] - c[j][k] * c[j][k];
        let mut direction = zero;
        direction[i] = det;
        direction[j] = c[i][k] * c[j][k] - c[i][j] * c[k][k];
        direction[k] = c[i][j] * c[j][k] - c[i][k] * c[j][j];
        let weight = if dot(total, direction) < F::zero() { -(det * det) } else { det * det };
        total = core::array::from_fn(|m| total[m] + direction[m] * weight);
    }
    let length = dot(total, total).sqrt();
    (length > F::zero() && length.is_finite()).then(|| total.map(|x| x / length))
}
