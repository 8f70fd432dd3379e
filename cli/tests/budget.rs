//! `render --budget` and `--target-error`: what they say, and that what they chose can be typed. How well they meet a time
//! is for `docs/performance.md`: no test can know what else runs on its machine.

mod common;
use common::Sandbox;

#[test]
fn what_was_chosen_can_be_typed() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 64");
    for (goal, file) in
        [("--budget 1ms", "box.vxd"), ("--budget 20ms", "box.vxd"), ("--target-error 0.01", "box.obj -r 64")]
    {
        let flags = "--size 160x120 --normals face --threads 2";
        let json = s.ok(&format!("render {file} -o chosen.png {flags} {goal} --json")).json();
        let chosen = &json["chosen"];
        let number = |key: &str| chosen[key].as_f64().unwrap_or_else(|| panic!("{key} in {json:#}"));
        assert!(number("expected_ms") > 0.0 && number("calibration_ms") > 0.0);
        assert_eq!(number("got_ms"), json["ms"]["trace"].as_f64().unwrap());
        let error = number("expected_error");
        match goal.split_once(' ').unwrap() {
            ("--budget", time) => {
                assert_eq!(format!("{}ms", number("budget_ms")), time);
                assert!(chosen["target_error"].is_null() && (0.0..0.5).contains(&error));
            }
            _ => assert!(chosen["budget_ms"].is_null() && error <= number("target_error"), "{json:#}"),
        }
        let typed = chosen["flags"].as_str().unwrap();
        assert!(typed.contains("--samples") && typed.contains("--normals face"), "{typed}");
        let again = s.ok(&format!("render box.vxd -o typed.png --size 160x120 {typed} --json")).json();
        assert!(s.read("typed.png") == s.read("chosen.png"), "{typed}");
        for key in ["samples", "supersample", "supersampled", "lod", "rays", "hits"] {
            assert_eq!(again[key], json[key], "{key} of {typed}");
        }
        assert!(again["chosen"].is_null());
    }
}

#[test]
fn the_choice_is_told_to_people() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 64");
    let run = s.ok("render box.vxd -o a.png --size 40x30 --budget 500s");
    assert!(run.stderr.contains("info box.vxd"), "{}", run.stderr);
    let told = run.stdout;
    for words in
        ["chosen ", "for 500.0 s; the most accurate setting takes only ", "expected ", "error 0.0", "calibration "]
    {
        assert!(told.contains(words), "no `{words}` in\n{told}");
    }
}

#[test]
fn a_choice_leaves_nothing_to_choose() {
    let s = Sandbox::new();
    for goal in ["--budget 1s", "--target-error 0.01"] {
        for given in ["--samples 4", "--supersample near", "--lod 1", "--lod 0"] {
            let refused = s.run(&format!("render box.obj -o a.png {goal} {given}"));
            assert!(refused.code == 2 && refused.stderr.contains("cannot be used with"), "{}", refused.stderr);
        }
        let refused = s.run(&format!("render box.obj -r 8 -o a.png {goal} --show depth"));
        assert!(refused.code == 2 && refused.stderr.contains("leave --show away"), "{}", refused.stderr);
    }
    let refused = s.run("render box.obj -o a.png --budget 1s --target-error 0.1");
    assert!(refused.code == 2 && refused.stderr.contains("cannot be used with"), "{}", refused.stderr);
    for (wrong, expected) in [("--budget 100", "100ms or 1.5s"), ("--target-error 0.0001", "0.001 (what 8 bits cost)")]
    {
        let refused = s.run(&format!("render box.obj -o a.png {wrong}"));
        assert!(refused.code == 2 && refused.stderr.contains(expected), "{}", refused.stderr);
    }
}
