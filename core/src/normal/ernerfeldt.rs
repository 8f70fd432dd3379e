//! The plane through a set of voxels by weighted regressions (Ernerfeldt 2017, "Fitting a plane to noisy points in 3D"),
//! as Pineda 2021, section 4.3.2, has it.
//!
//! In: exact moments, where both subtract a centroid in floats. Out: the plane's normal, or why there is none. Along
//! each axis the plane is a linear regression of that coordinate on the other two, whose normal is a column of the
//! covariance's adjugate. The three are summed, each weighted by the square of its determinant, the column's diagonal
//! entry, and turned to where the sum so far points.
//!
//! Columns at right angles have no side to agree on and keep their own, so that what all three axes see adds up towards
//! (+, +, +): a normal tilts by atan(sqrt 2 (u / v)^3) where voxels vary by u across a plane and by v along it, 4.3
//! degrees on a wall of two layers (3^3), 3 on a half space, 10 on two parallel sheets (5^3). In `tests/normals.rs`
//! 405 of 5,960 mirror images have another normal, by up to 86 degrees where no plane is clear. [`super::plane`] has
//! none of this.

use super::plane::{Fit, Scatter};
use super::window::Moments;
use crate::math;

/// The weighted regressions.
pub(super) fn fit(m: &Moments) -> Fit {
    let scatter = Scatter::of(m);
    if let Some(fit) = scatter.degenerate() {
        return fit;
    }
    let (d, o) = (scatter.adj_d.map(|x| x as f64), scatter.adj_o.map(|x| x as f64));
    let columns = [[d[0], o[2], o[1]], [o[2], d[1], o[0]], [o[1], o[0], d[2]]];
    let mut sum = [0.0; 3];
    for (column, determinant) in columns.into_iter().zip(d) {
        let weight = determinant * determinant;
        let side = if math::dot(sum, column) < 0.0 { -weight } else { weight };
        sum = math::add_scaled(sum, column, side);
    }
    Fit::Regression(sum)
}
