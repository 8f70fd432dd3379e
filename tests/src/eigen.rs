//! Eigenvectors of symmetric 3 x 3 matrices, by another method than the core's polynomial.

/// Eigenvalues, ascending, with eigenvectors of a symmetric matrix by cyclic Jacobi rotations (Golub, Van Loan 2013,
/// 8.5).
pub fn jacobi(mut a: [[f64; 3]; 3]) -> [(f64, [f64; 3]); 3] {
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..30 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
            }
            for row in &mut v {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
        }
    }
    let mut pairs = [0, 1, 2].map(|i| (a[i][i], [v[0][i], v[1][i], v[2][i]]));
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0));
    pairs
}
