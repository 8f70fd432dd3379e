//! Builds the scenes on the host and leaves their files where the program includes them from; and the memory layout where
//! the linker finds it.

use std::fs;
use std::path::PathBuf;

use voxdag_golden::{build, hashes::CASES};

fn main() {
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo names a folder"));
    let mut scenes = String::from("&[\n");
    for case in &CASES {
        let words = build::words(case.name).expect("every scene can be built here").expect("a scene is built");
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let path = out.join(case.name).with_extension("vxd");
        fs::write(&path, &bytes).expect("OUT_DIR can be written to");
        scenes += &format!("    &Aligned(*include_bytes!({path:?})),\n");
    }
    fs::write(out.join("scenes.rs"), scenes + "]\n").expect("OUT_DIR can be written to");
    fs::copy("memory.x", out.join("memory.x")).expect("OUT_DIR can be written to");
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rerun-if-changed=memory.x");
    println!("cargo::rerun-if-changed=build.rs");
}
