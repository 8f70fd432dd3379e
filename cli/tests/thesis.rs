//! `thesis` on a small mesh: every table, picture and page is there, and says what it should.

mod common;
use common::Sandbox;

#[test]
fn tables_pictures_and_pages_are_written() {
    let s = Sandbox::new();
    // A name that no table, link or page must trip over.
    std::fs::rename(s.path("box.obj"), s.path("b\u{fc}x<|b>.obj")).unwrap();
    let run = s.ok("thesis b\u{fc}x<|b>.obj -r 32,16,32 --runs 2 --size 48x32 -o out");
    assert!(run.stdout.contains("90 combinations of layout, materials and normals: equal pictures"), "{}", run.stdout);
    assert!(run.stderr.contains("next: "), "{}", run.stderr);

    let text = String::from_utf8(s.read("out/report.md")).unwrap();
    for number in ["5.1", "5.2a", "5.2b", "5.3", "5.4", "5.5", "5.6", "5.7", "5.8"] {
        assert!(text.contains(&format!("\n## Table {number}: ")), "{number}\n{text}");
    }
    assert!(text.contains("| b\u{fc}x<\\|b> | triangles | 12 |"), "{text}");
    assert!(text.contains("| 16^3 | 32^3 |") && !text.contains("they differ"), "{text}");

    // A line per number, and as many numbers of a configuration as resolutions.
    let table = s.read("out/tables.csv");
    let mut rows = csv::Reader::from_reader(&table[..]);
    assert_eq!(
        rows.headers().unwrap().iter().collect::<Vec<_>>().join(","),
        "table,scene,configuration,resolution,unit,value,min,max,published"
    );
    let rows: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
    let find = |number: &str, configuration: &str, resolution: &str| {
        let found: Vec<f64> = rows
            .iter()
            .filter(|row| [&row[0], &row[2], &row[3]] == [number, configuration, resolution])
            .map(|row| row[5].parse().unwrap())
            .collect();
        assert_eq!(found.len(), 1, "{number} {configuration} {resolution}");
        found[0]
    };
    let json: serde_json::Value = serde_json::from_slice(&s.read("out/report.json")).unwrap();
    for resolution in ["16", "32"] {
        let voxels = find("A.6", "filled voxels", resolution);
        assert_eq!(find("5.2b", "hash table", resolution), voxels * 24.0 / 1048576.0);
        assert_eq!(find("5.2b", "moxel table", resolution), voxels * 16.0 / 1048576.0);
        assert_eq!(find("5.6", "hash table without normals", resolution), voxels * 12.0 / 1048576.0);
        for configuration in ["1 sample", "16 samples", "16 samples on the nearer half", "16 samples, adaptive"] {
            assert!(find("5.8", configuration, resolution) > 0.0);
        }
        // At most all samples and the centre's ray.
        let share = find("A.1", "16 samples on the nearer half", resolution);
        assert!(share > 0.0 && share <= 100.0 * 17.0 / 16.0, "{share}");
    }
    assert!(json["agreements"].as_array().unwrap().iter().all(|a| a["equal"] == true && a["combinations"] == 45));

    // Pictures are those that the report shows, and the survey holds its own.
    for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
        let picture = image::load_from_memory(&s.read(&format!("out/{link}"))).unwrap();
        assert_eq!((picture.width(), picture.height()), (48, 32), "{link}");
        assert!(link.starts_with("pictures/b_x__b_-"), "{link}");
    }
    // The view is told as flags, and they draw the same picture.
    let flags = text.split("`render ").nth(1).unwrap().split('`').next().unwrap().to_owned();
    std::fs::rename(s.path("b\u{fc}x<|b>.obj"), s.path("box.obj")).unwrap();
    s.ok(&format!("render box.obj -r 32 --materials table --normals ernerfeldt2 --samples 16 {flags} -o again.png"));
    assert_eq!(s.read("again.png"), s.read("out/pictures/b_x__b_-16-samples.png"));
    let survey = String::from_utf8(s.read("out/survey.html")).unwrap();
    assert_eq!(survey.matches("data:image/png;base64,").count(), 5);
    assert!(survey.contains("b\u{fc}x\\u003c|b>") && !survey.contains("__DATA__"));
    assert!(s.read("out/tally.html").starts_with(b"<!doctype html>"));
}

#[test]
fn what_cannot_be_measured_is_said_beforehand() {
    let s = Sandbox::new();
    std::fs::create_dir(s.path("b")).unwrap();
    s.write("b/box.obj", common::OBJ);
    s.run("thesis box.obj b/box.obj").fails(2, &["two scenes of the name box", "rename one"]);
    s.run("thesis box.obj --runs 0").fails(2, &["--runs", "0"]);
    s.run("thesis box.obj missing.obj").fails(3, &["missing.obj", "no such file"]);
    s.run("thesis box.obj -r 64,").fails(2, &["--resolution", "256,512"]);
    s.write("taken", "");
    s.run("thesis box.obj -o taken").fails(1, &["taken"]);
    assert!(!s.files().contains(&"voxdag-thesis".to_owned()), "{:?}", s.files());
}
