//! The laws of `fuzz/` on stable: over the committed corpus, over inputs that once failed, and over mutations of both.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;

use voxdag_oracle::laws::{ALL, Law};
use voxdag_oracle::rng::Rng;

/// Runs a law over an input and, if it breaks, says which input it was.
fn run(law: Law, name: &str, data: &[u8]) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| law(data))) {
        eprintln!("input: {name}: {data:?}");
        resume_unwind(panic);
    }
}

/// The files of a target in one of the folders of `fuzz/`, by name.
fn files(folder: &str, target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz").join(folder).join(target);
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.display().to_string(), std::fs::read(path).unwrap())).collect()
}

fn law_of(target: &str) -> Law {
    ALL.iter().find(|(name, _)| *name == target).unwrap_or_else(|| panic!("no law named {target}")).1
}

/// One of an input's many neighbours: some bytes changed, taken out, doubled, or taken from another input.
fn mutated(data: &[u8], other: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut data = data.to_vec();
    for _ in 0..=rng.below(4) {
        let at = rng.below(data.len() as u64 + 1) as usize;
        let end = (at + 1 + rng.below(8) as usize).min(data.len());
        match rng.below(5) {
            0 => data[at..end].iter_mut().for_each(|byte| *byte = rng.bits() as u8),
            1 => data[at..end].iter_mut().take(1).for_each(|byte| *byte ^= 1 << rng.below(8)),
            2 => _ = data.drain(at..end),
            3 => data.extend_from_within(at..end),
            _ => {
                let from = rng.below(other.len() as u64 + 1) as usize;
                data.splice(at..end, other[from..].iter().take(64).copied());
            }
        }
    }
    data.truncate(1024);
    data
}

/// Replays a target's files and as many mutations of them.
fn replay(target: &str, mutations: u64) {
    let law = law_of(target);
    let inputs = [files("corpus", target), files("regressions", target)].concat();
    assert!(inputs.len() >= 10, "{} inputs are too few", inputs.len());
    for (name, data) in &inputs {
        run(law, name, data);
    }
    for seed in 0..mutations {
        let mut rng = Rng::new(seed);
        let [(name, data), (_, other)] = [(); 2].map(|()| &inputs[rng.below(inputs.len() as u64) as usize]);
        run(law, &format!("seed {seed}, {name}"), &mutated(data, other, &mut rng));
    }
}

/// Every target has a law and a test here, and every law a target.
#[test]
fn targets_are_laws() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/fuzz_targets");
    let mut targets: Vec<_> = std::fs::read_dir(fuzz)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_string())
        .collect();
    targets.sort();
    assert_eq!(targets, ALL.map(|(name, _)| name.to_string()));
}

#[test]
fn dag_builder() {
    replay("dag_builder", 2000);
}

#[test]
fn file() {
    replay("file", 3000);
}

#[test]
fn materials() {
    replay("materials", 1500);
}

#[test]
fn mtl() {
    replay("mtl", 5000);
}

#[test]
fn normals() {
    replay("normals", 5000);
}

#[test]
fn obj() {
    replay("obj", 5000);
}

#[test]
fn pictures() {
    replay("pictures", 5000);
}

#[test]
fn ranks() {
    replay("ranks", 1500);
}

#[test]
fn ssvdag() {
    replay("ssvdag", 500);
}

#[test]
fn table() {
    replay("table", 2000);
}

#[test]
fn textures() {
    replay("textures", 3000);
}

#[test]
fn traversal() {
    replay("traversal", 500);
}

#[test]
fn tree() {
    replay("tree", 2000);
}

#[test]
fn triangulation() {
    replay("triangulation", 3000);
}
