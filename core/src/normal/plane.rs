//! The plane through a set of voxels: the smallest eigenvector of their covariance.
//!
//! In: exact moments. Out: the plane's normal with its quality, or why there is no plane. The thesis fits its planes by
//! weighted regressions instead: see [`super::ernerfeldt`].
//!
//! The covariance times n^2, its minors and its determinant are exact i64. The smallest eigenvalue comes from the
//! characteristic polynomial, whose integer coefficients are the same for all 48 orientations of a neighbourhood, so
//! every orientation takes the same branch. Newton's method from 0 climbs to it, as the polynomial is concave and
//! rising there. The eigenvector is the largest column of `adj(C - l0 I) = (l1 - l0) (l2 - l0) v v^T`: accurate
//! as long as l1 is clear of l0, which is the case wherever the answer is used, and exact zeros stay exact.

use super::window::Moments;
use crate::math;

/// Largest l0 / l1 of a neighbourhood that counts as a plane.
pub(super) const PLANAR: f64 = 0.6;

/// What a set of voxels looks like.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Fit {
    /// No voxel, or a single one.
    Point,
    /// All on one line, with this direction (not of unit length).
    Line([f64; 3]),
    /// Too thick: l0 / l1 is above 0.6.
    Solid,
    /// A plane by weighted regressions: its normal, of either side, not of unit length.
    Regression([f64; 3]),
    /// A plane.
    Plane {
        /// Its normal, of either side, not of unit length.
        normal: [f64; 3],
        /// l0 / l1, 0 (flat) to 0.6.
        ratio: f64,
    },
}

/// How a set of n voxels spreads: n^2 times the covariance, and its adjugate. Exact; off-diagonals by the axis that is
/// missing.
pub(super) struct Scatter {
    d: [i64; 3],
    o: [i64; 3],
    pub(super) adj_d: [i64; 3],
    pub(super) adj_o: [i64; 3],
}

impl Scatter {
    pub(super) fn of(m: &Moments) -> Scatter {
        let (n, s) = (m.count, m.first);
        let next = |i: usize| ((i + 1) % 3, (i + 2) % 3);
        let d: [i64; 3] = core::array::from_fn(|i| n * m.squares[i] - s[i] * s[i]);
        let o: [i64; 3] = core::array::from_fn(|i| {
            let (j, k) = next(i);
            n * m.products[i] - s[j] * s[k]
        });
        let adj_d = core::array::from_fn(|i| {
            let (j, k) = next(i);
            d[j] * d[k] - o[i] * o[i]
        });
        let adj_o = core::array::from_fn(|i| {
            let (j, k) = next(i);
            o[j] * o[k] - o[i] * d[i]
        });
        Scatter { d, o, adj_d, adj_o }
    }

    fn trace(&self) -> i64 {
        self.d.iter().sum()
    }

    /// Sum of the principal minors.
    fn minors(&self) -> i64 {
        self.adj_d.iter().sum()
    }

    /// [`Fit::Point`] or [`Fit::Line`], if the voxels span no more.
    pub(super) fn degenerate(&self) -> Option<Fit> {
        if self.trace() == 0 {
            return Some(Fit::Point);
        }
        // No principal minor: the longest column runs along the line.
        (self.minors() == 0).then(|| Fit::Line(longest_column(self.d.map(|x| x as f64), self.o.map(|x| x as f64))))
    }
}

/// The plane of least squares.
pub(super) fn fit(m: &Moments) -> Fit {
    let scatter = Scatter::of(m);
    if let Some(fit) = scatter.degenerate() {
        return fit;
    }

    // The eigenvalues l0 <= l1 (<= l2, which is not needed).
    let (trace, minors) = (scatter.trace(), scatter.minors());
    let Scatter { d, o, adj_d, adj_o } = scatter;
    let determinant = d[0] * adj_d[0] + o[2] * adj_o[2] + o[1] * adj_o[1];
    let (t, e2, e3) = (trace as f64, minors as f64, determinant as f64);
    let l0 = smallest_root(t, e2, e3);
    let sum = t - l0;
    let product = e2 - l0 * sum;
    let l1 = 2.0 * product / (sum + math::sqrt((sum * sum - 4.0 * product).max(0.0)));
    let ratio = l0 / l1;
    if ratio > PLANAR {
        return Fit::Solid;
    }

    // adj(C - l0 I) = adj(C) + l0 (C - trace I) + l0^2 I.
    let diagonal = core::array::from_fn(|i| adj_d[i] as f64 + l0 * (d[i] as f64 - t) + l0 * l0);
    let off = core::array::from_fn(|i| adj_o[i] as f64 + l0 * o[i] as f64);
    Fit::Plane { normal: longest_column(diagonal, off), ratio }
}

/// Smallest root of `l^3 - t l^2 + e2 l - e3`, all of whose roots are real and at least 0; `e2 > 0`.
///
/// Eight steps reach full accuracy for l0 / l1 <= 0.6. Where roots coincide it stops short of them, still far above
/// 0.6.
fn smallest_root(t: f64, e2: f64, e3: f64) -> f64 {
    let mut l = 0.0;
    for _ in 0..8 {
        let value = ((l - t) * l + e2) * l - e3;
        let slope = (3.0 * l - 2.0 * t) * l + e2;
        let step = -value / slope;
        if !(slope > 0.0 && step > 0.0) {
            break;
        }
        l += step;
        // Convergence is quadratic: what is left is below three times the square of this.
        if step < 1e-6 * l {
            break;
        }
    }
    l
}

/// The column of a symmetric matrix of rank one that has the largest diagonal entry.
fn longest_column(d: [f64; 3], o: [f64; 3]) -> [f64; 3] {
    if d[0] >= d[1] && d[0] >= d[2] {
        [d[0], o[2], o[1]]
    } else if d[1] >= d[2] {
        [o[2], d[1], o[0]]
    } else {
        [o[1], o[0], d[2]]
    }
}
