//! Polygons into triangles: n - 2 of them always, and a proper cut of every simple polygon.

use voxdag::triangulate::Triangulator;

use super::Bytes;

/// Any polygon becomes n - 2 triangles that do not depend on its first corner; a simple one is covered once, without
/// triangles that are flat, and each of its sides is one of a triangle.
///
/// Byte 0 chooses: 255 a polygon of any floats (see `Bytes::float`); else its lowest three bits a view, modulo 6, of a
/// polygon on a plane whose corners are two i8 each. At most 40 corners are read.
pub fn triangulation(data: &[u8]) {
    let mut bytes = Bytes(data);
    let view = bytes.u8();
    if view == 255 {
        let mut polygon = Vec::new();
        while !bytes.is_empty() && polygon.len() < 40 {
            polygon.push(bytes.floats(4.0));
        }
        cut(&polygon);
        return;
    }
    let flat: Vec<Point> =
        bytes.0.chunks_exact(2).take(40).map(|c| [i64::from(c[0] as i8), i64::from(c[1] as i8)]).collect();
    let triangles = cut(&lift(&flat, usize::from(view & 7) % 6));
    if is_simple(&flat) {
        check_simple(&flat, &triangles);
    }
}

type Point = [i64; 2];

/// The triangles, after the laws that hold for every polygon.
fn cut(polygon: &[[f64; 3]]) -> Vec<[u32; 3]> {
    let mut triangulator = Triangulator::default();
    let triangles = triangulator.triangulate(polygon).expect("memory").to_vec();
    assert_eq!(triangles.len(), polygon.len().saturating_sub(2), "number of triangles");
    assert!(triangles.iter().flatten().all(|&corner| (corner as usize) < polygon.len()));
    // Each of its corners is part of a triangle, and each triangle has three.
    let used = |corner| triangles.iter().any(|t| t.contains(&corner));
    assert!(triangles.is_empty() || (0..polygon.len() as u32).all(used), "a corner is lost");
    assert!(triangles.iter().all(|[a, b, c]| a != b && b != c && c != a));

    // Wherever the list begins, the same triangles come out, in the same order.
    let bits = |p: [f64; 3]| p.map(|x| (x + 0.0).to_bits());
    let places = |polygon: &[[f64; 3]], triangles: &[[u32; 3]]| -> Vec<_> {
        triangles.iter().map(|t| t.map(|corner| bits(polygon[corner as usize]))).collect()
    };
    let expected = places(polygon, &triangles);
    let mut turned = polygon.to_vec();
    for _ in 1..polygon.len() {
        turned.rotate_left(1);
        let triangles = triangulator.triangulate(&turned).expect("memory");
        assert_eq!(places(&turned, triangles), expected, "the first corner matters");
    }
    triangles
}

/// The polygon in space, on a slanted plane, seen from either side along every axis; no float is rounded.
fn lift(polygon: &[Point], view: usize) -> Vec<[f64; 3]> {
    let slanted = |p: &Point| {
        let mut q = [p[0] as f64, p[1] as f64, (p[0] - 2 * p[1]) as f64 * 0.25];
        if view >= 3 {
            q.swap(0, 1);
        }
        q.rotate_left(view % 3);
        q
    };
    polygon.iter().map(slanted).collect()
}

fn turn(a: Point, b: Point, c: Point) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Twice the signed area.
fn area(polygon: &[Point]) -> i64 {
    let n = polygon.len();
    (0..n).map(|i| (polygon[i], polygon[(i + 1) % n])).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
}

/// Whether no two sides have a point in common but the corner between neighbours.
fn is_simple(polygon: &[Point]) -> bool {
    let n = polygon.len();
    let side = |i: usize| (polygon[i], polygon[(i + 1) % n]);
    let on = |p: Point, (a, b): (Point, Point)| {
        turn(a, b, p) == 0 && (0..2).all(|i| (a[i].min(b[i])..=a[i].max(b[i])).contains(&p[i]))
    };
    let meet = |s: (Point, Point), t: (Point, Point)| {
        let across = |s: (Point, Point), t: (Point, Point)| turn(s.0, s.1, t.0).signum() * turn(s.0, s.1, t.1).signum();
        across(s, t) < 0 && across(t, s) < 0 || on(s.0, t) || on(s.1, t) || on(t.0, s) || on(t.1, s)
    };
    n >= 3
        && (0..n).all(|i| {
            let (s, t) = (side(i), side((i + 1) % n));
            s.0 != s.1 && !on(t.1, s) && !on(s.0, t)
        })
        && (0..n).all(|i| (i + 2..n).all(|j| (j + 1) % n == i || !meet(side(i), side(j))))
}

fn check_simple(polygon: &[Point], triangles: &[[u32; 3]]) {
    let whole = area(polygon);
    let corners: Vec<[Point; 3]> = triangles.iter().map(|t| t.map(|corner| polygon[corner as usize])).collect();
    // All turn as the polygon does, so their areas add up, and none is flat.
    assert!(corners.iter().all(|t| area(t) * whole.signum() > 0), "a flat triangle, or one turned over");
    assert_eq!(corners.iter().map(|t| area(t)).sum::<i64>(), whole, "area");

    // Every side of the polygon is one of a triangle, every other side one of two, once in each direction.
    let n = polygon.len() as u32;
    let mut sides: Vec<_> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    sides.sort_unstable();
    assert!(sides.windows(2).all(|pair| pair[0] != pair[1]), "a side twice");
    for [a, b] in &sides {
        let outer = (a + 1) % n == *b;
        assert_eq!(sides.binary_search(&[*b, *a]).is_err(), outer, "side {a} {b}");
    }
}
