//! `voxdag selftest` says what it tried and who was wrong.

mod common;
use common::Sandbox;

#[test]
fn the_table_and_its_json() {
    let s = Sandbox::new();
    let json = s.ok("selftest --json").json();
    assert_eq!((&json["ok"], &json["long"]), (&true.into(), &false.into()));
    let cases = json["cases"].as_array().unwrap();
    let mut wrong = [0; 3];
    for case in cases {
        assert!(case["tried"].as_u64().is_some_and(|n| n > 50), "{case:#}");
        assert!(case["first"].is_null(), "{case:#}");
        for (sum, method) in wrong.iter_mut().zip(["f32", "f64", "ours"]) {
            *sum += case["wrong"][method].as_u64().unwrap();
        }
    }
    assert!(wrong[0] > wrong[1] && wrong[1] > 0 && wrong[2] == 0, "{wrong:?}");
    for group in ["overlap", "rays", "leaks", "normals"] {
        assert!(cases.iter().any(|case| case["group"] == group), "{group}");
    }
    // A thousand rays for leaks.
    let leaks = cases.iter().filter(|case| case["group"] == "leaks").map(|case| case["tried"].as_u64().unwrap());
    assert_eq!(leaks.sum::<u64>(), 1024);
}
