//! The dialects of OBJ and MTL that real files have, what is refused and with which line, that nothing panics, and the
//! table of the loader suite (where `../shared` is there).

use std::path::{Path, PathBuf};

use voxdag::Material;
use voxdag::obj::{ImportError, Model, import};
use voxdag::texture::Placement;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn read_with(obj: &[u8], files: &[(&str, &str)]) -> Result<Model, ImportError> {
    import(obj, |path| files.iter().find(|(name, _)| *name == path).map(|(_, text)| text.as_bytes().to_vec()))
}

fn read(obj: &str) -> Model {
    read_with(obj.as_bytes(), &[]).unwrap_or_else(|e| panic!("{e}\n{obj}"))
}

/// The material `m` of a library, with its warnings.
fn material(mtl: &str) -> (voxdag::mtl::NamedMaterial, Vec<String>) {
    let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let model = read_with(obj.as_bytes(), &[("a.mtl", &format!("newmtl m\n{mtl}\n"))]).unwrap();
    (model.materials[0].clone(), model.warnings.iter().map(|w| w.to_string()).collect())
}

/// The positions of every triangle's corners.
fn places(model: &Model) -> Vec<[[f64; 3]; 3]> {
    model.triangles.iter().map(|t| t.map(|i| model.positions[i as usize])).collect()
}

