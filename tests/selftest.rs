//! The short run of `voxdag selftest`: the core is never wrong, and the cases are hard enough for others to be.

use voxdag_oracle::selftest::{self, Tally};

/// The catalogue's rows, V1 to D10, each by a test named after it. H5 has none: nothing is ever deleted from a table.
#[test]
fn every_row_of_the_catalogue_has_its_test() {
    let sources = [
        include_str!("voxelise.rs"),
        include_str!("rays.rs"),
        include_str!("normals.rs"),
        include_str!("shading.rs"),
        include_str!("table.rs"),
        include_str!("dag.rs"),
        include_str!("file.rs"),
        include_str!("selftest.rs"),
    ]
    .concat();
    for (letter, rows) in [('v', 18), ('r', 18), ('n', 14), ('s', 10), ('h', 8), ('d', 10)] {
        for row in (1..=rows).filter(|row| (letter, *row) != ('h', 5)) {
            let name = format!("{letter}{row:02}_");
            let named = |line: &str| line.trim_start().starts_with("fn ") && line.contains(&name);
            assert!(sources.lines().any(named), "no test has {name} in its name");
        }
    }
}

/// Runs the cases of a group and gives the tally of each.
fn run(group: &str) -> Vec<(String, Tally)> {
    let cases = selftest::cases().into_iter().filter(|case| case.group == group);
    cases
        .map(|case| {
            let tally = case.run(false);
            println!("{group}: {}: {} tried, wrong {} {} {}", case.name, tally.tried, tally.f32, tally.f64, tally.ours);
            assert_eq!(tally.ours, 0, "{group}: {}: {:?}", case.name, tally.first);
            (case.name, tally)
        })
        .collect()
}

/// The wrong answers of the cases whose name has a word in it.
fn wrong(tallies: &[(String, Tally)], word: &str) -> [u64; 2] {
    let some = tallies.iter().filter(|(name, _)| name.contains(word));
    some.fold([0; 2], |[a, b], (_, tally)| [a + tally.f32, b + tally.f64])
}

#[test]
fn overlap() {
    let tallies = run("overlap");
    assert!(tallies.iter().all(|(_, tally)| tally.tried > 500));
    // Single precision loses slivers, double precision planes through corners of the largest grid.
    assert!(wrong(&tallies, "slivers, 2^16")[0] > 50 && wrong(&tallies, "slivers")[1] == 0);
    assert!(wrong(&tallies, "x + y + z = c, 2^21")[0] > 0);
}

#[test]
fn rays() {
    let tallies = run("rays");
    assert!(tallies.iter().all(|(_, tally)| tally.tried == 80));
    assert!(wrong(&tallies, "2^3") == [0; 2] || wrong(&tallies, "away, 2^3")[0] > 0);
    assert!(wrong(&tallies, "scenes away, 2^21")[0] > 20);
}

/// Embree's watertightness test with no failure allowed: the first thousand rays of the long run's million.
#[test]
fn r18_no_ray_leaves_a_closed_mesh() {
    let tallies = run("leaks");
    assert_eq!(tallies.iter().map(|(_, tally)| tally.tried).sum::<u64>(), 1024);
    // Nor in f64.
    assert_eq!(wrong(&tallies, "")[1], 0);
}

#[test]
fn normals() {
    let tallies = run("normals");
    assert!(wrong(&tallies, "walls").iter().all(|&n| n > 20) && wrong(&tallies, "2^21")[0] > 20);
}

#[test]
fn long_runs_begin_with_the_short_one() {
    for case in selftest::cases() {
        assert!(case.pieces(false) > 0 && case.pieces(true) >= 100 * case.pieces(false), "{}", case.name);
    }
}
