//! Polygons into triangles, by geometry only.
//!
//! In: the corners of a polygon, in order, concave, not quite planar or broken as they come. Out: always `n - 2`
//! triangles of corner indices, in the polygon's orientation. Among the valid ears the one with the shortest diagonal
//! is cut first (ties: the diagonal's ends, then the tip, by coordinates); where no ear is valid, as in polygons that
//! cross themselves, the shortest diagonal of all. Ear cutting: Meisters, "Polygons have ears" (1975); what differs:
//!
//! - The corners are read from the least rotation of their coordinates (Booth 1980), so the corner that a file happens
//!   to begin with changes nothing, not even the order of the triangles.
//! - Every decision is exact: the polygon is rounded once to a lattice of its own, 2^-50 of its largest extent (about
//!   what f64 itself keeps of it), and from there on all is integer: no tolerance, no overflow, no sign that flips.
//! - A blocked ear is looked at again only when a neighbour of its tip is cut, hence O(n^2): in a simple polygon nothing
//!   else can free it. (Its last blocker would itself be an ear. But the tip sees that corner, and the sides that meet
//!   there come from across the diagonal, so the corner is reflex.)

use alloc::vec::Vec;
use core::cmp::Ordering;

/// Cuts polygons; keeps its memory from one to the next.
#[derive(Clone, Debug, Default)]
pub struct Triangulator {
    corners: Vec<Corner>,
    triangles: Vec<[u32; 3]>,
}

/// A corner in the ring of those that are left.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// Index in the caller's polygon.
    index: u32,
    /// Place in the ring, before and after.
    prev: u32,
    next: u32,
    /// Position on the lattice, and the same seen along the normal's main axis, counter-clockwise.
    position: [i64; 3],
    flat: [i64; 2],
    /// Square of the distance between its two neighbours.
    diagonal: i128,
    /// Whether it can be cut off.
    ear: bool,
}

/// Lattice units along the polygon's largest extent, as a power of two. Products of two differences stay below 2^101,
/// which leaves `i128` room for the sum over 2^25 corners.
const LATTICE_BITS: i32 = 50;

impl Triangulator {
    /// The triangles of `polygon`, as indices into it: `n - 2` of them, none if there are fewer than 3 corners.
    ///
    /// Each triangle begins with the corner whose coordinates come first. O(n^2). Coordinates that are not finite give
    /// some triangles, but no panic. At most 2^32 - 1 corners; more give no triangles. `Err` with the number of bytes that
    /// could not be had.
    pub fn triangulate(&mut self, polygon: &[[f64; 3]]) -> Result<&[[u32; 3]], usize> {
        self.triangles.clear();
        self.corners.clear();
        let triangles = polygon.len().saturating_sub(2);
        self.triangles.try_reserve(triangles).map_err(|_| triangles * size_of::<[u32; 3]>())?;
        if polygon.len() > 3 {
            self.corners.try_reserve(polygon.len()).map_err(|_| polygon.len() * size_of::<Corner>())?;
        }
        if polygon.len() == 3 {
            self.triangles.push(from_least(polygon, [0, 1, 2]));
        } else if polygon.len() > 3 && u32::try_from(polygon.len()).is_ok() {
            self.load(polygon);
            self.cut(polygon);
        }
        Ok(&self.triangles)
    }

    /// Fills the ring from the least rotation on, with lattice positions and the state of every ear.
    fn load(&mut self, polygon: &[[f64; 3]]) {
        let n = polygon.len() as u32;
        let start = least_rotation(polygon);
        let lattice = Lattice::new(polygon);
        self.corners.extend((0..n).map(|place| {
            let index = (start + place as usize) % polygon.len();
            let position = lattice.position(polygon[index]);
            let (prev, next) = ((place + n - 1) % n, (place + 1) % n);
            Corner { index: index as u32, prev, next, position, flat: [0; 2], diagonal: 0, ear: false }
        }));

        // Look along the main axis of Newell's normal, from the side where the polygon turns counter-clockwise.
        let mut normal = [0i128; 3];
        for place in 0..n {
            let (a, b) = (self.at(place).position, self.at(self.at(place).next).position);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let term = i128::from(a[j]) * i128::from(b[k]) - i128::from(a[k]) * i128::from(b[j]);
                normal[i] = normal[i].saturating_add(term);
            }
        }
        let size = normal.map(i128::unsigned_abs);
        let main = (1..3).fold(0, |best, i| if size[i] > size[best] { i } else { best });
        let (mut u, mut v) = ((main + 1) % 3, (main + 2) % 3);
        if normal[main] < 0 {
            core::mem::swap(&mut u, &mut v);
        }
        for corner in &mut self.corners {
            corner.flat = [corner.position[u], corner.position[v]];
        }

