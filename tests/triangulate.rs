//! Laws of triangulation: area kept, triangles disjoint, every edge accounted for, the same for every rotation, and the
//! same as a naive twin that looks at every ear anew in every step.

use voxdag::triangulate::Triangulator;

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A whole number from `-range` to `range`.
    fn within(&mut self, range: i64) -> i64 {
        (self.next() % (2 * range as u64 + 1)) as i64 - range
    }
}

type Point = [i64; 2];

fn turn(a: Point, b: Point, c: Point) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Twice the signed area, by the shoelace formula.
fn area(polygon: &[Point]) -> i64 {
    (0..polygon.len())
        .map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]))
        .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
        .sum()
}

/// The polygon in space, on a slanted plane; six views, seen from either side along every axis.
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

fn cut(polygon: &[[f64; 3]]) -> Vec<[u32; 3]> {
    Triangulator::default().triangulate(polygon).unwrap().to_vec()
}

/// A star-shaped polygon around the origin: points by angle, one per direction. A small range gives many flat corners
/// and corners on the diagonals of others.
fn star(random: &mut Random, corners: usize, range: i64) -> Vec<Point> {
    let mut points: Vec<Point> = vec![[range, 0], [0, range], [-range, 0], [0, -range]];
    points.extend((0..corners).map(|_| [random.within(range), random.within(range)]).filter(|p| *p != [0, 0]));
    let half = |p: &Point| (p[1] < 0 || (p[1] == 0 && p[0] < 0)) as u8;
    points.sort_by(|a, b| half(a).cmp(&half(b)).then_with(|| 0.cmp(&turn([0, 0], *a, *b))));
    points.dedup_by(|a, b| half(a) == half(b) && turn([0, 0], *a, *b) == 0);
    points
}

/// Random points joined at random, then uncrossed side by side (each step shortens the whole, so it ends).
fn tangle(random: &mut Random, corners: usize) -> Vec<Point> {
    let mut points: Vec<Point> = (0..corners).map(|_| [random.within(100_000), random.within(100_000)]).collect();
    let crossing = |points: &[Point]| {
        let n = points.len();
        (0..n).flat_map(|i| (i + 2..n).map(move |j| (i, j))).find(|&(i, j)| {
            let [a, b, c, d] = [i, i + 1, j, (j + 1) % n].map(|i| points[i]);
            let parted = |a, b, c, d| turn(a, b, c).signum() * turn(a, b, d).signum() < 0;
            parted(a, b, c, d) && parted(c, d, a, b)
        })
    };
    while let Some((i, j)) = crossing(&points) {
        points[i + 1..=j].reverse();
    }
    if area(&points) < 0 {
        points.reverse();
    }
    points
}

/// The outline of a maze of unit cells without loops, whose walls have no thickness: every inner wall is walked on both
/// sides, so the polygon touches itself everywhere and crosses itself nowhere.
fn maze(random: &mut Random, side: i64) -> (Vec<Point>, i64) {
    let steps: [Point; 4] = [[0, -1], [1, 0], [0, 1], [-1, 0]];
    let beside = |cell: Point, wall: usize| [cell[0] + steps[wall][0], cell[1] + steps[wall][1]];
    let mut cells = vec![[0, 0]];
    let mut doors = std::collections::HashSet::new();
    for _ in 0..8 * side * side {
        let (cell, wall) = (cells[random.next() as usize % cells.len()], random.next() as usize % 4);
        let next = beside(cell, wall);
        if next.iter().all(|x| (0..side).contains(x)) && !cells.contains(&next) {
            cells.push(next);
            doors.extend([(cell, wall), (next, (wall + 2) % 4)]);
        }
    }
    // Walk along the walls, counter-clockwise within each cell, through every door on the way.
    let corner = |cell: Point, wall: usize| {
        let [dx, dy] = [[0, 0], [1, 0], [1, 1], [0, 1]][wall];
        [cell[0] + dx, cell[1] + dy]
    };
    let mut start = ([0, 0], 0);
    while doors.contains(&start) {
        start.1 += 1;
    }
    let (mut cell, mut wall) = start;
    let mut outline = Vec::new();
    loop {
        outline.push(corner(cell, wall));
        wall = (wall + 1) % 4;
        while doors.contains(&(cell, wall)) {
            cell = beside(cell, wall);
            wall = (wall + 3) % 4;
        }
        if (cell, wall) == start {
            return (outline, 2 * cells.len() as i64);
        }
    }
}

/// A comb with teeth of random length, and flat corners between them.
fn comb(random: &mut Random, teeth: i64) -> Vec<Point> {
    let mut points = vec![[0, 0], [4 * teeth, 0]];
    for tooth in (0..teeth).rev() {
        points.extend([[4 * tooth + 4, 3], [4 * tooth + 2, 10 + random.within(5)], [4 * tooth + 1, 3]]);
    }
    points.push([0, 3]);
    points
}

