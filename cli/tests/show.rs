//! `render --show` and `--depth-out` on a scene whose pixels are known.

mod common;
use common::{GRID, Sandbox};

const SHOWS: [&str; 6] = ["shaded", "normals", "depth", "level", "iterations", "material"];
/// Looks along -z; 9 x 9 pixels of 0.218 at the upper voxel's front, 8 away, and of 0.246 at the lower one's, 9 away.
const VIEW: &str = "--size 9x9 --eye 10.75,21,40 --target 10.75,21,32 --fov 14";

/// The front of the upper voxel (material 1) is at z = 32 from y = 21 on, of the lower one (material 2) at 31 from 20 on.
fn two_voxels() -> Sandbox {
    let s = Sandbox::new();
    s.scene("two.vxd", GRID, &[([1, 2, 3], 1), ([1, 0, 1], 2)]);
    s
}

fn pixels(s: &Sandbox, name: &str) -> Vec<[u8; 4]> {
    let picture = image::load_from_memory(&s.read(name)).unwrap().into_rgba8();
    assert_eq!(picture.dimensions(), (9, 9));
    picture.pixels().map(|p| p.0).collect()
}

/// The pixels in the middle column that show the two voxels, and a corner.
fn known(pixels: &[[u8; 4]]) -> [[u8; 4]; 3] {
    [pixels[3 * 9 + 4], pixels[7 * 9 + 4], pixels[0]]
}

#[test]
fn pixels_show_what_is_there() {
    let s = two_voxels();
    let show = |what: &str| {
        s.ok(&format!("render two.vxd -o out.png {VIEW} --normals face --show {what}"));
        known(&pixels(&s, "out.png"))
    };
    const BLACK: [u8; 4] = [0, 0, 0, 255];
    assert_eq!(show("normals"), [[128, 128, 255, 255], [128, 128, 255, 255], BLACK]);
    assert_eq!(show("material"), [[0, 128, 0, 255], [128, 128, 0, 255], BLACK]);
    let [near, far, nothing] = show("depth");
    assert!(near[0] > 240 && (38..80).contains(&far[0]) && nothing == BLACK, "{near:?} {far:?}");
    // The upper voxel is entered from outside, the lower one from a voxel beside others in an empty block of 2^3.
    let [upper, lower, nothing] = show("level");
    assert!(upper == [255; 4] && lower != upper && lower != BLACK && nothing == BLACK, "{upper:?} {lower:?}");
}

#[test]
fn pictures_differ_and_do_not_depend_on_threads() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 50");
    let pictures = SHOWS.map(|what| {
        s.ok(&format!("render box.vxd -o a.png --size 64x48 --show {what} --threads 1"));
        s.ok(&format!("render box.obj -r 50 -o b.png --size 64x48 --show {what} --threads 3"));
        assert!(s.read("a.png") == s.read("b.png"), "{what}");
        s.read("a.png")
    });
    for (i, picture) in pictures.iter().enumerate() {
        assert!(!pictures[..i].contains(picture), "{}", SHOWS[i]);
    }
    s.ok("render box.vxd -o plain.png --size 64x48");
    assert!(s.read("plain.png") == pictures[0]);
}

#[test]
fn the_numbers_behind_the_colours_are_reported() {
    let s = two_voxels();
    for what in ["depth", "level", "iterations"] {
        let run = s.ok(&format!("render two.vxd -o out.png {VIEW} --show {what} --json"));
        let shown = &run.json()["shown"];
        let [min, mean, max] = ["min", "mean", "max"].map(|key| shown[key].as_f64().unwrap());
        assert!(min <= mean && mean <= max, "{what} {shown}");
        if what == "depth" {
            assert!((8.0..8.05).contains(&min) && (9.0..9.2).contains(&max), "{shown}");
        }
        let text = s.ok(&format!("render two.vxd -o out.png {VIEW} --show {what}")).stdout;
        assert!(text.lines().any(|line| line.starts_with(what) && line.contains("mean")), "{text}");
    }
    assert!(s.ok(&format!("render two.vxd -o out.png {VIEW} --show normals --json")).json()["shown"].is_null());
    s.run("render two.vxd -o out.png --show depth --samples 4").fails(2, &["--samples"]);
}

