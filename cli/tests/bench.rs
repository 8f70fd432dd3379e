//! `voxdag bench` measures what it says: every subject runs, its report has its keys, and what does not depend on the
//! machine is right.

mod common;
use common::Sandbox;
use serde_json::Value;
use voxdag::demo;
use voxdag::simd::Level;

/// The number at a path (dots go down); it is there, finite and not negative.
fn number(value: &Value, path: &str) -> f64 {
    let found = path.split('.').try_fold(value, |v, key| v.get(key));
    let number = found.and_then(Value::as_f64).unwrap_or_else(|| panic!("no number `{path}` in {value:#}"));
    assert!(number.is_finite() && number >= 0.0, "{path}: {number}");
    number
}

/// Each of the numbers is greater than 0.
fn positive(value: &Value, paths: &str) {
    for path in paths.split_whitespace() {
        assert!(number(value, path) > 0.0, "{path} is 0 in {value:#}");
    }
}

/// A floor of 8 x 8, seen from above.
const FLOOR: &str = "v 0 0 0\nv 8 0 0\nv 8 0 8\nv 0 0 8\nf 4 3 2 1\n";
/// From 8 above its middle: the picture is as high as the floor is wide at this field of view, and as wide.
const ABOVE: &str = "--eye 4,8.0625,4 --target 4,0,4 --view-up 0,0,-1 --fov 53.13010235415598";

#[test]
fn trace_counts_rays_and_hits() {
    let s = Sandbox::new();
    s.write("floor.obj", FLOOR);
    let flags = format!("{ABOVE} --size 64x32 --repeat 2");
    let json = s.ok(&format!("bench trace floor.obj -r 128 {flags} --json")).json();
    positive(
        &json,
        "primary.mrays_per_s primary.mrays_per_s_min primary.mrays_per_s_max primary_no_top.mrays_per_s \
         primary_one.mrays_per_s primary_f64.mrays_per_s primary_any.mrays_per_s shadow.mrays_per_s \
         shadow_one.mrays_per_s random.mrays_per_s random_one.mrays_per_s iterations_per_ray \
         iterations_per_ray_no_top exact_to_f64 any_to_nearest noise top_grid.bytes",
    );
    let rate = |key: &str| number(&json, &format!("primary.mrays_per_s{key}"));
    assert!(rate("_min") <= rate("") && rate("") <= rate("_max"));
    assert_eq!(number(&json, "primary.rays"), 64.0 * 32.0);
    // The floor is a square in the middle of a picture that is twice as wide as high: half of the rays.
    for kind in ["primary", "primary_one", "primary_no_top", "primary_f64", "primary_any"] {
        assert_eq!(number(&json, &format!("{kind}.hit_fraction")), 0.5, "{kind}");
    }
    // Nothing stands between the floor and the light, and a ray that leaves a floor never comes back to it.
    assert_eq!(number(&json, "shadow.rays"), 64.0 * 16.0);
    assert_eq!(number(&json, "shadow.hit_fraction"), 0.0);
    // Of random rays those that head downwards meet the floor at once.
    assert!((number(&json, "random.hit_fraction") - 0.5).abs() < 0.06, "{json:#}");
    // The same results with and without the top grid, on any number of threads, from the mesh or from its scene.
    assert_eq!(json["primary"]["checksum"], json["primary_no_top"]["checksum"]);
    s.ok("build floor.obj -o floor.vxd -r 128");
    let scene = s.ok(&format!("bench trace floor.vxd {flags} --threads 2 --json")).json();
    for key in ["primary", "primary_any", "shadow", "random"] {
        assert_eq!(json[key]["checksum"], scene[key]["checksum"], "{key}");
    }
    assert_eq!(scene["threads"], 2);
    let text = s.ok(&format!("bench trace floor.vxd {flags}")).stdout;
    for word in ["level", "primary", "one by one", "shadow", "random", "Mrays/s", "iterations", "noise"] {
        assert!(text.contains(word), "no `{word}` in\n{text}");
    }
}

/// Rays, hits and checksum of a row.
fn found<'a>(json: &'a Value, key: &str) -> [&'a Value; 3] {
    ["rays", "hit_fraction", "checksum"].map(|of| json[key].get(of).unwrap_or_else(|| panic!("no {key}.{of}")))
}

