//! Textures from files of every format to pixels; files that are missing or no pictures.

mod common;
use common::Sandbox;
use image::{ImageFormat, Rgb, RgbImage};

/// Pixels of the card along a side; it has 4 by 4 squares.
const SIDE: u32 = 64;
const SQUARE: &str = "\
mtllib card.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl card
f 1/1 2/2 3/3 4/4
";

/// The colour of a square of the card, by column and row from the top.
fn square(column: u32, row: u32) -> [u8; 3] {
    [40 + 60 * column as u8, 40 + 60 * row as u8, if (column + row).is_multiple_of(2) { 30 } else { 220 }]
}

/// A folder with the square, and its picture under a name.
fn sandbox(picture: &str, format: ImageFormat) -> Sandbox {
    let s = Sandbox::new();
    s.write("card.obj", SQUARE);
    s.write("card.mtl", format!("newmtl card\nKa 1 1 1\nKd 1 1 1\nmap_Kd {picture}\n"));
    let card = RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb(square(x / 16, y / 16)));
    card.save_with_format(s.path(picture), format).unwrap();
    s
}

/// The pixels of the square, drawn from in front of it in nothing but ambient light.
fn drawn(s: &Sandbox, scene: &str, flags: &str) -> RgbImage {
    let view = "--eye 0.5,0.5,4 --target 0.5,0.5,0 --fov 14.25 --ambient 1 --samples 1 --normals face --light 0,0,-9";
    s.ok(&format!("render {scene} -o picture.png --size {SIDE}x{SIDE} {view} {flags}"));
    image::open(s.path("picture.png")).unwrap().to_rgb8()
}

/// Asserts that the picture is the card, upright, up to so many steps of a byte in the middle of its squares.
fn assert_card(picture: &RgbImage, slack: u8, what: &str) {
    for row in 0..4 {
        for column in 0..4 {
            let found = picture.get_pixel(16 * column + 8, 16 * row + 8).0;
            let expected = square(column, row);
            let near = (0..3).all(|i| found[i].abs_diff(expected[i]) <= slack);
            assert!(near, "{what}: {found:?} in column {column}, row {row}: expected {expected:?}");
        }
    }
}

#[test]
fn every_format_is_read_and_the_scene_needs_it_no_more() {
    let formats = [
        ("card.png", ImageFormat::Png, 1),
        ("Card.BMP", ImageFormat::Bmp, 1),
        ("my card.tga", ImageFormat::Tga, 1),
        ("card.JPG", ImageFormat::Jpeg, 12),
    ];
    for (name, format, slack) in formats {
        let s = sandbox(name, format);
        assert_eq!(s.ok("build card.obj -o card.vxd -r 64").stderr.matches("warning").count(), 0, "{name}");
        std::fs::remove_file(s.path(name)).unwrap();
        std::fs::remove_file(s.path("card.mtl")).unwrap();
        assert_card(&drawn(&s, "card.vxd", ""), slack.max(8), name);
        let info = s.ok("info card.vxd").stdout;
        assert!(info.contains("(textured)") && info.contains("blocks"), "{info}");
    }
}

#[test]
fn raw_colors_are_the_pictures_own_and_none_are_none() {
    let s = sandbox("card.png", ImageFormat::Png);
    let raw = drawn(&s, "card.obj", "-r 64 --textures raw");
    assert_card(&raw, 0, "raw");
    assert_card(&drawn(&s, "card.obj", "-r 64 --textures raw --geometry ssvdag --materials ranked"), 0, "ssvdag");
    assert_card(&drawn(&s, "card.obj", "-r 64"), 8, "blocks");
    // At half as many voxels along a side, each pixel shows a voxel of the same square.
    assert_card(&drawn(&s, "card.obj", "-r 64 --textures raw --lod 1"), 0, "lod");

    // Without textures surfaces have their Kd, whatever leaves them away.
    for flags in ["--textures none", "--effects phong", "--effects=-textures"] {
        let plain = drawn(&s, "card.obj", &format!("-r 64 {flags}"));
        assert_eq!(plain.get_pixel(8, 8).0, [255; 3], "{flags}");
    }
    s.ok("build card.obj -o none.vxd -r 64 --textures none");
    s.write("card.mtl", "newmtl card\nKa 1 1 1\nKd 1 1 1\n");
    s.ok("build card.obj -o plain.vxd -r 64");
    assert_eq!(s.read("none.vxd"), s.read("plain.vxd"));

    let json = s.ok("render card.obj -r 64 -o a.png --json --size 16x16").stdout;
    assert!(!json.contains("\"textures\""), "{json}");
}

