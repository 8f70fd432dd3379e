//! The ray oracle's own check: every voxel of a small cube, its half-open box against the line, then sorted.
//!
//! Deliberately another text than [`crate::ray`]: small integers, explicit open and closed ends, no steps, no descent.
//! In: an origin in quarters of a voxel, an integer direction, a range of t as fractions. Out: the voxels in order.

use core::cmp::Ordering;

/// A fraction with a denominator greater than 0.
#[derive(Clone, Copy, Debug)]
pub struct Fraction(pub i64, pub i64);

impl Fraction {
    fn cmp(self, other: Fraction) -> Ordering {
        (i128::from(self.0) * i128::from(other.1)).cmp(&(i128::from(other.0) * i128::from(self.1)))
    }
}

/// A ray of small numbers.
#[derive(Clone, Copy, Debug)]
pub struct SmallRay {
    /// In quarters of a voxel.
    pub origin4: [i64; 3],
    /// In voxels.
    pub dir: [i64; 3],
    /// The first t that counts.
    pub t_min: Fraction,
    /// The first t that does not; `None` for no end.
    pub t_max: Option<Fraction>,
}

/// The end of an interval of t, and whether it belongs to it.
type End = (Fraction, bool);

/// The later of two beginnings: at the same t the open one.
fn later(a: Option<End>, b: End) -> Option<End> {
    match a {
        Some(a) if a.0.cmp(b.0).then(b.1.cmp(&a.1)) == Ordering::Greater => Some(a),
        _ => Some(b),
    }
}

/// The earlier of two ends: at the same t the open one.
fn earlier(a: Option<End>, b: End) -> Option<End> {
    match a {
        Some(a) if a.0.cmp(b.0).then(a.1.cmp(&b.1)) == Ordering::Less => Some(a),
        _ => Some(b),
    }
}

/// The times for which the ray is in the voxel, if any.
fn interval(ray: &SmallRay, voxel: [i64; 3]) -> Option<(End, Option<End>)> {
    let mut begin = Some((ray.t_min, true));
    let mut end = ray.t_max.map(|t| (t, false));
    for axis in 0..3 {
        let (o, d) = (ray.origin4[axis], ray.dir[axis]);
        let (lo, hi) = (4 * voxel[axis], 4 * (voxel[axis] + 1));
        match d.signum() {
            0 => {
                if o < lo || o >= hi {
                    return None;
                }
            }
            1 => {
                begin = later(begin, (Fraction(lo - o, 4 * d), true));
                end = earlier(end, (Fraction(hi - o, 4 * d), false));
            }
            _ => {
                begin = later(begin, (Fraction(o - hi, -4 * d), false));
                end = earlier(end, (Fraction(o - lo, -4 * d), true));
            }
        }
    }
    let begin = begin?;
    let Some(end) = end else { return Some((begin, None)) };
    let met = match begin.0.cmp(end.0) {
        Ordering::Less => true,
        Ordering::Equal => begin.1 && end.1,
        Ordering::Greater => false,
    };
    met.then_some((begin, Some(end)))
}

/// The voxels of the cube of side `side` that the ray meets, in order.
pub fn walk(ray: &SmallRay, side: i64) -> Vec<[u32; 3]> {
    let mut met = Vec::new();
    for z in 0..side {
        for y in 0..side {
            for x in 0..side {
                if let Some((begin, _)) = interval(ray, [x, y, z]) {
                    met.push((begin, [x as u32, y as u32, z as u32]));
                }
            }
        }
    }
    // Disjoint intervals: where two begin at the same t, the closed one is that single moment and comes first.
    met.sort_by(|a, b| a.0.0.cmp(b.0.0).then(b.0.1.cmp(&a.0.1)));
    met.into_iter().map(|(_, voxel)| voxel).collect()
}