#[test]
fn depths_are_distances_bottom_row_first() {
    let s = two_voxels();
    s.ok(&format!("render two.vxd -o out.png --depth-out out.pfm {VIEW}"));
    let file = s.read("out.pfm");
    let data = file.strip_prefix(b"Pf\n9 9\n-1.0\n").expect("a greyscale PFM, little-endian");
    assert_eq!(data.len(), 4 * 81);
    let depth = |column: usize, row_from_top: usize| {
        let at = 4 * ((8 - row_from_top) * 9 + column);
        f32::from_le_bytes(data[at..][..4].try_into().unwrap())
    };
    const TAN_7_DEGREES: f64 = 0.122_784_560_902_904_6;
    // From the eye to the plane z = 32 or 31, along a ray that is `y` off the axis there.
    let expected = |distance: f64, row: usize| {
        let slope = (4.0 - row as f64) / 4.5 * TAN_7_DEGREES;
        distance * (1.0 + slope * slope).sqrt()
    };
    assert!((f64::from(depth(4, 3)) - expected(8.0, 3)).abs() < 1e-5, "{}", depth(4, 3));
    assert!((f64::from(depth(4, 7)) - expected(9.0, 7)).abs() < 1e-5, "{}", depth(4, 7));
    assert!((0..9).all(|column| depth(column, 0) == f32::INFINITY));
    // The picture is the same without it.
    let with = s.read("out.png");
    s.ok(&format!("render two.vxd -o out.png {VIEW}"));
    assert!(s.read("out.png") == with);
    s.run("render two.vxd -o out.png --depth-out out.txt").fails(2, &["out.txt", ".pfm"]);
}

/// What `--lod` draws is the scene that the coarser voxels make, each with the material of its first one.
#[test]
fn levels_of_detail_are_scenes_of_larger_voxels() {
    let s = Sandbox::new();
    s.scene("fine.vxd", GRID, &[([1, 2, 3], 1), ([0, 3, 3], 2), ([1, 0, 1], 2), ([3, 3, 0], 0)]);
    let coarse = voxdag::Grid { voxel_size: 1.0, resolution: 2, ..GRID };
    s.scene("coarse.vxd", coarse, &[([0, 1, 1], 1), ([0, 0, 0], 2), ([1, 1, 0], 0)]);
    let flags = "--size 40x30 --supersample near --samples 4 --shadows";
    let fine = s.ok(&format!("render fine.vxd -o fine.png {flags}"));
    assert!(fine.stdout.contains("4 voxels along the longest axis\n"));
    let drawn = s.ok(&format!("render fine.vxd -o lod.png {flags} --lod 1 --json")).json();
    assert_eq!([&drawn["resolution"], &drawn["lod"]], [4, 1]);
    s.ok(&format!("render coarse.vxd -o coarse.png {flags}"));
    assert!(s.read("lod.png") == s.read("coarse.png") && s.read("lod.png") != s.read("fine.png"));
    for what in ["normals", "depth", "level", "material"] {
        s.ok(&format!("render fine.vxd -o lod.png --size 40x30 --lod 1 --show {what} --depth-out lod.pfm"));
        s.ok(&format!("render coarse.vxd -o coarse.png --size 40x30 --show {what} --depth-out coarse.pfm"));
        assert!(s.read("lod.png") == s.read("coarse.png"), "{what}");
        assert!(s.read("lod.pfm") == s.read("coarse.pfm"), "{what}");
    }
    let text = s.ok("render fine.vxd -o lod.png --size 40x30 --lod 2").stdout;
    assert!(text.contains("4 voxels along the longest axis, drawn as 1"), "{text}");
    for too_much in [3, 20] {
        let refused = s.run(&format!("render fine.vxd -o lod.png --lod {too_much}"));
        assert!(refused.code == 2 && refused.stderr.contains("take 0 to 2"), "{}", refused.stderr);
    }
}
