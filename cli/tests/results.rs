//! What the commands give: the same bytes however they are called, and reports that programs can read.

mod common;
use common::{GRID, OBJ, Sandbox};
use serde_json::Value;

/// Every key of `keys` (dots go down) is there.
fn has_keys(value: &Value, keys: &str) {
    for key in keys.split_whitespace() {
        let found = key.split('.').try_fold(value, |v, k| v.get(k));
        assert!(found.is_some(), "no `{key}` in {value:#}");
    }
}

#[test]
fn build_reports_in_json_and_nothing_else_on_stdout() {
    let s = Sandbox::new();
    let run = s.ok("build box.obj -o box.vxd -r 100 --json --threads 2");
    let json = run.json();
    has_keys(
        &json,
        "resolution depth origin voxel_size triangles voxels octree_nodes octree_bricks nodes bricks bytes.nodes bytes.bricks bytes.materials \
         bytes.file ms.parse ms.voxelize ms.reduce ms.materials ms.write ms.total peak_rss_bytes threads",
    );
    assert_eq!(json["resolution"], 100);
    assert_eq!(json["depth"], 7);
    assert_eq!(json["triangles"], 12);
    assert_eq!(json["threads"], 2);
    assert_eq!(json["voxel_size"].as_f64(), Some(2.0 / 100.0));
    assert_eq!(json["bytes"]["file"].as_u64(), Some(s.read("box.vxd").len() as u64));
    assert!(run.stderr.contains("render box.vxd -o box.png"), "{}", run.stderr);
}

