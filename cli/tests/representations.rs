//! Layouts of voxels and representations of materials: whatever is chosen, the picture is the same, byte for byte.

mod common;
use common::Sandbox;

const LAYOUTS: [&str; 5] = ["dag", "ssvdag", "svo", "offsets", "moxel"];
const MATERIALS: [&str; 7] = ["tree", "table", "table-normals", "ranked", "palette", "moxel", "moxel-normals"];
const VIEW: &str = "--size 64x48";

#[test]
fn every_combination_draws_the_same_picture() {
    let s = Sandbox::new();
    s.ok(&format!("render box.obj -r 40 {VIEW} -o expected.png"));
    for layout in LAYOUTS {
        for materials in MATERIALS {
            s.ok(&format!("render box.obj -r 40 {VIEW} --geometry {layout} --materials {materials} -o found.png"));
            assert_eq!(s.read("found.png"), s.read("expected.png"), "{layout}, {materials}");
        }
    }
}

#[test]
fn stored_normals_are_the_same_wherever_they_are_stored() {
    let s = Sandbox::new();
    let stored = format!("render box.obj -r 40 {VIEW} --normals stored -o");
    s.ok(&format!("{stored} expected.png --materials table-normals"));
    for layout in LAYOUTS {
        s.ok(&format!("{stored} found.png --geometry {layout} --materials moxel-normals"));
        assert_eq!(s.read("found.png"), s.read("expected.png"), "{layout}");
    }
    s.run(&format!("{stored} found.png --materials moxel")).fails(2, &["no stored normals"]);
}

#[test]
fn files_hold_what_files_hold_and_no_more() {
    let s = Sandbox::new();
    s.ok(&format!("render box.obj -r 40 {VIEW} -o expected.png"));
    let voxels = s.ok("build box.obj -r 40 -o box.vxd --json").json()["voxels"].clone();
    for layout in ["dag", "ssvdag"] {
        for materials in ["tree", "table", "table-normals", "ranked", "none"] {
            let flags = format!("--geometry {layout} --materials {materials}");
            let built = s.ok(&format!("build box.obj -r 40 {flags} -o box.vxd --json")).json();
            assert_eq!(built["voxels"], voxels, "{flags}");
            assert_eq!(built["bytes"]["file"], s.read("box.vxd").len(), "{flags}");
            s.ok("verify box.vxd");
            assert_eq!(s.ok("info box.vxd --json").json()["voxels"], voxels, "{flags}");
            s.ok(&format!("render box.vxd {VIEW} -o found.png"));
            if materials != "none" {
                assert_eq!(s.read("found.png"), s.read("expected.png"), "{flags}");
            }
            s.ok("bench materials box.vxd --repeat 1 --size 16x16");
            s.ok("bench trace box.vxd --repeat 1 --size 16x16");
        }
    }
    for (flag, value) in [("geometry", "svo"), ("geometry", "offsets"), ("geometry", "moxel"), ("materials", "palette")]
    {
        s.run(&format!("build box.obj -o new.vxd --{flag} {value}"))
            .fails(2, &[&format!("--{flag}"), "in memory only"]);
    }
    assert!(!s.files().contains(&"new.vxd".to_owned()));
}
