//! The examples compile with the system's C and C++ compilers, without a warning, and draw what Rust draws, byte for byte.
//!
//! They link the staticlib that cargo makes beside this test, as it makes the library in all of its forms. Without a
//! compiler the tests say so and pass.

mod scenes;

use std::path::{Path, PathBuf};
use std::process::Command;

use scenes::Kind;
use voxdag::camera::Camera;
use voxdag::file::{self, Parts};
use voxdag::grid::UpAxis;
use voxdag::normal::{NormalKind, normal};
use voxdag::render::{Settings, View, render_rows};
use voxdag::scene::{Build, Options};
use voxdag::trace::{Query, Tracer};
use voxdag::{Geometry, Grid, Material, Materials, Mesh};

/// What programs link beside the library: `cargo rustc -p voxdag-capi --release -- --print native-static-libs`.
const SYSTEM: &[&str] = if cfg!(target_os = "macos") {
    &["-framework", "CoreFoundation", "-liconv", "-lm"]
} else {
    &["-lpthread", "-ldl", "-lm", "-lrt"]
};
const C99: &[&str] = &["cc", "-std=c99"];
const C11: &[&str] = &["cc", "-std=c11"];
const CXX17: &[&str] = &["c++", "-std=c++17"];

/// Compiles an example for a compiler and links it; `None` if there is no such compiler.
fn compile(example: &str, compiler: &[&str]) -> Option<PathBuf> {
    let [command, standard] = compiler else { panic!("a command and a standard") };
    if !cfg!(unix) || Command::new(command).arg("--version").output().is_err() {
        println!("SKIPPED: {example} with {command} {standard}, as there is no {command}");
        return None;
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let library = std::env::current_exe().unwrap().with_file_name("libvoxdag_capi.a");
    assert!(library.exists(), "cargo makes {} with this test", library.display());
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{example}{standard}"));
    let made = Command::new(command)
        .args([standard, "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Wundef", "-Werror", "-I"])
        .arg(here)
        .arg(here.join("examples").join(example))
        .arg(library)
        .args(SYSTEM)
        .arg("-o")
        .arg(&program)
        .output()
        .unwrap();
    assert!(made.status.success(), "{example}: {}", String::from_utf8_lossy(&made.stderr));
    Some(program)
}

/// What a program prints.
fn run(program: &Path, arguments: &[&Path]) -> String {
    let output = Command::new(program).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}: {}", program.display(), String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn ppm(width: u32, height: u32, rgb: impl Iterator<Item = u8>) -> Vec<u8> {
    format!("P6\n{width} {height}\n255\n").into_bytes().into_iter().chain(rgb).collect()
}

fn bytes_of(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

#[test]
fn the_c_example_draws_what_rust_draws() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let [path, picture] = ["draw.vxd", "draw.ppm"].map(|name| folder.join(name));
    let arguments = [&path, &picture, Path::new("160"), Path::new("90")];
    for (kind, compiler) in [(Kind::Normals, C99), (Kind::Mirrors, C99), (Kind::Colors, C11)] {
        let Some(program) = compile("draw.c", compiler) else { return };
        let words = scenes::words(kind, 120);
        std::fs::write(&path, bytes_of(&words)).unwrap();
        let printed = run(&program, &arguments);
        let scene = file::read(&words).unwrap();
        assert!(std::fs::read(&picture).unwrap() == picture_of(&scene), "{kind:?}, {compiler:?}: another picture");
        let voxels = scene.geometry.voxels().count();
        for line in ["resolution 120, depth 7", &format!("voxels {voxels} in {} words", words.len()), "\"floor\""] {
            assert!(printed.contains(line), "{line} is not in\n{printed}");
        }
        // A damaged file: what the core says of it.
        std::fs::write(&path, &bytes_of(&words)[..1000]).unwrap();
        let output = Command::new(&program).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        let message = file::read(&words[..250]).unwrap_err().to_string();
        assert!(String::from_utf8_lossy(&output.stderr).contains(&message));
    }
}

