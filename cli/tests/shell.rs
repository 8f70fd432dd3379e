//! The manners of the command line: help, completions, no colour and no progress where nobody sits.

mod common;
use common::Sandbox;

#[test]
fn help_names_every_command_flag_and_default() {
    let s = Sandbox::new();
    let all = s.ok("--help").stdout;
    for command in [
        "demo",
        "build",
        "render",
        "info",
        "verify",
        "cast",
        "export",
        "compare",
        "selftest",
        "completions",
        "Exit codes",
    ] {
        assert!(all.contains(command), "no `{command}` in\n{all}");
    }
    let build = s.ok("build --help").stdout;
    for word in ["-r, --resolution", "512", "--voxel-size", "--origin", "--cover", "exact", "thin", "inflated"]
        .into_iter()
        .chain(["--materials", "table-normals", "--up-axis", "--threads", "--memory-limit", "--json"])
    {
        assert!(build.contains(word), "no `{word}` in\n{build}");
    }
    let render = s.ok("render --help").stdout;
    for word in
        ["--size", "1280x720", "--eye", "--target", "--view-up", "--fov", "45", "--light", "--shadows", "--ambient"]
            .into_iter()
            .chain(["0.2", "--normals", "plane2", "--samples", "--arithmetic", "f64", "-r, --resolution"])
    {
        assert!(render.contains(word), "no `{word}` in\n{render}");
    }
    for word in [
        "--show",
        "iterations",
        "--depth-out",
        "--supersample",
        "adaptive[:DEGREES]",
        "ernerfeldt2",
        "--lod",
        "--budget",
    ] {
        assert!(render.contains(word), "no `{word}` in\n{render}");
    }
    let (cast, export) = (s.ok("cast --help").stdout, s.ok("export --help").stdout);
    for word in ["--rays", "--space", "world", "--arithmetic", "f32", "ox,oy,oz,dx,dy,dz", "face,material,nx,ny,nz"] {
        assert!(cast.contains(word), "no `{word}` in\n{cast}");
    }
    for word in ["--to", "binvox", "xyz", "npy", "uint32"] {
        assert!(export.contains(word), "no `{word}` in\n{export}");
    }
    // Nothing runs off an ordinary terminal but one line of examples.
    for help in [&all, &build, &render, &cast, &export] {
        assert_eq!(help.lines().find(|line| line.chars().count() > 120), None);
    }
}

#[test]
fn without_arguments_there_is_help_and_code_2() {
    let run = Sandbox::new().run("");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("Usage: voxdag"), "{}", run.stderr);
}

#[test]
fn every_shell_is_completed() {
    let s = Sandbox::new();
    for (shell, word) in [
        ("bash", "complete -F _voxdag"),
        ("zsh", "#compdef voxdag"),
        ("fish", "complete -c voxdag"),
        ("powershell", "Register-ArgumentCompleter"),
        ("elvish", "edit:completion"),
    ] {
        let run = s.ok(&format!("completions {shell}"));
        assert!(run.stdout.contains(word) && run.stdout.contains("memory-limit"), "{shell}");
    }
    s.run("completions csh").fails(2, &["bash"]);
}

#[test]
fn no_escape_codes_outside_a_terminal() {
    let s = Sandbox::new();
    for line in ["build box.obj -o box.vxd -r 20", "info box.vxd", "verify box.vxd", "info no-such", "build", "--help"]
    {
        let run = s.run(line);
        assert!(!run.stdout.contains('\x1b') && !run.stderr.contains('\x1b'), "{line}");
    }
}

#[test]
fn every_run_ends_with_the_next_command() {
    let s = Sandbox::new();
    s.write("rays.csv", "1,1,9,0,0,-1\n");
    for line in [
        "build box.obj -o box.vxd -r 20",
        "render box.vxd -o box.png --size 16x9",
        "render box.vxd -o box.png --size 16x9 --show depth",
        "info box.vxd",
        "verify box.vxd",
        "cast box.vxd --rays rays.csv",
        "export box.vxd --to xyz",
    ] {
        let run = s.ok(line);
        let last = run.stderr.lines().last().unwrap_or_default();
        let program = last.strip_prefix("next: ").and_then(|command| command.split(' ').next());
        assert_eq!(program, Some(env!("CARGO_BIN_EXE_voxdag")), "{line}: {last}");
    }
    // Through cargo it is cargo's command.
    let output = s.command("info box.vxd").env("CARGO_MANIFEST_DIR", "/work/voxdag/cli").output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("next: cargo run ") && stderr.contains(" -- render box.vxd -o box.png"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_failure() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 20");
    let line = format!("{} info box.vxd | true; echo ${{PIPESTATUS[0]}}", env!("CARGO_BIN_EXE_voxdag"));
    let output = std::process::Command::new("bash").args(["-c", &line]).current_dir(s.path("")).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "0");
}