#[test]
fn every_level_finds_the_same() {
    let s = Sandbox::new();
    s.write("demo.obj", demo::obj());
    s.write(demo::MTL_NAME, demo::mtl());
    // Pictures that tiles do not divide, and octrees of even and of odd depth.
    for (resolution, size) in [(64, "83x50"), (128, "170x35")] {
        s.ok(&format!("build demo.obj -o demo.vxd -r {resolution}"));
        let run = |level: &str| s.ok(&format!("bench trace demo.vxd --size {size} --repeat 1 --json {level}")).json();
        let scalar = run("--level scalar");
        assert_eq!((&scalar["level"], &scalar["primary_f32"]), (&"scalar".into(), &Value::Null));
        assert_eq!(scalar["wide_tree"], Value::Null);
        let mut previews = Vec::new();
        for level in Level::all().map(Level::name) {
            let json = run(&format!("--level {level}"));
            assert_eq!(json["level"], level);
            for kind in ["primary", "shadow", "random"] {
                let one = format!("{kind}_one");
                for (key, other) in [(kind, &json), (&one, &json), (kind, &scalar), (&one, &scalar)] {
                    assert_eq!(found(&json, kind), found(other, key), "{kind}, {level}, {resolution}^3");
                }
            }
            // A preview, but a good one, and the same everywhere.
            positive(&json, "primary_f32.mrays_per_s wide_tree.bytes wide_tree.ms");
            assert!(number(&json, "primary_f32.differing_fraction") < 0.01, "{json:#}");
            previews.push((json["primary_f32"]["checksum"].clone(), json["primary_f32"]["differing_fraction"].clone()));
        }
        assert!(previews.windows(2).all(|two| two[0] == two[1]), "{previews:?}");
        // The widest is what counts if nobody says otherwise.
        assert_eq!(run("")["level"], Level::all().last().map_or("scalar", Level::name));
    }
    s.run("bench trace demo.vxd --level x87").fails(2, &["--level", "x87", "scalar"]);
}

const SMALL: &str = "--size 32x24 --repeat 1 --json";

#[test]
fn normals_of_every_kind() {
    let s = Sandbox::new();
    let json = s.ok(&format!("bench normals box.obj -r 64 {SMALL}")).json();
    positive(
        &json,
        "hits face.ns face.ns_min face.ns_max gradient.ns plane1.ns plane2.ns plane3.ns ernerfeldt1.ns ernerfeldt2.ns",
    );
    assert_eq!(json["stored"], Value::Null);
    assert_ne!(json["face"]["checksum"], json["plane3"]["checksum"]);
    // In batches they are the same.
    for batches in json["batches"].as_array().unwrap() {
        for kind in ["gradient", "plane1", "plane2", "plane3"] {
            assert_eq!(batches[kind]["checksum"], json[kind]["checksum"], "{kind}, vectors: {}", batches["level"]);
        }
    }
    let json = s.ok(&format!("bench normals box.obj -r 64 --materials table-normals {SMALL}")).json();
    positive(&json, "stored.ns");
}

#[test]
fn materials_of_every_kind() {
    let s = Sandbox::new();
    for (materials, kind) in [("none", "single"), ("table", "table"), ("table-normals", "table")] {
        let json = s.ok(&format!("bench materials box.obj -r 64 --materials {materials} {SMALL}")).json();
        positive(&json, "voxels hits.ns scattered.ns");
        assert_eq!(json["kind"], kind);
        if kind == "table" {
            let (mean, max) = (number(&json, "probes.mean"), number(&json, "probes.max"));
            // At half load a look-up reads 1.5 slots on average.
            assert!((1.4..1.6).contains(&mean) && max >= 2.0, "{mean} {max}");
        }
    }
}

#[test]
fn ranks_by_every_scheme() {
    let s = Sandbox::new();
    let json = s.ok(&format!("bench ranks box.obj -r 64 {SMALL}")).json();
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 7);
    for row in rows {
        positive(row, "bytes hits.ns scattered.ns");
        let bits = 8.0 * number(row, "bytes") / number(&json, "voxels");
        assert!((number(row, "bits_per_voxel") - bits).abs() < 1e-9, "{row:#}");
    }
    // The sums of all ranks, and of all materials, do not depend on the scheme.
    for sums in [&rows[..3], &rows[3..]] {
        for row in sums {
            assert_eq!(row["hits"]["checksum"], sums[0]["hits"]["checksum"], "{row:#}");
            assert_eq!(row["scattered"]["checksum"], sums[0]["scattered"]["checksum"], "{row:#}");
        }
    }
    // The octahedral normals of a moxel table double it.
    let with = s.ok(&format!("bench ranks box.obj -r 64 --materials table-normals {SMALL}")).json();
    let words = |json: &Value| number(&json["rows"][5], "bytes") / 4.0 - 4.0;
    assert_eq!(words(&with), 2.0 * words(&json));
}

