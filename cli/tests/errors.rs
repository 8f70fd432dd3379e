//! What goes wrong ends with the right exit code, names the place, says what to do and leaves nothing half done.

mod common;
use common::{OBJ, Sandbox};

#[test]
fn usage_errors_exit_with_2() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 8");
    let before = s.files();
    for (line, words) in [
        ("frobnicate", &["frobnicate"][..]),
        ("build box.obj", &["--output"]),
        ("build box.obj -o out.vxd -r 0", &["1 to 2097152"]),
        ("build box.obj -o out.vxd -r 2097153", &["1 to 2097152"]),
        ("build box.obj -o out.vxd -r 64 --voxel-size 0.1", &["--origin"]),
        ("build box.obj -o out.vxd --voxel-size nan", &["finite"]),
        ("build box.obj -o out.vxd --voxel-size -1", &["greater than 0"]),
        ("build box.obj -o out.vxd --origin 1,2", &["three numbers"]),
        ("build box.obj -o out.vxd --memory-limit lots", &["512M"]),
        ("build box.obj -o out.vxd -r -1", &["1 to 2097152"]),
        ("build box.obj -o out.vxd -r 1e3", &["1 to 2097152"]),
        ("build box.obj -o out.vxd --threads 0", &["1 to 1024"]),
        ("build box.obj -o out.vxd --threads -1", &["1 to 1024"]),
        ("build box.obj -o out.vxd --threads abc", &["1 to 1024"]),
        ("render box.obj -o out.png --size -1x5", &["1280x720"]),
        ("render box.obj -o out.png --view-up 0,0,0", &["direction"]),
        ("render box.obj -o out.png --ambient 1e300", &["1e300", "3.4e38"]),
        ("build box.obj -o out.txt", &["out.txt", ".vxd"]),
        ("render box.obj -o out.jpg", &["out.jpg", ".png"]),
        ("render box.obj -o out.png --eye 1,2,inf", &["finite"]),
        ("render box.obj -o out.png --eye 1,x,3", &["`x` is not a number"]),
        ("render box.obj -o out.png --size 0x5", &["1280x720"]),
        ("render box.obj -o out.png --samples 3", &["1, 4, 5, 16 or 64"]),
        ("render box.obj -o out.png --supersample far", &["near[:SHARE]", "adaptive"]),
        ("render box.obj -o out.png --supersample near:2", &["0 to 1"]),
        ("render box.obj -o out.png --supersample region:9,9,3,3", &["X0 below X1"]),
        ("render box.obj -o out.png --supersample near --samples 1", &["near:0.5", "--samples 1"]),
        ("render box.obj -o out.png --supersample adaptive --samples 5", &["adaptive:2", "16 or 64"]),
        ("render box.obj -o out.png --size 9x9 --supersample region:0,0,10,9", &["region:0,0,10,9", "9x9"]),
        ("render box.obj -o out.png --show depth --supersample near", &["--supersample"]),
        ("render box.obj -o out.png --show samples", &["--show samples", "add --supersample"]),
        ("render box.obj -o out.png --fov 180", &["below 180"]),
        ("render box.obj -o out.png --light 1,2", &["x,y,z,r,g,b"]),
        ("render box.obj -o out.png --ambient -1", &["0 (none)"]),
        ("render box.obj -o out.png --eye 1,1,1 --target 1,1,1", &["--eye", "--target"]),
        ("render box.vxd -o out.png -r 64", &["--resolution", "box.vxd"]),
    ] {
        s.run(line).fails(2, words);
    }
    assert_eq!(s.files(), before);
}

