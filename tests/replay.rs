//! The laws of `fuzz/` on stable: over the committed corpus, over inputs that once failed, and over random bytes.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;

use voxdag_oracle::laws;
use voxdag_oracle::rng::Rng;

/// Runs a law over an input and, if it breaks, says which input it was.
fn run(law: fn(&[u8]), name: &str, data: &[u8]) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| law(data))) {
        eprintln!("input: {name}: {data:?}");
        resume_unwind(panic);
    }
}

/// Replays every file of a target in `fuzz/corpus` and `fuzz/regressions`, and says how many there were.
fn replay(law: fn(&[u8]), target: &str) -> usize {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz");
    let mut files: Vec<_> = ["corpus", "regressions"]
        .iter()
        .filter_map(|folder| std::fs::read_dir(fuzz.join(folder).join(target)).ok())
        .flat_map(|entries| entries.map(|entry| entry.unwrap().path()))
        .collect();
    files.sort();
    for file in &files {
        run(law, &file.display().to_string(), &std::fs::read(file).unwrap());
    }
    files.len()
}

#[test]
fn dag_builder_corpus() {
    assert!(replay(laws::dag_builder, "dag_builder") >= 10);
}

#[test]
fn dag_builder_random() {
    for seed in 0..2000 {
        let mut rng = Rng::new(seed);
        let cubes = rng.below(60);
        // Half of the inputs keep to a few coordinates, so that cubes meet and nodes repeat.
        let mask = if seed % 2 == 0 { 0xff } else { 0b0101_1001 };
        let data: Vec<u8> =
            (0..3).chain(3..3 + 4 * cubes).map(|i| rng.bits() as u8 & if i < 3 { 0xff } else { mask }).collect();
        run(laws::dag_builder, &format!("seed {seed}"), &data);
    }
}