#[test]
fn build_by_stage() {
    let s = Sandbox::new();
    let json = s.ok("bench build box.obj -r 100 --repeat 1 --json").json();
    positive(
        &json,
        "snap_sort.mvoxels_per_s voxelize.mvoxels_per_s reduce.mvoxels_per_s join.mvoxels_per_s total.mvoxels_per_s \
         voxelize.ms voxelize.ms_min voxelize.ms_max",
    );
    assert!(json["materials"]["ms"].is_number());
    let built = s.ok("build box.obj -o box.vxd -r 100 --json").json();
    assert_eq!(json["voxels"], built["voxels"]);
    assert_eq!(s.ok("bench build box.obj --materials none --repeat 1 --json").json()["materials"], Value::Null);
    s.run("bench build box.vxd").fails(2, &["box.vxd", "is built already"]);
}

#[test]
fn accuracy_of_the_textbook_methods() {
    let s = Sandbox::new();
    let json = s.ok(&format!("bench accuracy box.obj -r 100 {SMALL}")).json();
    positive(&json, "overlap.tests overlap.f32.ns overlap.f64.ns overlap.exact.ns tracing.f32.ns tracing.f64.ns");
    assert_eq!(
        number(&json, "overlap.voxels"),
        number(&s.ok("bench build box.obj -r 100 --repeat 1 --json").json(), "voxels")
    );
    // Exact on both sides, and f64 misses nothing: its products of snapped coordinates are exact at this size. What is
    // only touched it marks in addition.
    for path in ["overlap.exact.wrong", "overlap.f64.missing", "tracing.exact.wrong"] {
        assert_eq!(number(&json, path), 0.0, "{path}");
    }
    assert!(number(&json, "overlap.f64.extra") > 0.0);
    // The known accuracy of fitted normals.
    let known =
        [("face", 60.0), ("plane1", 9.0), ("plane2", 4.0), ("plane3", 2.5), ("ernerfeldt1", 9.0), ("ernerfeldt2", 4.0)];
    for (kind, below) in known {
        for shape in ["sphere", "plane", "torus"] {
            let degrees = number(&json, &format!("normals.{kind}.{shape}"));
            assert!(degrees > 0.0 && degrees < below, "{kind} {shape}: {degrees}");
        }
    }
    // A scene without its mesh has no triangles to compare.
    s.ok("build box.obj -o box.vxd -r 100");
    let json = s.ok(&format!("bench accuracy box.vxd {SMALL}")).json();
    assert_eq!(json["overlap"], Value::Null);
}

#[test]
fn effects_by_kernel_and_one_by_one() {
    let s = Sandbox::new();
    let json = s.ok(&format!("bench effects studio -r 64 {SMALL}")).json();
    positive(&json, "auto.ns named_to_auto full_to_auto all_to_auto noise shadows.added_to_any_hit shadows.any_hit_ms");
    assert_eq!((&json["kernel"], &json["same_bytes"]), (&"full".into(), &true.into()));
    let names = ["specular", "shadows", "mirror", "transparency", "refraction", "emission"];
    assert_eq!(json["effects"], serde_json::json!(names));
    for (row, name) in json["by_effect"].as_array().unwrap().iter().zip(names) {
        assert_eq!(row["effect"], name);
        let zero = |kind: &str| row["rays_without"][kind] == 0;
        assert_eq!((zero("shadow"), zero("primary"), zero("secondary")), (name == "shadows", false, false));
    }
    // Its rays are all that the renderer counts.
    let plain = s.ok(&format!("bench effects box.obj -r 64 {SMALL}")).json();
    assert_eq!((&plain["kernel"], &plain["same_bytes"]), (&"phong".into(), &true.into()));
    assert_eq!(plain["shadows"]["rays"], plain["by_effect"][0]["rays"]["shadow"]);
    let casting = s.ok(&format!("bench effects box.obj -r 64 --shadows {SMALL}")).json();
    assert_eq!(
        (&casting["kernel"], &casting["effects"]),
        (&"shadows".into(), &serde_json::json!(["specular", "shadows"]))
    );
}

#[test]
fn what_cannot_be_measured() {
    let s = Sandbox::new();
    s.run("bench trace box.obj -r 16 --eye 9,9,9 --target 10,10,10").fails(2, &["no ray", "--eye"]);
    s.ok("build box.obj -o box.vxd -r 16");
    s.run("bench trace box.vxd -r 16").fails(2, &["--resolution", "is built already"]);
    s.run("bench trace box.obj --repeat 0").fails(2, &["--repeat"]);
    s.run("bench trace none.obj").fails(3, &["none.obj"]);
}