/// A corridor of width 1 that winds outwards.
fn spiral(corners: usize) -> Vec<Point> {
    let directions = [[1, 0], [0, 1], [-1, 0], [0, -1]];
    let left = |k: usize| directions[(k + 1) % 4];
    let (mut at, mut right_side, mut left_side) = ([0i64, 0i64], vec![[0, 0]], vec![left(0)]);
    for k in 0..corners {
        let step = 4 * (k as i64 / 2 + 1);
        let ([dx, dy], [lx, ly], [mx, my]) = (directions[k % 4], left(k % 4), left((k + 1) % 4));
        at = [at[0] + dx * step, at[1] + dy * step];
        right_side.push(at);
        left_side.push([at[0] + lx + mx, at[1] + ly + my]);
    }
    left_side.reverse();
    right_side.extend(left_side);
    right_side
}

/// Area and disjointness: together, the triangles cover the polygon once.
fn check_cover(polygon: &[Point], name: &str) -> Vec<Vec<[u32; 3]>> {
    assert!(area(polygon) > 0, "{name}: the test's own polygon runs clockwise");
    let views = (0..6).map(|view| cut(&lift(polygon, view)));
    views
        .inspect(|triangles| {
            let corners: Vec<[Point; 3]> = triangles.iter().map(|t| t.map(|i| polygon[i as usize])).collect();
            assert_eq!(triangles.len(), polygon.len() - 2, "{name}: number of triangles");
            assert!(corners.iter().all(|t| area(t) >= 0), "{name}: a triangle is turned over");
            assert_eq!(corners.iter().map(|t| area(t)).sum::<i64>(), area(polygon), "{name}: area");

            // Two convex sets without common interior are parted by a side of one of them.
            let parted =
                |s: &[Point; 3], t: &[Point; 3]| (0..3).any(|i| t.iter().all(|p| turn(s[i], s[(i + 1) % 3], *p) <= 0));
            for (i, s) in corners.iter().enumerate() {
                for t in &corners[..i] {
                    assert!(parted(s, t) || parted(t, s), "{name}: {s:?} and {t:?} overlap");
                }
            }
        })
        .collect()
}

fn check_simple(polygon: &[Point], name: &str) {
    for (view, triangles) in check_cover(polygon, name).into_iter().enumerate() {
        let flat = triangles.iter().any(|t| area(&t.map(|i| polygon[i as usize])) == 0);
        assert!(!flat, "{name}: a triangle is flat");

        // Every side of the polygon once, every diagonal once in each direction.
        let n = polygon.len() as u32;
        let mut sides: Vec<_> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        sides.sort();
        for [a, b] in &sides {
            let outer = (a + 1) % n == *b;
            assert_eq!(sides.binary_search(&[*b, *a]).is_err(), outer, "{name}: side {a} {b}");
        }
        assert!(sides.windows(2).all(|pair| pair[0] != pair[1]), "{name}: a side twice");
        assert_eq!(triangles, naive(&lift(polygon, view), polygon), "{name}: the naive twin differs");
    }
}

/// The definition, word for word: among the corners whose triangle turns left and holds no other corner, the one with
/// the shortest diagonal; ties by the diagonal's ends, then the tip.
fn naive(polygon: &[[f64; 3]], flat: &[Point]) -> Vec<[u32; 3]> {
    let mut ring: Vec<usize> = (0..polygon.len()).collect();
    let mut triangles = Vec::new();
    let first = |mut t: [usize; 3]| {
        while !(polygon[t[0]] <= polygon[t[1]] && polygon[t[0]] <= polygon[t[2]]) {
            t.rotate_left(1);
        }
        t.map(|i| i as u32)
    };
    while ring.len() > 3 {
        let n = ring.len();
        let ear = |i: usize| [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]];
        let holds = |t: [usize; 3], p: Point| (0..3).all(|i| turn(flat[t[i]], flat[t[(i + 1) % 3]], p) >= 0);
        let best = (0..n)
            .filter(|&i| {
                let t = ear(i);
                area(&t.map(|i| flat[i])) > 0 && ring.iter().all(|j| t.contains(j) || !holds(t, flat[*j]))
            })
            .min_by(|&i, &j| {
                let key = |i: usize| {
                    let [a, b, c] = ear(i).map(|i| polygon[i]);
                    let square: f64 = (0..3).map(|i| (a[i] - c[i]) * (a[i] - c[i])).sum();
                    (square, if a < c { [a, c] } else { [c, a] }, b)
                };
                key(i).partial_cmp(&key(j)).unwrap()
            })
            .expect("a simple polygon has an ear");
        triangles.push(first(ear(best)));
        ring.remove(best);
    }
    triangles.push(first([ring[0], ring[1], ring[2]]));
    triangles
}