const LAID_OUT: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn every_dialect_of_a_triangle_is_the_same_triangle() {
    let plain = format!("{TRIANGLE}f 1 2 3\n");
    let marked = format!("\u{feff}{plain}");
    let utf16 = |order: fn(u16) -> [u8; 2]| marked.encode_utf16().flat_map(order).collect::<Vec<u8>>();
    let latin = [b"# caf\xe9 \x80\n".as_slice(), plain.as_bytes()].concat();
    let files: Vec<(&str, Vec<u8>)> = vec![
        ("plain", plain.clone().into()),
        ("no newline at the end", plain.trim_end().into()),
        ("CR LF", plain.replace('\n', "\r\n").into()),
        ("lone CR", plain.replace('\n', "\r").into()),
        ("byte order mark", marked.clone().into()),
        ("UTF-16 LE", utf16(u16::to_le_bytes)),
        ("UTF-16 BE", utf16(u16::to_be_bytes)),
        ("Latin-1", latin),
        ("tabs and spaces", plain.replace(' ', " \t ").replace('\n', " \t\n \t").into()),
        ("continued lines", plain.replace("f 1 2", "f 1 \\\n 2 \\\r\n").into()),
        ("comments", plain.replace('\n', " # as 1/2/3\n#\\\n").into()),
        ("negative indices", format!("{TRIANGLE}f -3 -2 -1").into()),
        ("mixed indices", format!("{TRIANGLE}f 1 -2 3").into()),
        ("vertices after the face", format!("f 1 2 3\n{TRIANGLE}").into()),
        ("relative to the line", format!("{TRIANGLE}f -3 -2 -1\nv 9 9 9").into()),
        ("weights", plain.replace(" 0\n", " 0 1.0\n").into()),
        ("colours", plain.replace(" 0\n", " 0 1 0.5 0\n").into()),
        ("weights and colours", plain.replace(" 0\n", " 0 1 1 0.5 0\n").into()),
        ("signs, dots, exponents", "v +0 .0 0.\nv 1e0 -0 0E+00\nv 0 100e-002 -.0e7\nf +1 2 3".into()),
        ("objects and groups", format!("o\no a b\n{TRIANGLE}g\ng x y\ns off\ns 1\nf 1 2 3").into()),
        ("lines and points", format!("{TRIANGLE}l 1 2\np 1 2 3\nf 1 2 3\nl 7 8 9").into()),
        ("curves", format!("{TRIANGLE}vp 1\ncstype bezier\ndeg 3\ncurv 0 1 \\\n1 2\nparm u 0 1\nend\nf 1 2 3").into()),
        ("the old keyword", format!("{TRIANGLE}fo 1 2 3").into()),
        ("trailing slashes", format!("{TRIANGLE}f 1/ 2// 3").into()),
        ("stripped normals", format!("{TRIANGLE}f 1/1/1 2/7/-1 3//2").into()),
        ("missing library", format!("mtllib gone.mtl\n{plain}").into()),
        ("empty statements", format!("usemtl\nmtllib\n\n\\\n{plain}\\").into()),
    ];
    for (name, bytes) in files {
        let model = read_with(&bytes, &[]).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(places(&model), [LAID_OUT], "{name}");
        assert_eq!((model.faces, model.uvs.len(), model.normals.len()), (1, 0, 0), "{name}");
        assert_eq!(model.materials[usize::from(model.triangle_materials[0])].material, Material::GREY, "{name}");
        model.mesh().validate().unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn corners_keep_their_own_coordinates_and_normals() {
    let head = format!("{TRIANGLE}vt 0.5\nvt 1 2 3\nvt 5 6\nvn 0 0 1\nvn 0 1 0\n");
    let model = read(&format!("{head}f 1/1/1 2/2/2 3/3/1\nf 1/2 2//2 3\nf 1/-1/-2 2 3\n"));
    let nan = f32::NAN;
    let uvs = [
        [[0.5, 0.0], [1.0, 2.0], [5.0, 6.0]],
        [[1.0, 2.0], [nan, nan], [nan, nan]],
        [[5.0, 6.0], [nan, nan], [nan, nan]],
    ];
    assert_eq!(format!("{:?}", model.uvs), format!("{uvs:?}"));
    let (z, y, none) = ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [nan; 3]);
    assert_eq!(format!("{:?}", model.normals), format!("{:?}", [[z, y, z], [none, y, none], [z, none, none]]));

    // A polygon's attributes follow its corners through the cutting, whichever comes first.
    for start in 0..4 {
        let mut corners = ["1/1", "2/2", "4/3", "3/4"];
        corners.rotate_left(start);
        let obj = format!("{TRIANGLE}v 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf {}", corners.join(" "));
        let model = read(&obj);
        assert_eq!(model.triangles.len(), 2);
        for (places, uvs) in places(&model).iter().zip(&model.uvs) {
            assert_eq!(places.map(|p| [p[0] as f32, p[1] as f32]), *uvs);
        }
    }
}

#[test]
fn wrong_geometry_is_refused_with_its_line() {
    // Each after three vertices, on line 4; the message must hold the words.
    let cases = [
        ("f 1 2", "2 corners"),
        ("f", "0 corners"),
        ("f 1 2 4", "v index 4 is out of range: the file has 3"),
        ("f 0 1 2", "count from 1"),
        ("f 1 2 -4", "v index -4 is out of range"),
        ("f -1 -2 -9223372036854775808", "out of range"),
        ("f 1 2 9223372036854775807", "out of range"),
        ("f 1 2 99999999999999999999", "not a corner"),
        ("f 1 2 x", "\"x\" is not a corner"),
        ("f 1 2 3.0", "not a corner"),
        ("f 1 2 /3", "not a corner"),
        ("f 1 2 3/1/1/1", "not a corner"),
        ("f 1//x 2 3", "not a corner"),
        ("vt 0 0\nf 1/2 2/1 3/1", "vt index 2 is out of range"),
        ("vt 0 0\nf 1/-2 2/1 3/1", "vt index -2"),
        ("vn 0 0 1\nf 1//0 2 3", "vn index 0"),
        ("v 1 2", "v has 2 numbers: expected 3 to 7"),
        ("v", "v has 0 numbers"),
        ("v 1 2 3 4 5 6 7 8", "at most 7"),
        ("v 1 2 nan", "\"nan\" is not a finite number"),
        ("v 1 -inf 3", "\"-inf\""),
        ("v 1 1e999 3", "\"1e999\""),
        ("v 1,5 2,5 3,5", "\"1,5\""),
        ("v 1 2 3 red", "\"red\""),
        ("v 1.#IND 0 0", "\"1.#IND\""),
        ("vt", "vt has 0 numbers"),
        ("vt inf 0", "\"inf\""),
        ("vt 0 0 0 0", "at most 3"),
        ("vn 0 1", "vn has 2 numbers: expected 3"),
        ("vn 0 0 1e300", "single precision"),
    ];
    for (text, words) in cases {
        let obj = format!("{TRIANGLE}{text}\nf 1 2 3\n");
        let error = read_with(obj.as_bytes(), &[]).expect_err(text).0;
        let line = if text.contains('\n') { 5 } else { 4 };
        assert_eq!((error.file.as_str(), error.line), ("", line), "{text}: {error}");
        assert!(error.message.contains(words), "{text}: {error}");
        assert!(error.to_string().starts_with(&format!("{line}: ")), "{error}");
    }
    // Joined lines count as they stand in the file.
    let error = read_with(b"v 0 0 \\\n\\\r\n 0\r# \\\n\nf 1 1 \\\n 2\n", &[]).unwrap_err();
    assert_eq!(error.0.line, 6, "{error}");
}

#[test]
fn numbers_of_a_material_mean_light() {
    let grey = |x: f32| [x; 3];
    let near = |found: [f32; 3], expected: [f32; 3]| {
        (0..3).all(|i| (found[i] - expected[i]).abs() <= 1e-4 * expected[i].max(1.0))
    };
    // The sRGB curve by table: 0.5 -> 0.21404, 0.25 -> 0.05088, 0.02 -> 0.02 / 12.92, 2 -> 4.95387.
    let (m, warnings) = material("Kd 0.5\nKs 0.25 0 1 # shiny\nKe 2 0.02 0\nTf 0.5 0.5 0.5\nNs 12.6\nd 0.25\nNi 1.5\n");
    assert!(near(m.material.diffuse, grey(0.21404)) && m.material.ambient == m.material.diffuse);
    assert!(near(m.material.specular, [0.05088, 0.0, 1.0]) && near(m.material.emission, [4.95387, 0.001548, 0.0]));
    assert!(near(m.material.transmission, grey(0.21404)));
    let rest = (m.material.shininess, m.material.opacity, m.material.refraction, m.material.illum);
    assert_eq!((rest, warnings), ((13, 0.25, 1.5, 2), vec![]));

    // Keywords in any case, white space anywhere, what others add skipped in silence.
    let text =
        "\t kA 0\n KD\t1 1 1\n ILLUM 3\n -- \nNS 0\nTR 0.25\nPr 0.5\nmap_Pr r.png\naniso 0\nmap_bump -bm 2 b.png\n";
    let (m, warnings) = material(&text.replace(" -- \n", ""));
    assert_eq!((m.material.ambient, m.material.diffuse, m.material.illum), (grey(0.0), grey(1.0), 3));
    assert_eq!((m.material.shininess, m.material.opacity, warnings.len()), (1, 0.75, 0));

    let (m, _) = material("");
    assert_eq!(m.material, Material::GREY);
    assert_eq!(material("d -halo 0.5").0.material.opacity, 0.5);
    assert_eq!(material("d 7").0.material.opacity, 1.0);
    assert_eq!(material("Ns 1e30").0.material.shininess, voxdag::material::MAX_SHININESS);
}

#[test]
fn what_a_library_has_wrong_is_a_warning_with_its_line() {
    let cases = [
        ("Kd red", "Kd \"red\""),
        ("Kd 0.5 0.5", "Kd \"0.5 0.5\""),
        ("Kd", "Kd"),
        ("Kd -1 0 0", "0 or more"),
        ("Kd nan 0 0", "0 or more"),
        ("Kd 1e30", "0 or more"),
        ("Ka spectral a.rfl 1", "spectral"),
        ("Kd xyz 1 1 1", "xyz"),
        ("Ns -5", "Ns"),
        ("Ni inf", "Ni"),
        ("d", "d"),
        ("illum 11", "illum"),
        ("illum 1.5", "illum"),
        ("sparkle 3\nsparkle 4", "\"sparkle\""),
        ("map_Kd", "names no file"),
        ("map_Kd -s 1 1 1", "names no file"),
    ];
    for (text, words) in cases {
        let (m, warnings) = material(text);
        assert_eq!((m.material, warnings.len()), (Material::GREY, 1), "{text}: {warnings:?}");
        assert!(warnings[0].starts_with("a.mtl:2: ") && warnings[0].contains(words), "{text}: {warnings:?}");
    }
    let (m, warnings) = material("d 0.75\nTr 0.5");
    assert_eq!(m.material.opacity, 0.75);
    assert!(warnings.len() == 1 && warnings[0].starts_with("a.mtl:3: d 0.75 and Tr 0.5 disagree"), "{warnings:?}");
    assert!(material("d 0.9\nTr 0.1").1.is_empty());
}

#[test]
fn textures_keep_their_options_and_their_names() {
    let plain = |text: &str| {
        let (m, warnings) = material(&format!("map_Kd {text}"));
        (m.map_kd.unwrap_or_else(|| panic!("{text}: {warnings:?}")), warnings)
    };
    let (map, _) = plain("-s 10 20 30 -o 0.5 -clamp on -mm 0.25 2 -blendu off -boost 1.5 leather brown.png");
    assert_eq!(
        (map.path.as_str(), map.placement.scale, map.placement.offset),
        ("leather brown.png", [10.0, 20.0, 30.0], [0.5, 0.0, 0.0])
    );
    assert_eq!((map.placement.clamp, map.placement.base, map.placement.gain), (true, 0.25, 2.0));
    for (text, path) in [
        ("wood.png", "wood.png"),
        ("textures\\old wood.png", "textures/old wood.png"),
        ("  \"C:\\My Textures\\a.png\" ", "C:/My Textures/a.png"),
        ("-S 1 1 1 wood.png", "wood.png"),
        ("-texres 512 -imfchan r -type sphere -cc on -colorspace sRGB wood.png", "wood.png"),
        ("-t 1 2 wood - dark.png", "wood - dark.png"),
        ("-s 2 2 2 7", "7"),
        ("-wood.png", "-wood.png"),
        ("wood.png -clamp on -s 2", "wood.png"),
        ("#1 wood.png", "#1 wood.png"),
    ] {
        let (map, warnings) = plain(text);
        assert_eq!((map.path.as_str(), warnings.len()), (path, 0), "{text}: {warnings:?}");
    }
    let (map, _) = plain("wood.png -clamp on -s 2");
    assert_eq!((map.placement.clamp, map.placement.scale), (true, [2.0, 1.0, 1.0]));
    let (map, warnings) = plain("-q 3 on wood.png");
    assert_eq!(map.path, "wood.png");
    assert_eq!(warnings, ["a.mtl:2: option \"-q\" of map_Kd is not known; texture \"wood.png\" is used without it"]);
    assert_eq!(plain("-clamp maybe.png").1.len(), 1);
    assert_eq!(plain("-o wood.png").0.path, "wood.png");
    // The picture alone, where no colour is said.
    let diffuse = |mtl: &str| material(mtl).0.material.diffuse;
    assert_eq!((diffuse("map_Kd wood.png"), diffuse("map_Kd a\nKd 0.0")), ([1.0; 3], [0.0; 3]));
    assert_eq!(diffuse("map_d wood.png"), Material::GREY.diffuse);
    // Numbers that cannot be used are numbers all the same, and no part of the name.
    for (text, numbers) in
        [("-o 1e300 2 wood.png", "1e300 2"), ("-s nan wood.png", "nan"), ("wood.png -mm 0 -inf", "0 -inf")]
    {
        let (map, warnings) = plain(text);
        assert_eq!((map.path.as_str(), map.placement), ("wood.png", Placement::default()), "{text}");
        let option = text.split(' ').find(|word| word.starts_with('-')).unwrap();
        let expected =
            format!("a.mtl:2: map_Kd: option {option} {numbers:?} is not finite in single precision; it is skipped");
        assert_eq!(warnings, [expected]);
    }
}

#[test]
fn ids_follow_the_libraries_and_never_the_faces() {
    let files = [
        ("b one.mtl", "newmtl zinc\nKd 1\nnewmtl brass\nKd 0.5\nnewmtl unused\n"),
        ("sub/two.mtl", "newmtl brass\nKd 0\nnewmtl a b\n"),
    ];
    let faces = [
        "f 1 2 3",
        "usemtl brass\nf 1 2 3",
        "usemtl  a b \nf 1 2 3",
        "usemtl gone\nf 1 2 3\nf 1 2 3",
        "usemtl Ash\nf 1 2 3",
    ];
    let head = format!("mtllib b\\ one.mtl sub\\two.mtl lost.mtl # both\nmtllib sub/two.mtl\nusemtl never\n{TRIANGLE}");
    let mut orders = vec![faces.to_vec()];
    // The faces without a material can only come first.
    orders.push([faces[0], faces[4], faces[3], faces[2], faces[1]].to_vec());
    for order in orders {
        // A library may also be named last.
        for late in [false, true] {
            let body = order.join("\n").replace("f 1 2 3\nusemtl", "f 1 2 3\no part\nusemtl");
            let obj = if late {
                format!("{TRIANGLE}{body}\n{}", head.replace(TRIANGLE, ""))
            } else {
                format!("{}{body}\n", head.replace("usemtl never\n", ""))
            };
            let model = read_with(obj.as_bytes(), &files).unwrap();
            let names: Vec<_> = model.materials.iter().map(|m| m.name.as_str()).collect();
            assert_eq!(names, ["zinc", "brass", "unused", "a b", "Ash", "gone", "default"]);
            assert_eq!(model.name_order, [6, 2, 5, 1, 0, 4, 3]);
            let used: Vec<_> = model.triangle_materials.iter().map(|&id| names[usize::from(id)]).collect();
            let expected: Vec<_> = order
                .iter()
                .flat_map(|f| match *f {
                    "f 1 2 3" => vec!["default"],
                    f if f.contains("brass") => vec!["brass"],
                    f if f.contains("a b") => vec!["a b"],
                    f if f.contains("gone") => vec!["gone"; 2],
                    _ => vec!["Ash"],
                })
                .collect();
            assert_eq!(used, expected);
            assert!(model.materials[1].material.diffuse[0] > 0.2, "the first definition counts");
            let warnings: Vec<_> = model.warnings.iter().map(|w| w.to_string()).collect();
            let about = |word: &str| warnings.iter().filter(|w| w.contains(word)).count();
            let counts =
                ["\"lost.mtl\"", "\"gone\"", "\"Ash\"", "without a material", "sub/two.mtl:1: ", "never"].map(about);
            assert_eq!(counts, [1, 1, 1, 1, 1, 0], "{warnings:?}");
            assert_eq!(warnings.len(), 5, "{warnings:?}");
        }
    }
}

#[test]
fn names_match_across_encodings() {
    let obj = [format!("mtllib a.mtl\n{TRIANGLE}usemtl gr").as_bytes(), b"\xfcn\nf 1 2 3"].concat();
    let model = read_with(&obj, &[("a.mtl", "newmtl grün\nKd 1\n")]).unwrap();
    assert_eq!((model.materials.len(), model.warnings.len()), (1, 0));
    // A `#` belongs to a name; a library may have spaces in its own.
    let obj = format!("mtllib my scene.mtl\n{TRIANGLE}usemtl Material #25\nf 1 2 3");
    let model = read_with(obj.as_bytes(), &[("my scene.mtl", "newmtl Material #25\n")]).unwrap();
    assert_eq!((model.materials.len(), model.warnings.len()), (1, 0));
}

#[test]
fn too_many_materials_are_an_error() {
    let library = |count: usize| (0..count).map(|i| format!("newmtl m{i}\n")).collect::<String>();
    let obj = format!("mtllib a.mtl\n{TRIANGLE}f 1 2 3\n");
    assert_eq!(read_with(obj.as_bytes(), &[("a.mtl", &library(65_534))]).unwrap().materials.len(), 65_535);
    let error = read_with(obj.as_bytes(), &[("a.mtl", &library(65_535))]).unwrap_err();
    assert!(error.to_string().starts_with("5: more than 65535 materials"), "{error}");
    let error = read_with(obj.as_bytes(), &[("a.mtl", &library(65_536))]).unwrap_err();
    assert!(error.to_string().starts_with("a.mtl:65536: more than 65535 materials"), "{error}");
}

#[test]
fn warnings_stay_in_proportion() {
    let libraries: String = (0..5000).map(|i| format!("mtllib {i}.mtl\n")).collect();
    let mtl = "newmtl a\nKd x\n".repeat(100);
    let model = import(libraries.as_bytes(), |_| Some(mtl.clone().into_bytes())).unwrap();
    assert_eq!((model.materials.len(), model.warnings.len()), (1, 1000));
    assert!(model.warnings[999].message.ends_with("more warnings are left out"));
}

/// Mutations of small files that use every statement: whatever comes out, it is an error or a valid mesh.
#[test]
fn no_mutation_panics() {
    let obj = format!(
        "\u{feff}# seed\nmtllib a.mtl b\\ c.mtl\no x\n{TRIANGLE}v 1 1 0 0.5\nv .5 2e0 -1 1 0 0\nvt 0\nvt 1 1\nvn 0 0 1\n\
         usemtl m\nf 1 2 4 3\nf 1/1/1 2/2/-1 -1/-2\nusemtl #2\ng y\nf 1//1 2//1 4/2 5 \\\n3/1/1\nl 1 2\nf -5 -4 -3 -2 -1 1 2\n"
    );
    let mtl = "newmtl m\nKa 0.5\nKd 1 .5 0\nKs xyz 1\nNs 1e9\nd -halo .5\nTr 1\nillum 2\n\
               map_Kd -s 1 2 3 -o 1 -mm 0 1 -clamp on -q wood\\a b.png -t 1\nnewmtl #2\nTf 1\nnewmtl m\n";
    let words = [
        "-1",
        "0",
        "1e999",
        "nan",
        "/",
        "//",
        "\\\n",
        "\r",
        " ",
        "#",
        "f",
        "v",
        "-9223372036854775808",
        "usemtl",
        "\u{e9}",
    ];
    let mut state = 0x5eed_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut accepted = 0;
    for round in 0..20_000 {
        let mut files = [obj.clone().into_bytes(), mtl.as_bytes().to_vec()];
        for _ in 0..1 + random(4) {
            let file = &mut files[random(2)];
            let at = random(file.len() + 1);
            match random(5) {
                0 => file.truncate(at),
                1 => file.insert(at, random(256) as u8),
                2 if at < file.len() => file[at] ^= 1 << random(8),
                3 => drop(file.splice(at..at, words[random(words.len())].bytes())),
                _ => drop(file.drain(at..(at + random(12)).min(file.len()))),
            }
        }
        let [obj, mtl] = files;
        let outcome = std::panic::catch_unwind(|| import(&obj, |path| path.starts_with('a').then(|| mtl.clone())));
        let outcome = outcome.unwrap_or_else(|_| panic!("round {round}: {:?}", String::from_utf8_lossy(&obj)));
        match outcome {
            Err(e) => assert!(e.0.line > 0 && !e.to_string().contains("passed every check"), "round {round}: {e}"),
            Ok(model) => {
                accepted += 1;
                assert!(model.triangles.is_empty() || model.mesh().validate().is_ok(), "round {round}");
                assert_eq!(model.name_order.len(), model.materials.len(), "round {round}");
                for m in &model.materials {
                    assert_eq!(m.material.checked(), Ok(m.material), "round {round}");
                }
            }
        }
    }
    // Neither all nothing nor all the same.
    assert!((2_000..19_000).contains(&accepted), "{accepted} of 20000 accepted");
}

/// `../shared`, if this checkout lies beside it.
fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes").join(folder);
    if !path.is_dir() {
        println!("{} is not there: its files are not tested", path.display());
        return None;
    }
    Some(path)
}