#[test]
fn what_is_no_picture_is_grey_with_one_warning() {
    // One bit a pixel, 2^31 - 1 pixels a side: no number of them may overflow.
    let wide = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\x7f\xff\xff\xff\x7f\xff\xff\xff\x01\0\0\0\0\x3c\xb2\x36\xcb";
    let cases: [(&str, Option<&[u8]>, &str); 5] = [
        ("wide.png", Some(wide), "it is larger than 16384 pixels a side"),
        ("lost.png", None, "texture \"lost.png\" is not there; what it would colour is drawn grey"),
        ("text.png", Some(b"no picture"), "it is no picture that is known: expected PNG, JPEG, BMP or TGA"),
        ("empty.png", Some(b""), "it is no picture that is known: expected PNG, JPEG, BMP or TGA"),
        ("cut.png", Some(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0"), "cannot be read: it is damaged"),
    ];
    for (name, content, expected) in cases {
        let s = Sandbox::new();
        s.write("two.obj", format!("{SQUARE}usemtl other\nf 1/1 3/3 4/4\n"));
        let material = |name: &str, picture: &str| format!("newmtl {name}\nKa 1\nKd 1\nmap_Kd {picture}\n");
        s.write("card.mtl", format!("{}{}", material("card", name), material("other", name)));
        if let Some(content) = content {
            s.write(name, content);
        }
        let run = s.ok("build two.obj -o two.vxd -r 16");
        assert!(run.stderr.contains(&format!("card.mtl:4: texture \"{name}\"")), "{}", run.stderr);
        assert!(run.stderr.contains(expected), "{}", run.stderr);
        assert_eq!(run.stderr.matches("warning").count(), 1, "{}", run.stderr);
        assert!(s.ok("info two.vxd").stdout.contains("colors           none"));
    }

    // Neither is a folder.
    let s = sandbox("card.png", ImageFormat::Png);
    std::fs::create_dir(s.path("folder.png")).unwrap();
    s.write("card.mtl", "newmtl card\nKa 1\nKd 1\nmap_Kd folder.png\n");
    let run = s.ok("build card.obj -o card.vxd -r 16");
    assert!(
        run.stderr.contains("card.mtl:4: texture \"folder.png\" cannot be read: it is not a regular file"),
        "{}",
        run.stderr
    );
    assert_eq!(run.stderr.matches("warning").count(), 1, "{}", run.stderr);

    // Without coordinates there is nothing to lay it by; a Kd of 0 would make it black.
    let s = sandbox("card.png", ImageFormat::Png);
    s.write("card.obj", SQUARE.replace("vt", "#").replace("1/1 2/2 3/3 4/4", "1 2 3 4"));
    let run = s.ok("build card.obj -o card.vxd -r 16");
    assert!(run.stderr.contains("the faces have no texture coordinates (vt)"), "{}", run.stderr);
    let s = sandbox("card.png", ImageFormat::Png);
    s.write("card.mtl", "newmtl card\nKa 1\nKd 0\nmap_Kd card.png\n");
    let run = s.ok("build card.obj -o card.vxd -r 16");
    assert!(run.stderr.contains("card.mtl:4: Kd 0 0 0 would make texture \"card.png\" black"), "{}", run.stderr);
}

/// A Ka that nobody gave is Kd, also where a texture changes that.
#[test]
fn ambient_light_falls_on_what_a_texture_leaves_of_kd() {
    let s = sandbox("card.png", ImageFormat::Png);
    s.write("card.mtl", "newmtl card\nKd 0\nmap_Kd card.png\n");
    assert_card(&drawn(&s, "card.obj", "-r 64"), 2, "Kd 0 without a Ka");
    s.write("card.mtl", "newmtl card\nKa 0\nKd 0\nmap_Kd card.png\n");
    assert!(drawn(&s, "card.obj", "-r 64").pixels().all(|pixel| pixel.0 == [0; 3]), "a Ka that was given stays");
    s.write("card.mtl", "newmtl card\n");
    let grey = drawn(&s, "card.obj", "-r 64");
    s.write("card.mtl", "newmtl card\nKd 1\nmap_Kd lost.png\n");
    assert!(drawn(&s, "card.obj", "-r 64") == grey, "what a lost picture would colour is grey");
}

/// Of faces that share a material some can have texture coordinates and some not.
#[test]
fn faces_without_coordinates_are_told_of() {
    let s = sandbox("card.png", ImageFormat::Png);
    s.write("card.obj", SQUARE.replace("f 1/1 2/2 3/3 4/4", "f 1/1 2/2 3/3\nf 1 3 4"));
    s.write("card.mtl", "newmtl card\nmap_Kd card.png\nmap_d card.png\n");
    let run = s.ok("build card.obj -o card.vxd -r 16");
    for line in [2, 3] {
        let expected = format!("card.mtl:{line}: texture \"card.png\" is not used on 1 of 2 triangles");
        assert!(run.stderr.contains(&expected), "{}", run.stderr);
    }
    // Faces of another material have some: that is no help.
    s.write("card.obj", format!("{}usemtl other\nf 2 3 4\n", SQUARE));
    s.write("card.mtl", "newmtl card\nmap_Kd card.png\nnewmtl other\nmap_Kd card.png\nmap_d card.png\n");
    let run = s.ok("build card.obj -o card.vxd -r 16");
    for line in [4, 5] {
        let expected =
            format!("card.mtl:{line}: texture \"card.png\" is not used: the faces have no texture coordinates");
        assert!(run.stderr.contains(&expected), "{}", run.stderr);
    }
    assert_eq!(run.stderr.matches("warning").count(), 2, "{}", run.stderr);
}

#[test]
fn pictures_are_found_where_exporters_leave_them_and_kept_within_the_limit() {
    let s = sandbox("card.png", ImageFormat::Png);
    std::fs::create_dir(s.path("sub")).unwrap();
    std::fs::copy(s.path("card.png"), s.path("sub/card.png")).unwrap();
    std::fs::rename(s.path("card.png"), s.path("other.png")).unwrap();
    for path in ["sub\\card.png", "C:\\Users\\me\\other.png", "\"/home/me/old scenes/other.png\""] {
        s.write("card.mtl", format!("newmtl card\nKa 1\nKd 1\nmap_Kd {path}\n"));
        assert_card(&drawn(&s, "card.obj", "-r 64 --textures raw"), 0, path);
    }
    // Relative to a library in a folder of its own.
    s.write("sub/card.mtl", "newmtl card\nKa 1\nKd 1\nmap_Kd card.png\n");
    s.write("card.obj", SQUARE.replace("mtllib card.mtl", "mtllib sub/card.mtl"));
    assert_card(&drawn(&s, "card.obj", "-r 64 --textures raw"), 0, "sub/card.mtl");

    let run = s.run("build card.obj -o card.vxd -r 16 --memory-limit 50k");
    assert!(run.code == 4 && run.stderr.contains("reading the textures of card.obj needs"), "{}", run.stderr);
    assert!(run.stderr.contains("--textures none"), "{}", run.stderr);
    s.ok("build card.obj -o card.vxd -r 16 --memory-limit 50k --textures none");

    // Ten materials that show one picture, of 21 KB when it is read and 90 KB before, take it once.
    s.write(
        "card.obj",
        format!("{SQUARE}{}", (0..10).map(|i| format!("usemtl m{i}\nf 1/1 2/2 3/3\n")).collect::<String>()),
    );
    s.write("card.png", s.read("other.png"));
    let materials = (0..10).map(|i| format!("newmtl m{i}\nKd 1\nmap_Kd card.png\n")).collect::<String>();
    s.write("card.mtl", format!("newmtl card\nKd 1\nmap_Kd card.png\n{materials}"));
    s.ok("build card.obj -o card.vxd -r 16 --memory-limit 160k");
}

#[test]
fn what_stands_beside_the_pixels_takes_little_memory() {
    // A profile of 256 MiB that is packed into less than one.
    use image::ImageEncoder;
    let s = sandbox("card.png", ImageFormat::Png);
    let mut encoder = image::codecs::png::PngEncoder::new(std::fs::File::create(s.path("card.png")).unwrap());
    encoder.set_icc_profile(vec![0; 256 << 20]).unwrap();
    encoder.write_image(&[255; 12], 2, 2, image::ExtendedColorType::Rgb8).unwrap();
    assert!(s.read("card.png").len() < 1 << 20);
    let run = s.ok("build card.obj -o card.vxd -r 16 --json");
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(report["peak_rss_bytes"].as_u64().is_none_or(|bytes| bytes < 128 << 20), "{}", run.stdout);
}

#[test]
fn a_texture_that_no_voxel_shows_leaves_a_scene_without_colors() {
    // Behind another material in the same place, and cut out altogether.
    let s = sandbox("card.png", ImageFormat::Png);
    s.write("card.obj", format!("{SQUARE}usemtl before\nf 1/1 2/2 3/3 4/4\n"));
    let library = "newmtl before\nKd 1 0 0\nnewmtl card\nKd 1 1 1\nmap_Kd card.png\n";
    let cut = format!("{library}map_d dark.png\n");
    RgbImage::new(4, 4).save(s.path("dark.png")).unwrap();
    for library in [library, &cut] {
        s.write("card.mtl", library);
        for materials in ["tree", "ranked"] {
            let run = s.ok(&format!("build card.obj -o card.vxd -r 16 --materials {materials}"));
            assert!(!run.stderr.contains("warning"), "{}", run.stderr);
            let info = s.ok("info card.vxd").stdout;
            assert!(!info.contains("(textured)"), "{info}");
        }
        // Nor is a texture asked for while it is drawn from the mesh.
        let json = s.ok("render card.obj -r 16 -o a.png --json --size 16x16").stdout;
        assert!(!json.contains("\"textures\""), "{json}");
    }
    // Where nothing else is there, that is said.
    s.write("card.obj", SQUARE);
    let run = s.ok("build card.obj -o card.vxd -r 16");
    assert!(run.stderr.contains("warning: card.obj: no voxel is filled: map_d cuts everything out"), "{}", run.stderr);
}

#[test]
fn a_name_means_the_picture_beside_its_library() {
    let s = Sandbox::new();
    let corners = SQUARE.lines().filter(|line| line.starts_with('v')).collect::<Vec<_>>().join("\n");
    let faces = "usemtl left\nf 1/1 2/2 3/3\nusemtl right\nf 1/1 3/3 4/4\n";
    s.write("two.obj", format!("mtllib left/card.mtl right/card.mtl\n{corners}\n{faces}"));
    for (folder, color) in [("left", [255, 0, 0]), ("right", [0, 0, 255])] {
        std::fs::create_dir(s.path(folder)).unwrap();
        s.write(&format!("{folder}/card.mtl"), format!("newmtl {folder}\nKa 1\nKd 1\nmap_Kd card.png\n"));
        RgbImage::from_pixel(2, 2, Rgb(color)).save(s.path(format!("{folder}/card.png"))).unwrap();
    }
    let picture = drawn(&s, "two.obj", "-r 64 --textures raw");
    assert_eq!(picture.get_pixel(48, 40).0, [255, 0, 0]);
    assert_eq!(picture.get_pixel(16, 24).0, [0, 0, 255]);
}

#[test]
fn verify_tells_of_colors() {
    let s = sandbox("card.png", ImageFormat::Png);
    s.ok("build card.obj -o card.vxd -r 16");
    let found = s.ok("verify card.vxd").stdout;
    assert!(found.contains("colors     256 in blocks"), "{found}");
}

/// A picture that the mesh names is an input, whether this run reads it or not.
#[test]
fn pictures_are_never_overwritten() {
    let s = sandbox("card.png", ImageFormat::Png);
    let before = s.read("card.png");
    let refused = |flags: &str| {
        s.run(&format!("render card.obj -r 16 --size 8x8 -o card.png {flags}"))
            .fails(2, &["card.png", "never overwritten"]);
        assert_eq!(s.read("card.png"), before, "{flags}");
    };
    refused("");
    refused("--textures none");
    refused("--materials none");
    s.write("card.obj", SQUARE.replace("vt", "#").replace("1/1 2/2 3/3 4/4", "1 2 3 4"));
    refused("");
    s.write("card.mtl", "newmtl card\nnewmtl other\nmap_d card.png\n");
    refused("");
}

/// What stands where the library says and cannot be read is no reason not to look beside it.
#[test]
fn a_picture_is_looked_for_past_what_cannot_be_read() {
    let s = sandbox("card.png", ImageFormat::Png);
    std::fs::create_dir_all(s.path("tex/card.png")).unwrap();
    s.write("card.mtl", "newmtl card\nmap_Kd tex/card.png\n");
    assert_card(&drawn(&s, "card.obj", "-r 64"), 2, "a folder of that name");
    std::fs::remove_file(s.path("card.png")).unwrap();
    let run = s.ok("build card.obj -o card.vxd -r 16");
    let expected = "card.mtl:2: texture \"tex/card.png\" cannot be read: it is not a regular file";
    assert!(run.stderr.contains(expected), "{}", run.stderr);
}

/// A file that is larger than the limit is not read, and not called damaged.
#[test]
fn files_over_the_memory_limit_are_refused_by_their_length() {
    let s = sandbox("card.png", ImageFormat::Png);
    let png = s.read("card.png");
    s.write("card.png", [&png[..], &vec![0; 3 << 20]].concat());
    let run = s.run("build card.obj -o card.vxd -r 16 --memory-limit 1M");
    run.fails(4, &["card.png needs", "(3.00 MiB)"]);
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    s.write("card.mtl", vec![b' '; 3 << 20]);
    let run = s.run("build card.obj -o card.vxd -r 16 --memory-limit 1M");
    run.fails(4, &["card.mtl needs", "(3.00 MiB)"]);
}