        for place in 0..n {
            self.measure(place);
        }
    }

    /// Cuts ears until one triangle is left.
    fn cut(&mut self, polygon: &[[f64; 3]]) {
        // Some place that is left.
        let mut start = 0;
        for _ in 3..self.corners.len() {
            // Find the best ear.
            let mut best = start;
            let mut place = self.at(start).next;
            while place != start {
                if self.order(place, best).is_lt() {
                    best = place;
                }
                place = self.at(place).next;
            }

            // Cut it off.
            let tip = *self.at(best);
            self.emit(polygon, best);
            self.corners[tip.prev as usize].next = tip.next;
            self.corners[tip.next as usize].prev = tip.prev;
            start = tip.next;

            // Look again at its neighbours.
            self.measure(tip.prev);
            self.measure(tip.next);
        }
        self.emit(polygon, start);
    }

    #[inline]
    fn at(&self, place: u32) -> &Corner {
        &self.corners[place as usize]
    }

    /// Writes the triangle of a corner and its neighbours.
    fn emit(&mut self, polygon: &[[f64; 3]], place: u32) {
        let tip = self.at(place);
        let corners = [tip.prev, place, tip.next].map(|place| self.at(place).index);
        self.triangles.push(from_least(polygon, corners));
    }

    /// Finds a corner's diagonal, and whether it is an ear, anew.
    fn measure(&mut self, place: u32) {
        let tip = *self.at(place);
        let (a, c) = (*self.at(tip.prev), *self.at(tip.next));
        let square = |i: usize| {
            let d = i128::from(a.position[i] - c.position[i]);
            d * d
        };
        let diagonal = square(0) + square(1) + square(2);
        // A corner in the place of a neighbour, or the tip of a spike, bounds no area: cutting it off is always right.
        let degenerate = tip.position == a.position || tip.position == c.position || a.position == c.position;
        let ear = degenerate || (turn(a.flat, tip.flat, c.flat) > 0 && !self.is_blocked(&tip));
        let corner = &mut self.corners[place as usize];
        corner.diagonal = diagonal;
        corner.ear = ear;
    }

    /// Whether another corner lies in the triangle of a convex one.
    fn is_blocked(&self, tip: &Corner) -> bool {
        let triangle = [self.at(tip.prev).flat, tip.flat, self.at(tip.next).flat];
        let [a, b, c] = triangle;
        let low = [a[0].min(b[0]).min(c[0]), a[1].min(b[1]).min(c[1])];
        let high = [a[0].max(b[0]).max(c[0]), a[1].max(b[1]).max(c[1])];
        let mut place = self.at(tip.next).next;
        while place != tip.prev {
            let corner = self.at(place);
            let p = corner.flat;
            let near = low[0] <= p[0] && p[0] <= high[0] && low[1] <= p[1] && p[1] <= high[1];
            if near && self.blocks(corner, triangle) {
                return true;
            }
            place = corner.next;
        }
        false
    }

    /// Whether a corner lies in the triangle `[a, b, c]` of an ear with tip `b`, so that `a c` is no diagonal.
    fn blocks(&self, corner: &Corner, [a, b, c]: [[i64; 2]; 3]) -> bool {
        let p = corner.flat;
        let (ab, bc, ca) = (turn(a, b, p), turn(b, c, p), turn(c, a, p));
        if ab < 0 || bc < 0 || ca < 0 {
            return false;
        }
        if ca == 0 {
            return p != a && p != c;
        }
        // On the sides that meet at the tip, the polygon may touch itself from outside: it is in the way only if it
        // goes on inwards.
        let inwards = |q: [i64; 2]| (ab > 0 || turn(a, b, q) > 0) && (bc > 0 || turn(b, c, q) > 0);
        inwards(self.at(corner.prev).flat) || inwards(self.at(corner.next).flat)
    }

    /// The order in which ears are cut.
    fn order(&self, i: u32, j: u32) -> Ordering {
        let rank = |place: u32| {
            let corner = self.at(place);
            (!corner.ear, corner.diagonal)
        };
        let tie = |place: u32| {
            let corner = self.at(place);
            let (a, c) = (self.at(corner.prev).position, self.at(corner.next).position);
            (a.min(c), a.max(c), corner.position, place)
        };
        rank(i).cmp(&rank(j)).then_with(|| tie(i).cmp(&tie(j)))
    }
}