/// The default view, 160 x 90.
fn picture_of(scene: &file::Scene<'_>) -> Vec<u8> {
    let camera = Camera::framing(&scene.bounds, scene.up);
    let settings = Settings { width: 160, height: 90, ..Settings::default() };
    let palette: Vec<_> = (0..scene.material_count()).map(|id| scene.material(id as u16)).collect();
    let view = View {
        tracer: Tracer::new(scene.geometry),
        materials: scene.looks(),
        palette: &palette,
        grid: scene.grid,
        camera,
        lights: &[camera.headlight(scene.bounds.radius())],
    };
    let mut pixels = vec![0; 160 * 90];
    render_rows(&view, &settings, 0..90, &mut pixels).unwrap();
    ppm(160, 90, pixels.iter().flat_map(|pixel| pixel.to_le_bytes().into_iter().take(3)))
}

#[test]
fn the_cpp_example_builds_and_traces_what_rust_does() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let [path, picture] = ["build.vxd", "build.ppm"].map(|name| folder.join(name));
    let Some(program) = compile("build.cpp", CXX17) else { return };
    let printed = run(&program, &[&path, &picture]);

    // The same file.
    let positions = [
        [0.0, 1.0, 0.0],
        [0.0, 3.0, 0.0],
        [1.0, 2.0, 0.0],
        [-1.0, 2.0, 0.0],
        [0.0, 2.0, 1.0],
        [0.0, 2.0, -1.0],
        [-2.0, 0.0, -2.0],
        [2.0, 0.0, -2.0],
        [2.0, 0.0, 2.0],
        [-2.0, 0.0, 2.0],
    ];
    let triangles =
        [[1, 4, 2], [1, 2, 5], [1, 5, 3], [1, 3, 4], [0, 2, 4], [0, 5, 2], [0, 3, 5], [0, 4, 3], [6, 9, 8], [6, 8, 7]];
    let ids = [0, 0, 0, 0, 0, 0, 0, 0, 1, 1];
    let mesh = Mesh { positions: &positions, triangles: &triangles, materials: &ids, ..Mesh::default() };
    let bounds = mesh.validate().unwrap();
    let grid = Grid::fit(&bounds, 256).unwrap();
    let built = Build::new(&mesh, &grid, &Options::default()).unwrap().run().unwrap();
    let parts = Parts {
        grid,
        bounds,
        up: UpAxis::Y,
        metres_per_unit: 1.0,
        geometry: built.dag.dag().into(),
        voxel_materials: built.materials.as_materials(None).unwrap(),
        colors: None,
        materials: &[Material { diffuse: [0.5, 0.05, 0.05], ..Material::GREY }, Material::GREY],
        names: &["red", "floor"],
    };
    let words = parts.to_vec().unwrap();
    assert!(std::fs::read(&path).unwrap() == bytes_of(&words), "another file");
    let scene = file::read(&words).unwrap();
    assert_eq!(printed, format!("{} voxels in {} words\n", scene.geometry.voxels().count(), words.len()));

    // The same hits, one by one.
    let tracer = Tracer::new(scene.geometry);
    let side = 192;
    let pixel = |i: u32| {
        let [x, y] = [i % side, i / side].map(|k| f64::from(k) * 256.0 / f64::from(side));
        let ray = Query::new([x + 0.5, 400.0, y + 200.5], [0.0, -1.0, -0.5]);
        let lit = |hit| {
            let up = normal(&tracer, scene.materials, &hit, ray.dir, NormalKind::Plane2).direction[1];
            scene.material(scene.materials.id(hit.voxel)).diffuse.map(|diffuse| diffuse * (1.0 + up))
        };
        let light = tracer.trace(Default::default(), &ray).map_or([0.125; 3], lit);
        light.map(|light| (255.0 * light) as u8)
    };
    let expected = ppm(side, side, (0..side * side).flat_map(pixel));
    assert!(std::fs::read(&picture).unwrap() == expected, "another picture");
    assert!(expected.chunks(3).collect::<std::collections::BTreeSet<_>>().len() > 5, "a picture shows something");
}

/// The program in docs/embedding.md is the one that is compiled here.
#[test]
fn the_first_program_is_that_of_the_documentation() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = std::fs::read_to_string(here.join("examples/first.c")).unwrap();
    let text = std::fs::read_to_string(here.join("../../docs/embedding.md")).unwrap();
    assert!(text.contains(&format!("```c\n{program}```")), "docs/embedding.md must show core/capi/examples/first.c");
    for compiler in [C99, C11] {
        let Some(program) = compile("first.c", compiler) else { return };
        assert_eq!(run(&program, &[]), "hit at 599\n");
    }
}