#[test]
fn info_agrees_with_build() {
    let s = Sandbox::new();
    let built = s.ok("build box.obj -o box.vxd -r 100 --json").json();
    let info = s.ok("info box.vxd --json").json();
    has_keys(&info, "resolution depth origin voxel_size box voxels levels bytes bits_per_voxel materials");
    for key in ["resolution", "depth", "origin", "voxel_size", "voxels"] {
        assert_eq!(info[key], built[key], "{key}");
    }
    let levels = info["levels"].as_array().unwrap();
    let unique = |brick: bool| -> u64 {
        levels.iter().filter(|l| (l["level"] == 2) == brick).map(|l| l["unique"].as_u64().unwrap()).sum()
    };
    let octree = |brick: bool| -> u64 {
        levels.iter().filter(|l| (l["level"] == 2) == brick).map(|l| l["octree"].as_u64().unwrap()).sum()
    };
    assert_eq!(Some(octree(true)), built["octree_bricks"].as_u64());
    assert_eq!(Some(octree(false)), built["octree_nodes"].as_u64());
    assert_eq!(Some(unique(true)), built["bricks"].as_u64());
    assert_eq!(Some(unique(false)), built["nodes"].as_u64());
    assert!(levels.iter().all(|l| l["octree"].as_u64() >= l["unique"].as_u64()));
    let names: Vec<_> = info["materials"].as_array().unwrap().iter().map(|m| m["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["red", "blue"]);
    let text = s.ok("info box.vxd").stdout;
    for word in ["resolution", "100", "voxel size", "0.02", "red", "blue"] {
        assert!(text.contains(word), "no `{word}` in\n{text}");
    }
}

#[test]
fn numbers_come_back_with_the_same_bits() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd --voxel-size 0.0712345678901234 --origin -0.1,-0.30000000000000004,-1e-7");
    let info = s.ok("info box.vxd --json").json();
    assert_eq!(info["voxel_size"].as_f64(), Some(0.0712345678901234));
    let origin: Vec<_> = info["origin"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert_eq!(origin, [-0.1, -0.30000000000000004, -1e-7]);
    assert!(s.ok("info box.vxd").stdout.contains("-0.30000000000000004"));
}

#[test]
fn the_same_mesh_gives_the_same_bytes_on_any_number_of_threads() {
    let s = Sandbox::new();
    for materials in ["none", "table", "table-normals"] {
        let build = |threads: u32| {
            s.ok(&format!("build box.obj -o t{threads}.vxd -r 200 --materials {materials} --threads {threads}"));
            s.read(&format!("t{threads}.vxd"))
        };
        let one = build(1);
        for threads in 2..=8 {
            assert!(one == build(threads), "{materials}, {threads} threads");
        }
    }
}

#[test]
fn covers_differ_and_contain_each_other() {
    let s = Sandbox::new();
    let voxels = |cover: &str| {
        s.ok(&format!("build box.obj -o c.vxd -r 64 --cover {cover} --json")).json()["voxels"].as_u64().unwrap()
    };
    let (thin, exact, inflated) = (voxels("thin"), voxels("exact"), voxels("inflated"));
    assert!(thin < exact && exact <= inflated, "{thin} {exact} {inflated}");
}

#[test]
fn a_mesh_and_its_scene_give_the_same_picture() {
    let s = Sandbox::new();
    for (build, picture) in [
        ("", ""),
        ("--materials none", "--normals face --samples 1"),
        ("--materials table-normals", "--normals stored --samples 5"),
        ("--up-axis z", "--normals gradient --arithmetic f64 --light 3,4,5,1,0.5,0.2 --ambient 0.1,0.2,0.3"),
        ("", "--shadows --light 3,4,5 --samples 5"),
        ("--cover thin", "--normals plane3 --eye -3,2,4 --target 0,0,0 --view-up 0,0,1 --fov 60"),
    ] {
        s.ok(&format!("build box.obj -o box.vxd -r 60 {build}"));
        s.ok(&format!("render box.vxd -o scene.png --size 64x48 {picture} --threads 1"));
        s.ok(&format!("render box.obj -o mesh.png --size 64x48 -r 60 {build} {picture} --threads 3"));
        let (scene, mesh) = (s.read("scene.png"), s.read("mesh.png"));
        assert!(scene == mesh, "{build} {picture}");
        assert!(scene.starts_with(b"\x89PNG"));
    }
}

#[test]
fn the_next_command_keeps_the_flags_and_works() {
    let s = Sandbox::new();
    let flags = "-r 40 --voxel-size 0.1 --origin -1,-1,-1 --cover thin --materials table-normals --up-axis z";
    let run = s.ok(&format!("render box.obj -o out.png --size 16x9 {flags}"));
    let next = run.stderr.lines().last().unwrap();
    assert!(next.ends_with(&format!(" build box.obj -o out.vxd {flags}")), "{next}");
    s.ok(next.split_once(" build ").map(|(_, rest)| format!("build {rest}")).unwrap().as_str());
    let run = s.ok("render out.vxd -o again.png --size 16x9 --eye -3,2,4");
    let next = run.stderr.lines().last().unwrap();
    assert!(next.ends_with(" render out.vxd -o again.png --size 16x9 --eye -3,2,4 --samples 16"), "{next}");
    s.ok("render out.vxd -o again.png --size 16x9 --eye -3,2,4 --samples 16");
}

#[test]
fn render_reports_what_it_did() {
    let s = Sandbox::new();
    let json = s.ok("render box.obj -o box.png -r 64 --size 80x60 --samples 5 --json").json();
    has_keys(
        &json,
        "width height samples supersample supersampled rays.primary rays.shadow rays.secondary hits ms.trace ms.total effects \
         cost_ms.shadows cost_ms.secondary",
    );
    assert_eq!((&json["width"], &json["height"], &json["samples"]), (&80.into(), &60.into(), &5.into()));
    assert_eq!(json["rays"]["primary"], 80 * 60 * 5);
    let hits = json["hits"].as_u64().unwrap();
    assert!(hits > 80 * 60 * 5 / 20 && hits < 80 * 60 * 5, "the box fills a part of the picture: {hits}");
    assert!(json["effects"].is_array());
    // What is not called for takes no time.
    assert_eq!((&json["cost_ms"]["shadows"], &json["cost_ms"]["secondary"]), (&0.0.into(), &0.0.into()));
}

#[test]
fn shadows_fall_where_a_light_is_hidden() {
    let s = Sandbox::new();
    // Looks along -z at the fronts of an upper voxel, at the cube's border, and of a lower one, farther away.
    s.scene("two.vxd", GRID, &[([1, 2, 3], 1), ([1, 0, 1], 2)]);
    let render = |flags: &str| {
        let view = "--size 9x9 --eye 10.75,21,40 --target 10.75,21,32 --fov 14 --normals face --samples 1";
        let json = s.ok(&format!("render two.vxd -o two.png --json {view} {flags}")).json();
        let pixels = image::load_from_memory(&s.read("two.png")).unwrap().into_rgba8();
        (pixels.pixels().map(|p| p.0).collect::<Vec<_>>(), json)
    };
    const UPPER: usize = 3 * 9 + 4;
    const LOWER: usize = 7 * 9 + 4;
    // From above the upper voxel hides the lower one, from below it does not.
    for (light, hides) in [("--light 10.75,24.25,34", true), ("--light 10.75,18,36", false)] {
        let (lit, json) = render(light);
        assert_eq!((&json["rays"]["shadow"], json["effects"].as_array().unwrap().len()), (&0.into(), 0));
        let (found, json) = render(&format!("{light} --shadows"));
        assert!(json["rays"]["shadow"].as_u64() > Some(0) && json["effects"][0] == "shadows", "{json:#}");
        assert_eq!(found[UPPER], lit[UPPER], "{light}");
        assert_eq!(found[LOWER] != lit[LOWER], hides, "{light}");
        assert!(found.iter().zip(&lit).all(|(found, lit)| found[0] <= lit[0]));
        assert!(json["cost_ms"]["shadows"].as_f64() > Some(0.0) && json["cost_ms"]["secondary"] == 0.0, "{json:#}");
        // Sides need no lift.
        assert_eq!(render(&format!("{light} --shadows --lift 0")).0, found);
    }
    s.run("render two.vxd -o two.png --lift -1").fails(2, &["--lift", "0 to 16"]);
    // The default light casts shadows, too.
    assert!(render("--shadows").1["rays"]["shadow"].as_u64() > Some(0));
}

#[test]
fn effects_are_those_that_are_called_for_and_allowed() {
    let s = Sandbox::new();
    s.write("box.mtl", "newmtl red\nKd 0.8 0.1 0.1\nKs 0.3 0.3 0.3\nillum 3\nnewmtl blue\nKd 0.1 0.1 0.8\nd 0.5\n");
    s.ok("build box.obj -o box.vxd -r 64");
    let render = |flags: &str| {
        let json = s.ok(&format!("render box.vxd -o box.png --size 40x30 --json {flags}")).json();
        let names: Vec<_> = json["effects"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
        (names.join(" "), json["rays"]["secondary"].as_u64().unwrap(), s.read("box.png"))
    };
    let all = render("");
    assert_eq!(all.0, "specular mirror transparency");
    assert!(all.1 > 0);
    assert_eq!(render("--effects all"), all);
    assert_eq!(render("--effects=-emission,-shadows"), all);
    assert_eq!(render("--effects phong,+mirror,+transparency"), all);
    let phong = render("--effects phong");
    assert_eq!((&*phong.0, phong.1), ("specular", 0));
    assert_ne!(phong.2, all.2);
    let opaque = render("--effects -transparency --shadows");
    assert_eq!(opaque.0, "specular shadows mirror");
    assert!(opaque.1 > 0 && opaque.1 < all.1);
}

#[test]
fn supersampled_pixels_are_those_of_the_picture_with_all_samples() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 64");
    let render = |flags: &str| {
        let json = s.ok(&format!("render box.vxd -o box.png --size 40x30 --json {flags}")).json();
        let pixels = image::load_from_memory(&s.read("box.png")).unwrap().into_rgba8();
        (pixels.pixels().map(|p| p.0).collect::<Vec<_>>(), json)
    };
    let (one, _) = render("--samples 1");
    let (all, json) = render("--samples 16");
    assert_eq!((&json["supersample"], &json["supersampled"]), (&"all".into(), &1.0.into()));
    assert_eq!(render("--supersample all").0, all);
    for (which, typed) in
        [("near:0.4", "near:0.4"), ("region:3,4,30,21", "region:3,4,30,21"), ("adaptive", "adaptive:2")]
    {
        let (found, json) = render(&format!("--supersample {which}"));
        let (marked, _) = render(&format!("--supersample {which} --show samples"));
        assert_eq!((&json["supersample"], &json["samples"]), (&typed.into(), &16.into()));
        let mut chosen = 0;
        for i in 0..found.len() {
            if marked[i] != found[i] {
                assert_eq!((found[i], marked[i][0]), (all[i], 255), "{which}, pixel {i}");
                chosen += 1;
            } else if typed != "adaptive:2" {
                assert_eq!(found[i], one[i], "{which}, pixel {i}");
            }
        }
        assert!((50..1150).contains(&chosen), "{which}: {chosen} of 1200");
        assert_eq!(json["supersampled"], f64::from(chosen) / 1200.0);
        let rays = json["rays"]["primary"].as_u64().unwrap();
        let least = match typed {
            "near:0.4" => 1200 + 16 * chosen,
            "adaptive:2" => 4 * 1200 + 12 * chosen,
            _ => 1200 + 15 * chosen,
        };
        assert_eq!(rays, least as u64, "{which}");
        let text = s.ok(&format!("render box.vxd -o box.png --size 40x30 --supersample {which}")).stdout;
        assert!(
            text.contains(&format!("16 samples per pixel in {:.1} % of them ({typed})", f64::from(chosen) / 12.0)),
            "{text}"
        );
    }
    assert_eq!(render("--samples 1").1["supersampled"], 0.0);
}

#[test]
fn up_is_where_the_file_says() {
    let s = Sandbox::new();
    s.ok("build box.obj -o y.vxd -r 32");
    s.ok("build box.obj -o z.vxd -r 32 --up-axis z");
    s.ok("render y.vxd -o y.png --size 40x40");
    s.ok("render z.vxd -o z.png --size 40x40");
    assert_ne!(s.read("y.png"), s.read("z.png"));
    assert_eq!(s.ok("info z.vxd --json").json()["up_axis"], "z");
}

#[test]
fn verify_says_what_it_checked() {
    let s = Sandbox::new();
    for geometry in ["dag", "ssvdag"] {
        for (materials, check) in [("none", None), ("table", Some("table")), ("table-normals", Some("table"))]
            .into_iter()
            .chain([("tree", Some("tree")), ("ranked", Some("ranked"))])
        {
            s.ok(&format!("build box.obj -o box.vxd -r 50 --geometry {geometry} --materials {materials}"));
            let json = s.ok("verify box.vxd --json").json();
            assert_eq!(json["ok"], true);
            let checks = json["checks"].as_array().unwrap();
            let names: Vec<_> = checks.iter().map(|check| check["name"].as_str().unwrap()).collect();
            let expected = ["header", geometry, "materials"].into_iter().chain(check);
            assert_eq!(names, expected.collect::<Vec<_>>(), "{json:#}");
        }
    }
}

#[test]
fn a_missing_material_file_is_a_warning() {
    let s = Sandbox::new();
    s.write("lone.obj", OBJ.replace("box.mtl", "no-such.mtl"));
    let run = s.ok("build lone.obj -o lone.vxd -r 16");
    assert!(run.stderr.contains("warning: ") && run.stderr.contains("no-such.mtl"), "{}", run.stderr);
}

#[test]
fn files_are_found_beside_the_mesh_and_names_may_hold_spaces() {
    let s = Sandbox::new();
    std::fs::create_dir(s.path("my models")).unwrap();
    s.write("my models/a box.obj", OBJ);
    s.write("my models/box.mtl", common::MTL);
    let output = s.command("build").arg("my models/a box.obj").args(["-o", "a box.vxd", "-r", "9"]).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && !stderr.contains("warning"), "{stderr}");
    assert!(stderr.contains("render 'a box.vxd' -o 'a box.png'"), "{stderr}");
}

#[test]
fn the_demo_draws_its_picture() {
    let s = Sandbox::new();
    let run = s.ok("demo --json");
    let json = run.json();
    has_keys(
        &json,
        "triangles voxels octree_nodes octree_bricks nodes bricks bytes.file ms.total peak_rss_bytes picture",
    );
    assert!(s.read("voxdag-demo.png").starts_with(b"\x89PNG"));
    assert!(run.stderr.contains("next: "), "{}", run.stderr);
    assert_eq!(s.files(), ["box.mtl", "box.obj", "voxdag-demo.png"]);
}

/// From low above a floor of steps, lit at a slant.
#[test]
fn a_lift_takes_the_shadows_of_steps_away() {
    let s = Sandbox::new();
    s.write("floor.obj", "v 0 0 0\nv 10 1 0\nv 10 1 10\nv 0 0 10\nf 1 2 3 4\n");
    s.ok("build floor.obj -o floor.vxd -r 128");
    let darkest = |flags: &str| {
        let view = "--size 64x48 --samples 1 --sun=8,3,0.5 --ambient 0 --shadows";
        s.ok(&format!("render floor.vxd -o floor.png {view} {flags}"));
        let pixels = image::load_from_memory(&s.read("floor.png")).unwrap().into_rgba8();
        pixels.pixels().filter(|pixel| pixel.0[0] == 0).count()
    };
    // Where the floor ends normals lean.
    let lifted = darkest("--lift 1");
    assert!(lifted < 20 && darkest("") == lifted, "{lifted}");
    assert!(darkest("--lift 0") > 50 + lifted);
}