fn load(path: &Path) -> Result<Model, ImportError> {
    let obj = std::fs::read(path).unwrap();
    import(&obj, |name| std::fs::read(path.parent().unwrap().join(name)).ok())
}

/// Triangles (the sum of corners - 2 over the `f` lines, counted by a script), or the line and words of the error.
type Expected = Result<usize, (u32, &'static str)>;
const SUITE: &[(&str, Expected)] = &[
    ("tinyobjloader/models/catmark_torus_creases0", Ok(64)),
    ("tinyobjloader/models/colorspace-issue-184", Ok(1)),
    ("tinyobjloader/models/cornell_box", Ok(36)),
    ("tinyobjloader/models/cornell_box_multimaterial", Ok(36)),
    ("tinyobjloader/models/cube-vertex-w-component", Ok(12)),
    ("tinyobjloader/models/cube-vertexcol", Ok(12)),
    ("tinyobjloader/models/cube", Ok(12)),
    ("tinyobjloader/models/invalid-face-definition", Err((15, "1 corners"))),
    ("tinyobjloader/models/invalid-relative-texture-index", Err((2, "v index 1"))),
    ("tinyobjloader/models/invalid-relative-vertex-index", Err((1, "v index -4"))),
    ("tinyobjloader/models/issue-138", Ok(12)),
    ("tinyobjloader/models/issue-140-zero-face-idx", Err((16, "count from 1"))),
    ("tinyobjloader/models/issue-161-inconsistent-f", Ok(12)),
    ("tinyobjloader/models/issue-162-smoothing-group", Ok(12)),
    ("tinyobjloader/models/issue-235-usemtl-then-o", Ok(2)),
    ("tinyobjloader/models/issue-244-mtl-searchpaths", Ok(2)),
    ("tinyobjloader/models/issue-246-usemtl-whitespace", Ok(1)),
    ("tinyobjloader/models/issue-248-texres-texopt", Ok(12)),
    ("tinyobjloader/models/issue-295-trianguation-failure", Ok(28)),
    ("tinyobjloader/models/issue-319-002", Ok(14)),
    ("tinyobjloader/models/issue-319-003", Ok(8)),
    ("tinyobjloader/models/issue-330", Ok(3)),
    ("tinyobjloader/models/issue-356-leading-spaces-newmtl", Ok(0)),
    ("tinyobjloader/models/issue-92", Ok(1)),
    ("tinyobjloader/models/issue-95-2", Ok(1)),
    ("tinyobjloader/models/issue-95", Ok(1)),
    ("tinyobjloader/models/leading-decimal-dot-issue-201", Ok(1)),
    ("tinyobjloader/models/leading-zero-in-exponent-notation-issue-210", Ok(1)),
    ("tinyobjloader/models/line-prim", Ok(0)),
    ("tinyobjloader/models/map-bump", Ok(400)),
    ("tinyobjloader/models/missing_material_file", Ok(36)),
    ("tinyobjloader/models/mtl filename with whitespace issue46", Ok(12)),
    ("tinyobjloader/models/mtllib-multiple-files-issue-112", Ok(1)),
    ("tinyobjloader/models/no_material", Ok(36)),
    ("tinyobjloader/models/norm-texopt", Ok(1)),
    ("tinyobjloader/models/pbr-mat-ext", Ok(2)),
    ("tinyobjloader/models/points-prim", Ok(0)),
    ("tinyobjloader/models/refl", Ok(12)),
    ("tinyobjloader/models/skin-weight", Ok(12)),
    ("tinyobjloader/models/smoothing-group-two-squares", Ok(3)),
    ("tinyobjloader/models/smoothing-normal", Ok(6)),
    ("tinyobjloader/models/test-nan", Err((12, "not a finite number"))),
    ("tinyobjloader/models/texture-filename-with-whitespace", Ok(12)),
    ("tinyobjloader/models/texture-options-issue-85", Ok(1)),
    ("tinyobjloader/models/tr-and-d-issue-43", Ok(400)),
    ("tinyobjloader/models/usemtl-issue-104", Ok(6)),
    ("tinyobjloader/models/usemtl-issue-68", Ok(400)),
    ("tobj/obj/cornell_box", Ok(36)),
    ("tobj/obj/empty_name_triangle", Ok(1)),
    ("tobj/obj/invalid_index", Err((12, "v index 7"))),
    ("tobj/obj/lines", Ok(0)),
    ("tobj/obj/quad", Ok(5)),
    ("tobj/obj/quad_colored_merge", Ok(2)),
    ("tobj/obj/triangle", Ok(1)),
    ("tobj/obj/triangle_colored", Ok(1)),
];

#[test]
fn the_loader_suite_loads_or_says_what_is_wrong() {
    let Some(folder) = shared("loader-suite") else { return };
    for (name, expected) in SUITE {
        let found = load(&folder.join(format!("{name}.obj")));
        match (&found, expected) {
            (Ok(model), Ok(triangles)) => {
                assert_eq!(model.triangles.len(), *triangles, "{name}");
                assert_eq!(model.mesh().validate().is_ok(), *triangles > 0, "{name}");
            }
            (Err(error), Err((line, words))) => {
                assert!(error.0.line == *line && error.0.message.contains(words), "{name}: {error}");
            }
            _ => panic!("{name}: expected {expected:?}, found {:?}", found.map(|m| m.triangles.len())),
        }
    }
    // All of the folder is in the table.
    let mut files = 0;
    for part in ["tinyobjloader/models", "tobj/obj"] {
        let entries = std::fs::read_dir(folder.join(part)).unwrap().map(|e| e.unwrap().path());
        files += entries.filter(|path| path.extension().is_some_and(|e| e == "obj")).count();
    }
    assert_eq!(files, SUITE.len());

    // What the libraries are about.
    let model = |name: &str| load(&folder.join("tinyobjloader/models").join(name)).unwrap();
    assert!(!model("missing_material_file.obj").warnings.is_empty());
    assert_eq!(model("mtl filename with whitespace issue46.obj").materials[0].material.diffuse, [0.0, 1.0, 0.0]);
    assert_eq!(model("tr-and-d-issue-43.obj").materials[0].material.opacity, 0.75);
    let map = model("texture-filename-with-whitespace.obj").materials[0].map_kd.clone();
    assert_eq!(map.unwrap().path, "texture 01.png");
    let concave = model("issue-295-trianguation-failure.obj");
    let total: f64 = places(&concave).iter().map(area).sum();
    assert!((total - 14.0).abs() < 1e-9, "fourteen unit squares, area {total}");
}

fn area([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    let n = voxdag::math::cross(voxdag::math::sub(*b, *a), voxdag::math::sub(*c, *a));
    0.5 * voxdag::math::sqrt(voxdag::math::dot(n, n))
}

#[test]
fn the_thesis_scenes_have_their_triangles_and_materials() {
    let Some(folder) = shared("thesis") else { return };
    // Triangles and materials as the scenes' own README counts them; `default` is added where faces have none.
    let scenes = [
        ("bunny/bunny.obj", 29_822, 2),
        ("buddha/buddha_room.obj", 100_014, 2),
        ("dragon/dragon.obj", 100_000, 1),
        ("dragon/dragon_box.obj", 100_012, 5),
        ("sponza/sponza.obj", 66_454, 20),
        ("sponza/sponza_328131.obj", 328_131, 20),
        ("conference/conference.obj", 331_179, 32),
    ];
    for (name, triangles, materials) in scenes {
        let model = load(&folder.join(name)).unwrap();
        assert_eq!((model.triangles.len(), model.materials.len()), (triangles, materials), "{name}");
        model.mesh().validate().unwrap();
    }
}