/// Twice the signed area of a triangle: positive if it turns counter-clockwise.
#[inline]
fn turn(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i128 {
    i128::from(b[0] - a[0]) * i128::from(c[1] - a[1]) - i128::from(b[1] - a[1]) * i128::from(c[0] - a[0])
}

/// Coordinates in a total order in which both zeros are equal, as they are in space.
#[inline]
fn order_of(a: [f64; 3], b: [f64; 3]) -> Ordering {
    let axis = |i: usize| (a[i] + 0.0).total_cmp(&(b[i] + 0.0));
    axis(0).then_with(|| axis(1)).then_with(|| axis(2))
}

/// The rotation of a triangle whose coordinates come first.
fn from_least(polygon: &[[f64; 3]], [i, j, k]: [u32; 3]) -> [u32; 3] {
    let order = |x: &[u32; 3], y: &[u32; 3]| {
        let corner = |place: usize| order_of(polygon[x[place] as usize], polygon[y[place] as usize]);
        corner(0).then_with(|| corner(1)).then_with(|| corner(2))
    };
    let mut least = [i, j, k];
    for rotation in [[j, k, i], [k, i, j]] {
        if order(&rotation, &least).is_lt() {
            least = rotation;
        }
    }
    least
}

/// Where the rotation begins whose coordinates come first. O(n): two candidates run against each other, and a mismatch
/// rules out every start that the loser has passed.
fn least_rotation(polygon: &[[f64; 3]]) -> usize {
    let n = polygon.len();
    let (mut i, mut j, mut equal) = (0, 1, 0);
    while i < n && j < n && equal < n {
        match order_of(polygon[(i + equal) % n], polygon[(j + equal) % n]) {
            Ordering::Equal => {
                equal += 1;
                continue;
            }
            Ordering::Greater => i += equal + 1,
            Ordering::Less => j += equal + 1,
        }
        if i == j {
            j += 1;
        }
        equal = 0;
    }
    i.min(j)
}

/// From world coordinates to whole numbers 0 to 2^[`LATTICE_BITS`].
struct Lattice {
    /// The polygon's least coordinates, quartered.
    min: [f64; 3],
    /// Lattice units per quartered world unit, as a power of two.
    shift: i32,
}

impl Lattice {
    fn new(polygon: &[[f64; 3]]) -> Lattice {
        // Quarters, so that no extent of finite coordinates overflows.
        let bound = |i: usize, start: f64, pick: fn(f64, f64) -> f64| {
            polygon.iter().fold(start, |bound, p| pick(bound, p[i] * 0.25))
        };
        let min: [f64; 3] = core::array::from_fn(|i| bound(i, f64::INFINITY, f64::min));
        let extent = (0..3).map(|i| bound(i, f64::NEG_INFINITY, f64::max) - min[i]).fold(0.0, f64::max);
        // 2^(exponent - 1) <= extent < 2^exponent.
        let (_, exponent) = libm::frexp(extent);
        Lattice { min, shift: if extent.is_finite() { LATTICE_BITS - exponent } else { 0 } }
    }

    fn position(&self, p: [f64; 3]) -> [i64; 3] {
        core::array::from_fn(|i| {
            let units = libm::round(libm::scalbn(p[i] * 0.25 - self.min[i], self.shift));
            // The cast saturates, and takes NaN for 0; the clamp is for coordinates that are not finite.
            (units as i64).clamp(0, 1 << LATTICE_BITS)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(polygon: &[[f64; 2]]) -> Vec<[u32; 3]> {
        let polygon: Vec<_> = polygon.iter().map(|p| [p[0], p[1], 0.5]).collect();
        Triangulator::default().triangulate(&polygon).unwrap().to_vec()
    }

    #[test]
    fn the_shorter_diagonal_wins_if_it_is_inside() {
        // A rhombus, and an arrowhead whose short diagonal runs outside.
        assert_eq!(cut(&[[0.0, 0.0], [3.0, -1.0], [6.0, 0.0], [3.0, 1.0]]), [[0, 1, 3], [1, 2, 3]]);
        assert_eq!(cut(&[[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.0, 2.0]]), [[0, 1, 3], [2, 3, 1]]);
    }

    #[test]
    fn broken_polygons_still_give_all_their_triangles() {
        assert!(cut(&[[0.0, 0.0], [1.0, 0.0]]).is_empty());
        let point = [[1.0, 1.0]; 7];
        let line = [[0.0, 0.0], [3.0, 3.0], [1.0, 1.0], [2.0, 2.0], [1.0, 1.0]];
        let bow_tie = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
        let wild = [[f64::NAN, 1.0], [f64::INFINITY, 0.0], [-1e308, 1e308], [1e308, -1e308], [5e-324, 0.0]];
        for polygon in [&point[..], &line, &bow_tie, &wild] {
            assert_eq!(cut(polygon).len(), polygon.len() - 2);
        }
    }

    #[test]
    fn spikes_and_repeated_corners_cost_no_area() {
        // A square with a doubled corner, a spike and a flat corner.
        let polygon = [[0., 0.], [2., 0.], [2., 0.], [2., 2.], [5., 5.], [2., 2.], [1., 2.], [0., 2.]];
        let area: f64 = cut(&polygon)
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| polygon[i as usize]);
                ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
            })
            .sum();
        assert_eq!(area, 8.0);
    }
}