#[test]
fn simple_polygons_are_covered_once() {
    for seed in 0..400 {
        let random = &mut Random(seed);
        let (corners, range) = (random.next() as usize % 40, [2, 4, 8, 1000][seed as usize % 4]);
        check_simple(&star(random, corners, range), &format!("star, seed {seed}"));
    }
    for seed in 0..200 {
        let random = &mut Random(seed);
        let corners = 4 + random.next() as usize % 30;
        check_simple(&tangle(random, corners), &format!("tangle, seed {seed}"));
    }
    for teeth in 1..12 {
        check_simple(&comb(&mut Random(teeth as u64), teeth), &format!("comb of {teeth} teeth"));
    }
    for corners in 1..24 {
        check_simple(&spiral(corners), &format!("spiral of {corners} corners"));
    }
}

/// Polygons that touch themselves are common in files: holes are joined to the outside by a bridge.
#[test]
fn polygons_that_touch_themselves_are_covered_once() {
    let hole = [[0, 0], [9, 0], [9, 9], [0, 9], [0, 0], [3, 3], [3, 6], [6, 6], [6, 3], [3, 3]];
    assert_eq!(area(&hole), 2 * (81 - 9));
    check_cover(&hole, "hole");

    // A long spike from the far end touches a side of the ear with the shortest diagonal, or its tip; then it comes
    // along the side.
    for along in [false, true] {
        for touch in [[-10, -50], [0, -100]] {
            let back = if along { vec![[-20, 0]] } else { vec![] };
            let mut spiked = vec![[-20, 0], [0, -100], [20, 0], [20, 300], [5, 300], touch];
            spiked.extend(back);
            spiked.extend([[-5, 300], [-20, 300]]);
            check_cover(&spiked, &format!("spike to {touch:?}"));
            let mirrored: Vec<Point> = spiked.iter().rev().map(|p| [-p[0], p[1]]).collect();
            check_cover(&mirrored, &format!("mirrored spike to {touch:?}"));
        }
    }

    // Corners twice, and spikes outwards, bound no area.
    for seed in 0..400 {
        let random = &mut Random(seed);
        let range = [4, 1000][seed as usize % 2];
        let mut polygon = star(random, 12, range);
        let expected = area(&polygon);
        for _ in 0..4 {
            let at = random.next() as usize % polygon.len();
            let p = polygon[at];
            let spike = [[2 * p[0], 2 * p[1]], p];
            polygon.splice(at..at, if random.next().is_multiple_of(2) { vec![p] } else { [&[p][..], &spike].concat() });
        }
        assert_eq!(area(&polygon), expected, "the test's own polygon, seed {seed}");
        check_cover(&polygon, &format!("spikes, seed {seed}"));
    }

    for seed in 0..400 {
        let random = &mut Random(seed);
        let side = 1 + (random.next() % 6) as i64;
        let (outline, doubled) = maze(random, side);
        assert_eq!(area(&outline), doubled, "the test's own outline, seed {seed}");
        check_cover(&outline, &format!("maze, seed {seed}"));
    }
}

/// Non-planar, crossing, with repeated corners, near and far from the origin: the first corner changes nothing.
#[test]
fn rotation_changes_nothing() {
    for seed in 0..3000 {
        let random = &mut Random(seed);
        let corners = 4 + (random.next() % if seed % 2 == 0 { 1 } else { 12 }) as usize;
        let range = [2, 50, 1 << 40][seed as usize % 3];
        let scale = [1.0, 0.1, 1e-30][(seed / 3) as usize % 3];
        let mut polygon: Vec<[f64; 3]> =
            (0..corners).map(|_| [0; 3].map(|_| random.within(range) as f64 * scale)).collect();
        let places = |polygon: &[[f64; 3]]| -> Vec<[[f64; 3]; 3]> {
            cut(polygon).iter().map(|t| t.map(|i| polygon[i as usize])).collect()
        };
        let expected = places(&polygon);
        assert_eq!(expected.len(), corners - 2, "seed {seed}");
        for _ in 0..corners {
            polygon.rotate_left(1);
            assert_eq!(places(&polygon), expected, "seed {seed}");
        }
    }
}

/// 10,000 corners are quadratic work, not cubic: also where no ear is valid, or all are.
#[test]
fn large_polygons_do_not_take_minutes() {
    let start = std::time::Instant::now();
    let random = &mut Random(1);
    let spiral = lift(&spiral(5000), 0);
    let star = lift(&star(random, 9_990, 1000), 0);
    let mess: Vec<[f64; 3]> = (0..10_000).map(|_| [0; 3].map(|_| random.within(1000) as f64)).collect();
    for polygon in [spiral, star, mess] {
        assert_eq!(cut(&polygon).len(), polygon.len() - 2);
    }
    let seconds = start.elapsed().as_secs();
    assert!(seconds < 60, "took {seconds} s");
}
