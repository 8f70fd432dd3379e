//! `voxdag accuracy` on scenes whose numbers are known beforehand.

mod common;
use common::Sandbox;
use serde_json::Value;

/// The setting of a label.
fn setting<'a>(report: &'a Value, label: &str) -> &'a Value {
    let settings = report["settings"].as_array().unwrap();
    settings.iter().find(|s| s["label"] == label).unwrap_or_else(|| panic!("no setting {label}"))
}

fn number(value: &Value, path: &str) -> f64 {
    let found = path.split('.').try_fold(value, |v, key| v.get(key));
    found.and_then(Value::as_f64).unwrap_or_else(|| panic!("no number `{path}` in {value:#}"))
}

/// A floor seen from 400 above, a pixel a unit: its right edge runs at 0.45 of the 41st column, voxels and all, as its far
/// side is a border between voxels. Only ambient light: one colour, half of it, in front of the background.
#[test]
fn the_edge_of_a_floor_costs_what_its_pixels_say() {
    let s = Sandbox::new();
    s.write("floor.obj", "v -59.55 0 -50\nv 40.45 0 -50\nv 40.45 0 50\nv -59.55 0 50\nf 4 3 2 1\n");
    let view =
        "--eye 32,400,0 --target 32,0,0 --view-up 0,0,-1 --fov 5.153019 --size 64x36 --ambient 1 --light 0,9,0,0,0,0";
    let flags = format!("-r 32,64 --quick --repeat 2 {view} --threads 2");
    let report = s.ok(&format!("accuracy floor.obj -o out {flags} --json")).json();
    assert_eq!((number(&report, "triangles"), &report["truth"]), (2.0, &Value::from("the mesh itself")));

    // 64 samples have half of theirs on either side in that column; so have 4 and 16. A single one sees the background.
    let background = [0.730_46, 0.760_525, 0.791_298];
    let column: f64 = background.iter().map(|b: &f64| (0.5 * (b - 0.5)) * (0.5 * (b - 0.5))).sum::<f64>() / 3.0;
    let known = (column / 64.0).sqrt();
    for label in ["default", "16 samples", "16 adaptive:2", "face normals", "32^3", "LOD 1", "f32 rays"] {
        let s = setting(&report, label);
        assert_eq!(number(s, "error.rmse"), 0.0, "{label}");
        assert_eq!((number(s, "error.ssim"), &s["error"]["psnr"]), (1.0, &Value::Null), "{label}");
        assert_eq!((number(s, "sampling_rmse"), number(s, "error.differing")), (0.0, 0.0), "{label}");
    }
    let one = setting(&report, "1 sample");
    for key in ["error.rmse", "sampling_rmse"] {
        let found = number(one, key);
        assert!((found / known - 1.0).abs() < 0.01, "{key}: {found} against {known}");
    }
    assert!((number(one, "error.psnr") + 20.0 * libm::log10(known)).abs() < 0.1);
    assert_eq!((number(one, "error.differing"), number(one, "voxels_error.rmse")), (36.0, 0.0));
    assert_eq!(number(one, "rays.primary"), 64.0 * 36.0);

    // The floor lies on the lower side of its voxels, whose upper one is seen.
    let shape = &setting(&report, "default")["shape"];
    assert_eq!(number(shape, "silhouette"), 0.0);
    assert_eq!(number(shape, "both"), 40.0 * 36.0);
    assert!((1.0..1.01).contains(&number(shape, "depth.median")) && number(shape, "depth.max") < 1.01, "{shape:#}");
    assert_eq!(number(shape, "normal.max"), 0.0);

    // What is exact is never wrong, and the right number of rays and voxels was judged.
    for wrong in report["wrong"].as_array().unwrap() {
        let method = wrong["method"].as_str().unwrap();
        if method.starts_with("exact") {
            assert_eq!((number(wrong, "missing"), number(wrong, "extra")), (0.0, 0.0), "{method}");
            assert_eq!(wrong["against"], "the integer oracle");
        }
        if ["f32 rays", "f64 rays"].contains(&method) {
            assert_eq!(number(wrong, "compared"), 4.0 * 64.0 * 36.0);
        }
        assert!(number(wrong, "compared") > 0.0 && number(wrong, "ms") > 0.0, "{method}");
    }
    // A layer of voxels; the smallest scene of a file took memory.
    let usual = &report["voxels"][0];
    assert_eq!((number(usual, "resolution"), number(usual, "voxels")), (64.0, 64.0 * 64.0));
    assert!(!cfg!(target_os = "linux") || number(usual, "build_peak_bytes") > 1e6);

    // The front: nothing faster is as accurate, where times within three hundredths are the same one.
    let place = |key: &Value| key.as_u64().unwrap() as usize;
    let recommendation = &report["recommendation"];
    let front: Vec<_> = recommendation["front"].as_array().unwrap().iter().map(place).collect();
    assert!(front.contains(&place(&recommendation["knee"])));
    let settings = report["settings"].as_array().unwrap();
    for (i, s) in settings.iter().enumerate() {
        assert_eq!(s["on_front"], front.contains(&i));
        let beaten = |k: &&usize| {
            number(&settings[**k], "render_ms.median") <= 1.03 * number(s, "render_ms.median")
                && number(&settings[**k], "error.rmse") <= number(s, "error.rmse")
        };
        assert!(s["flags"] == "" || front.contains(&i) || front.iter().find(beaten).is_some(), "{s:#}");
    }

    // All files are there and whole.
    let page = String::from_utf8(s.read("out/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    assert!(page.matches("<svg").count() >= 3 && page.contains("What accuracy costs: floor"));
    assert!(!page.contains("http://") || page.matches("http://").count() == page.matches("http://www.w3.org").count());
    let csv = String::from_utf8(s.read("out/accuracy.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + settings.len());
    let json: Value = serde_json::from_slice(&s.read("out/accuracy.json")).unwrap();
    assert_eq!(json["settings"], report["settings"]);
    assert!(s.files().iter().all(|name| !name.contains(".tmp")), "{:?}", s.files());

    // The flags of a setting give its picture again.
    let typed = setting(&report, "16 adaptive:2")["flags"].as_str().unwrap();
    s.ok(&format!("render floor.obj -o again.png {view} {typed}"));
    let kept = s.read("out/pictures/16_adaptive_2.png");
    assert!(kept == s.read("again.png"), "the kept picture is another one");
}

/// A sphere of 128 voxels from far away: which faces of its voxels are seen follows from its normals.
#[test]
fn a_sphere_is_compared_with_its_closed_form() {
    let s = Sandbox::new();
    s.write("view.toml", "effects = \"phong,+mirror\"\n[camera]\neye = [20, 12, 16]\ntarget = [0, 0, 0]\nfov = 4.5\n");
    let view = "--view view.toml --size 96x96";
    let run = s.ok(&format!("accuracy --scene sphere -o out -r 32,128 --quick --repeat 1 {view} --json"));
    assert!(run.stderr.contains("warning: view.toml: its effects are left out"), "{}", run.stderr);
    let report = run.json();
    assert_eq!(report["truth"], "the closed form");
    let degrees = |label| number(setting(&report, label), "shape.normal.mean");

    // Where the surface looks along n, a view along -v sees of each kind of face a part that goes with n v of its axis,
    // if that is above 0. Directions are those of a disc that is seen.
    let v = [20.0, 12.0, 16.0].map(|x: f64| x / 800_f64.sqrt());
    let across = [-v[2], 0.0, v[0]].map(|x| x / (v[0] * v[0] + v[2] * v[2]).sqrt());
    let up = [0, 1, 2].map(|i: usize| v[(i + 1) % 3] * across[(i + 2) % 3] - v[(i + 2) % 3] * across[(i + 1) % 3]);
    let (mut sum, mut count) = (0.0, 0.0);
    for (x, y) in (-50..=50).flat_map(|x| (-50..=50).map(move |y| (f64::from(x) / 50.5, f64::from(y) / 50.5))) {
        if x * x + y * y < 1.0 {
            let z = (1.0 - x * x - y * y).sqrt();
            let n = [0, 1, 2].map(|i: usize| x * across[i] + y * up[i] + z * v[i]);
            let parts = [0, 1, 2].map(|i: usize| (n[i] * v[i]).max(0.0));
            let off: f64 = (0..3).map(|i: usize| parts[i] * libm::acos(n[i].abs()).to_degrees()).sum();
            sum += off / parts.iter().sum::<f64>();
            count += 1.0;
        }
    }
    let known: f64 = sum / count;
    assert!((degrees("face normals") / known - 1.0).abs() < 0.03, "{} against {known}", degrees("face normals"));

    // The better the method the smaller the angle; and fewer voxels cost accuracy.
    let order = ["stored normals", "default", "plane1 normals", "gradient normals", "face normals"];
    assert!(order.windows(2).all(|pair| degrees(pair[0]) < degrees(pair[1])), "{:?}", order.map(degrees));
    assert!(degrees("stored normals") < 2.0 && degrees("default") < degrees("32^3"));
    let depth = number(setting(&report, "default"), "shape.depth.median");
    assert!((0.3..2.0).contains(&depth), "{depth}");
}

#[test]
fn what_cannot_be_measured_is_said() {
    let s = Sandbox::new();
    s.write("floor.obj", "v 0 0 0\nv 8 0 0\nv 8 0 8\nv 0 0 8\nf 4 3 2 1\n");
    let before = s.files();
    s.run("accuracy floor.obj --scene sphere").fails(2, &["--scene"]);
    s.run("accuracy nothing.obj").fails(3, &["nothing.obj"]);
    s.run("accuracy floor.obj --quick -r 0").fails(2, &["resolution", "0"]);
    s.run("accuracy floor.obj --quick -r 16 --size 8x8 --eye 0,9,0 --target 0,20,0")
        .fails(2, &["no ray of the picture hits the mesh", "--eye"]);
    assert_eq!(s.files(), before);
}

/// Where a single voxel is all that is left there are no levels of detail below it.
#[test]
fn the_smallest_resolutions_are_measured() {
    let s = Sandbox::new();
    s.write("floor.obj", "v 0 0 0\nv 8 0 0\nv 8 0 8\nv 0 0 8\nf 4 3 2 1\n");
    for resolution in ["1", "2", "4"] {
        s.ok(&format!("accuracy floor.obj -o out -r {resolution} --size 9x5 --repeat 1"));
    }
}

#[test]
fn the_memory_limit_holds_for_all_pictures() {
    let s = Sandbox::new();
    s.write("floor.obj", "v 0 0 0\nv 8 0 0\nv 8 0 8\nv 0 0 8\nf 4 3 2 1\n");
    let before = s.files();
    // A picture takes 9 MB, and there are some forty.
    s.run("accuracy floor.obj --quick -r 16 --size 1500x1500 --memory-limit 150M").fails(4, &["pictures", "--size"]);
    assert_eq!(s.files(), before);
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_leaves_no_folders() {
    let s = Sandbox::new();
    std::fs::create_dir(s.path("temporary")).unwrap();
    let mut child = s
        .command("accuracy -o out --threads 1")
        .env("TMPDIR", s.path("temporary"))
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let is_empty = |name: &str| std::fs::read_dir(s.path(name)).unwrap().next().is_none();
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(30);
    while is_empty("temporary") {
        assert!(std::time::Instant::now() < deadline, "nothing temporary appeared");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let killed =
        std::process::Command::new("bash").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(is_empty("temporary") && !s.path("out").exists());
}

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let s = Sandbox::new();
    s.write("floor.obj", "v 0 0 0\nv 8 0 0\nv 8 0 8\nv 0 0 8\nf 4 3 2 1\n");
    std::fs::create_dir(s.path("out")).unwrap();
    s.write("out/pictures", "a file");
    s.run("accuracy floor.obj -o out -r 16 --size 9x5").fails(1, &["out/pictures"]);
    assert_eq!(std::fs::read_dir(s.path("out")).unwrap().count(), 1);
}
