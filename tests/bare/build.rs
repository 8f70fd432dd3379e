//! Builds the scenes on the host and leaves their files where the program includes them from; and the memory layout where
//! the linker finds it.

use std::fs;
use std::path::PathBuf;

use voxdag_golden::{
    build,
    hashes::{CASES, PLAIN_SCENE},
};

fn main() {
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo names a folder"));
    // Writes a scene's file; what it is included by.
    let scene = |name: &str| {
        let words = build::words(name).expect("every scene can be built here").expect("a scene is built");
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let path = out.join(name).with_extension("vxd");
        fs::write(&path, &bytes).expect("OUT_DIR can be written to");
        format!("&Aligned(*include_bytes!({path:?}))")
    };
    fs::write(out.join("picture.rs"), scene(PLAIN_SCENE)).expect("OUT_DIR can be written to");
    let mut scenes = String::from("&[\n");
    for case in &CASES {
        scenes += &format!("    {},\n", scene(case.name));
    }
    fs::write(out.join("scenes.rs"), scenes + "]\n").expect("OUT_DIR can be written to");
    let memory = if std::env::var_os("CARGO_FEATURE_TIGHT").is_some() { "tight.x" } else { "roomy.x" };
    fs::copy(memory, out.join("memory.x")).expect("OUT_DIR can be written to");
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rerun-if-changed=roomy.x");
    println!("cargo::rerun-if-changed=tight.x");
    println!("cargo::rerun-if-changed=build.rs");
}