#[test]
fn bad_input_exits_with_3_and_names_file_and_line() {
    let s = Sandbox::new();
    s.write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n\nf 1 2 9\n");
    s.write("number.obj", "v 0 0 0\nv 1 zwei 0\nv 0 1 0\nf 1 2 3\n");
    s.write("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
    s.write("empty.obj", "");
    s.write("points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n");
    s.write("fake.vxd", OBJ);
    s.write("mesh.stl", "solid");
    let before = s.files();
    for (line, words) in [
        ("build index.obj -o out.vxd", &["index.obj:6:", "9"][..]),
        ("build number.obj -o out.vxd", &["number.obj:2:", "zwei"]),
        ("render nan.obj -o out.png", &["nan.obj:3:"]),
        ("build empty.obj -o out.vxd", &["empty.obj"]),
        ("build points.obj -o out.vxd", &["points.obj"]),
        ("build no-such.obj -o out.vxd", &["no-such.obj", "no such file"]),
        ("build . -o out.vxd", &["folder"]),
        ("render fake.vxd -o out.png", &["fake.vxd", "not a voxdag scene"]),
        ("info box.obj", &["box.obj", "not a voxdag scene", "voxdag build box.obj"]),
        ("verify no-such.vxd", &["no-such.vxd", "no such file"]),
        ("render mesh.stl -o out.png", &["mesh.stl", ".obj"]),
    ] {
        s.run(line).fails(3, words);
    }
    assert_eq!(s.files(), before);
}

#[test]
fn a_mesh_that_reaches_out_of_a_chosen_grid_is_refused() {
    let s = Sandbox::new();
    s.run("build box.obj -o out.vxd -r 4 --voxel-size 0.1 --origin 0,0,0")
        .fails(2, &["box.obj", "0.4, 0.4, 0.4", "--origin"]);
    s.run("build box.obj -o out.vxd -r 64 --origin 1,0,0").fails(2, &["box.obj", "1, 0, 0", "--origin"]);
    s.ok("build box.obj -o out.vxd -r 64 --voxel-size 0.1 --origin -1,-1,-1");
}

#[test]
fn a_damaged_scene_is_refused_wherever_the_damage_is() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 16");
    let whole = s.read("box.vxd");
    let step = (whole.len() / 97).max(1);
    for at in (0..whole.len()).step_by(step) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        s.write("bad.vxd", &bytes);
        s.run("verify bad.vxd").fails(3, &["bad.vxd"]);
    }
    for length in [0, 1, 3, 4, 64, whole.len() - 4, whole.len() - 1] {
        s.write("bad.vxd", &whole[..length]);
        for command in ["verify bad.vxd", "info bad.vxd", "render bad.vxd -o out.png"] {
            s.run(command).fails(3, &["bad.vxd"]);
        }
    }
}

#[test]
fn memory_over_the_limit_exits_with_4_and_says_how_much_is_needed() {
    let s = Sandbox::new();
    s.run("build box.obj -o out.vxd -r 2048 --memory-limit 1M").fails(4, &["bytes", "--memory-limit", "hint:"]);
    s.run("render box.obj -o out.png -r 8 --size 8000x8000 --memory-limit 100M").fails(4, &["bytes", "hint:"]);
    // Layouts and arrays are refused before they are made, not when the picture finds no room beside them.
    for flags in ["-r 3000 --geometry svo --materials none", "-r 1000 --materials palette"] {
        let run = s.run(&format!("render box.obj -o out.png {flags} --size 64x48 --memory-limit 4M"));
        run.fails(4, &["box.obj at resolution", "bytes", "--memory-limit"]);
    }
    assert_eq!(s.files(), ["box.mtl", "box.obj"]);
    s.ok("build box.obj -o out.vxd -r 64 --memory-limit 1GiB");
}

/// A wavy sheet of `2 n^2` triangles.
fn sheet(n: usize) -> String {
    let mut obj = String::new();
    for i in 0..=n {
        for j in 0..=n {
            obj += &format!("v {i} {j} {}\n", (i * 7 + j * 3) % 11);
        }
    }
    for a in (0..n).flat_map(|i| (0..n).map(move |j| i * (n + 1) + j + 1)) {
        obj += &format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + n + 2, a + n + 2, a + n + 1);
    }
    obj
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_within_the_limit_stays_within_it() {
    let s = Sandbox::new();
    s.write("sheet.obj", sheet(200));
    let mut fits = 0;
    for (limit, command) in [
        (8, "build sheet.obj -o sheet.vxd -r 512"),
        (40, "build sheet.obj -o sheet.vxd -r 512"),
        (40, "build sheet.obj -o sheet.vxd -r 512 --materials none"),
        (200, "build sheet.obj -o sheet.vxd -r 512 --materials table-normals"),
        (60, "render sheet.obj -o sheet.png -r 400 --size 900x900 --samples 1 --normals face"),
    ] {
        let run = s.run(&format!("{command} --memory-limit {limit}M --json"));
        if run.code == 0 {
            let peak = run.json()["peak_rss_bytes"].as_u64().unwrap();
            assert!(peak <= (limit + 24) << 20, "{command}: {peak} bytes with a limit of {limit}M");
            fits += 1;
        } else {
            run.fails(4, &["bytes", "--memory-limit"]);
        }
    }
    assert!((2..5).contains(&fits), "{fits} of the runs fit: the limits test nothing");
}

#[test]
fn the_amount_that_the_hint_names_will_do() {
    let s = Sandbox::new();
    for (command, coarser) in [("build box.obj -o out.vxd -r 300 --materials table", true), ("demo", false)] {
        let mut limit = "4M".to_owned();
        let mut tries = 0;
        loop {
            let run = s.run(&format!("{command} --memory-limit {limit}"));
            if run.code == 0 {
                break;
            }
            run.fails(4, &["--memory-limit"]);
            assert_eq!(run.stderr.contains("try -r 150"), coarser, "{}", run.stderr);
            assert!(coarser || !run.stderr.contains("-r "), "{}", run.stderr);
            let hint = run.stderr.lines().find(|line| line.contains("hint:")).unwrap();
            limit = hint.rsplit(' ').next().unwrap().to_owned();
            tries += 1;
            // Parsing, building and drawing are asked for one after the other.
            assert!(tries <= if coarser { 1 } else { 3 }, "{}", run.stderr);
        }
        assert!(tries > 0);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_has_no_end_or_cannot_be_read_does_not_hang_the_run() {
    let s = Sandbox::new();
    std::fs::create_dir(s.path("dir.mtl")).unwrap();
    let made = std::process::Command::new("mkfifo").arg(s.path("pipe.mtl")).status();
    let pipe = if made.is_ok_and(|status| status.success()) { "pipe.mtl" } else { "dir.mtl" };
    for library in [pipe, "/dev/zero", "dir.mtl"] {
        s.write("odd.obj", OBJ.replace("box.mtl", library));
        let run = s.ok("build odd.obj -o odd.vxd -r 8");
        assert!(run.stderr.contains("cannot be read: it is not a regular file"), "{}", run.stderr);
        assert!(run.stderr.contains(library) && !run.stderr.contains("is not there"), "{}", run.stderr);
    }
    // A library counts towards the limit, and so does an input without a length.
    s.write("big.mtl", "#".repeat(3 << 20));
    s.write("big.obj", OBJ.replace("box.mtl", "big.mtl"));
    s.run("build big.obj -o big.vxd -r 8 --memory-limit 2M").fails(4, &["big.mtl"]);
    s.run("build /dev/zero -o zero.vxd --memory-limit 4M").fails(4, &["/dev/zero"]);
}

#[test]
fn verify_says_in_json_what_is_wrong() {
    let s = Sandbox::new();
    s.write("bad.vxd", "bad!");
    let run = s.run("verify bad.vxd --json");
    assert_eq!(run.code, 3);
    let json = run.json();
    assert_eq!(json["ok"], false);
    let error = json["error"].as_str().unwrap();
    assert!(error.contains("bad.vxd") && run.stderr.contains(&format!("error: {error}")), "{}", run.stderr);
    s.run("info bad.vxd --json").fails(3, &["bad.vxd"]);
}

#[test]
fn names_do_not_steer_the_terminal() {
    let s = Sandbox::new();
    s.write("odd.mtl", common::MTL.replace("red", "r\u{1b}[31med"));
    s.write("odd.obj", OBJ.replace("box.mtl", "odd.mtl"));
    s.ok("build odd.obj -o odd.vxd -r 8");
    let info = s.ok("info odd.vxd").stdout;
    assert!(info.contains(r"r\u{1b}[31med") && !info.contains('\u{1b}'), "{info}");
    assert_eq!(s.ok("info odd.vxd --json").json()["materials"][0]["name"], "r\u{1b}[31med");
}

#[test]
fn the_input_is_never_overwritten() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 8");
    // A mesh may have any name: content decides what a file is.
    s.write("mesh.vxd.obj", OBJ);
    std::fs::rename(s.path("mesh.vxd.obj"), s.path("mesh.png")).unwrap();
    std::fs::create_dir(s.path("sub")).unwrap();
    let scene = s.read("box.vxd");
    s.write("picture.png", &scene);
    for line in ["render picture.png -o picture.png", "render picture.png -o sub/../picture.png"] {
        s.run(line).fails(2, &["picture.png", "never overwritten"]);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("picture.png", s.path("link.png")).unwrap();
        s.run("render picture.png -o link.png").fails(2, &["never overwritten"]);
        s.run("render link.png -o picture.png").fails(2, &["never overwritten"]);
        std::fs::hard_link(s.path("picture.png"), s.path("hard.png")).unwrap();
        s.run("render picture.png -o hard.png").fails(2, &["never overwritten"]);
    }
    assert_eq!(s.read("picture.png"), scene);

    // Nor the material file.
    s.write("m.obj", OBJ.replace("box.mtl", "m.vxd"));
    s.write("m.vxd", common::MTL);
    s.run("build m.obj -o m.vxd -r 8").fails(2, &["m.vxd", "never overwritten"]);
    assert_eq!(s.read("m.vxd"), common::MTL.as_bytes());
    assert!(!s.files().iter().any(|f| f.ends_with(".tmp")), "{:?}", s.files());
}

#[test]
fn places_that_cannot_be_written_exit_with_1_and_stay_as_they_are() {
    let s = Sandbox::new();
    s.run("build box.obj -o no/such/folder/out.vxd").fails(1, &["no/such/folder", "hint:"]);
    #[cfg(target_os = "linux")]
    s.run("build box.obj -o /proc/out.vxd").fails(1, &["/proc/out.vxd", "another folder with -o"]);
    std::fs::create_dir(s.path("dir.vxd")).unwrap();
    s.run("build box.obj -o dir.vxd").fails(1, &["dir.vxd", "regular file"]);
    // A failure keeps what was there before.
    s.write("old.vxd", "old");
    s.write("bad.obj", "v 0 0\nf 1 1 1\n");
    s.run("build bad.obj -o old.vxd").fails(3, &["bad.obj:1:"]);
    assert_eq!(s.read("old.vxd"), b"old");
}

#[cfg(unix)]
#[test]
fn a_link_is_followed_and_a_new_file_has_the_usual_rights() {
    use std::os::unix::fs::PermissionsExt;
    let s = Sandbox::new();
    s.write("real.vxd", "old");
    std::os::unix::fs::symlink("real.vxd", s.path("link.vxd")).unwrap();
    s.ok("build box.obj -o link.vxd -r 8");
    assert!(s.path("link.vxd").is_symlink());
    s.ok("verify real.vxd");
    let rights = |name: &str| std::fs::metadata(s.path(name)).unwrap().permissions().mode() & 0o777;
    s.ok("build box.obj -o new.vxd -r 8");
    assert_eq!(rights("new.vxd"), rights("box.obj"));
    std::fs::set_permissions(s.path("new.vxd"), std::fs::Permissions::from_mode(0o640)).unwrap();
    s.ok("build box.obj -o new.vxd -r 8");
    assert_eq!(rights("new.vxd"), 0o640);
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_removes_what_is_half_written_and_exits_with_130() {
    let s = Sandbox::new();
    let mut child = s
        .command("render box.obj -o out.png -r 256 --size 8000x8000 --samples 64 --threads 1")
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // The temporary file is there before any long work begins.
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(30);
    while !s.files().iter().any(|f| f.ends_with(".tmp")) {
        assert!(std::time::Instant::now() < deadline, "no temporary file appeared");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    // The shell's own `kill`: the program of that name is not everywhere.
    let killed =
        std::process::Command::new("bash").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(s.files(), ["box.mtl", "box.obj"]);
}

/// Writes `name` with one row of three voxels, and a table that has entries for `entries` (x coordinates).
fn scene_with_entries(s: &Sandbox, name: &str, entries: &[u32]) {
    use voxdag::materials::AnyMaterials;
    use voxdag::table::{Entry, TableBuf};
    let at = |x| voxdag::Morton::encode([x, 0, 0]).unwrap();
    let mut builder = voxdag::build::DagBuilder::new(2).unwrap();
    builder.push(at(0), [0, 1, 2].map(|x| 1 << at(x).0).iter().sum()).unwrap();
    let dag = builder.finish().unwrap();
    let mut table = TableBuf::new(entries.len() as u64, false).unwrap();
    table.insert_all(entries.iter().map(|&x| (at(x), Entry { material: 0, normal: None }))).unwrap();
    let parts = voxdag::file::Parts {
        grid: voxdag::Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: 4 },
        bounds: voxdag::grid::Bounds { min: [0.0; 3], max: [4.0; 3] },
        up: Default::default(),
        metres_per_unit: 0.0,
        geometry: dag.dag().into(),
        voxel_materials: AnyMaterials::Table(table.as_table()),
        colors: None,
        materials: &[voxdag::Material::GREY],
        names: &["grey"],
    };
    let words = parts.to_vec().unwrap();
    s.write(name, words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<_>>());
}

#[test]
fn verify_holds_the_table_against_the_voxels() {
    let s = Sandbox::new();
    scene_with_entries(&s, "right.vxd", &[0, 1, 2]);
    scene_with_entries(&s, "less.vxd", &[0, 2]);
    scene_with_entries(&s, "more.vxd", &[0, 1, 2, 3]);
    scene_with_entries(&s, "other.vxd", &[0, 1, 3]);
    s.ok("verify right.vxd");
    s.run("verify less.vxd").fails(3, &["less.vxd", "3 voxels, but 2 entries"]);
    s.run("verify more.vxd").fails(3, &["more.vxd", "3 voxels, but 4 entries"]);
    s.run("verify other.vxd").fails(3, &["other.vxd", "voxel (2, 0, 0) has no entry"]);
}

#[test]
fn a_scene_without_a_page_to_show_it_says_how_to_make_one() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 8");
    s.run("view box.obj --page . --no-open").fails(3, &["box.obj", "voxdag build"]);
    s.run("view none.vxd --no-open").fails(3, &["none.vxd"]);
    s.run("view box.vxd --page . --no-open").fails(1, &["there is no page", "cargo web build", "--page"]);
}
