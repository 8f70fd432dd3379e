//! View files: the pictures are those of the flags that they stand for, frames those of their cameras.

mod common;
use common::Sandbox;

const VIEW: &str = "\
background = [0.1, 0.2, 0.3]
ambient = 0.1
[camera]
eye = [4, 3, 6]
target = [1, 0.5, 0.5]
up = [0.1, 1, 0]
fov = 40
[[light]]
point = [2, 3, 4]
color = [1, 0.9, 0.8]
[[light]]
direction = [-1, 2, 0.5]
";

const FLAGS: &str = "--background 0.1,0.2,0.3 --ambient 0.1 --eye 4,3,6 --target 1,0.5,0.5 --view-up 0.1,1,0 --fov 40 \
                     --light 2,3,4,1,0.9,0.8 --sun=-1,2,0.5";

/// A folder with `box.vxd`.
fn sandbox() -> Sandbox {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 32");
    s
}

/// The picture of `box.vxd` with these flags.
fn picture(s: &Sandbox, flags: &str) -> Vec<u8> {
    s.ok(&format!("render box.vxd -o picture.png --size 48x27 {flags}"));
    s.read("picture.png")
}

#[test]
fn a_view_is_the_flags_that_it_stands_for() {
    let s = sandbox();
    s.write("view.toml", VIEW);
    let flags = picture(&s, FLAGS);
    assert_eq!(picture(&s, "--view view.toml"), flags);
    assert_ne!(picture(&s, ""), flags);

    // Each of these flags wins over the file, and alone.
    for flag in ["--eye 5,3,6", "--target 1,0,0", "--view-up 1,1,1", "--fov 50", "--ambient 0", "--background 1"] {
        let won = picture(&s, &format!("--view view.toml {flag}"));
        assert_ne!(won, flags, "{flag}");
        let name = flag.split(' ').next().unwrap();
        let rest: Vec<_> = FLAGS.split_whitespace().collect();
        let at = rest.iter().position(|word| *word == name).unwrap();
        let rest = [&rest[..at], &rest[at + 2..]].concat().join(" ");
        assert_eq!(won, picture(&s, &format!("{rest} {flag}")), "{flag}");
    }
    // So does a set of effects.
    s.write("phong.toml", format!("effects = \"phong\"\n{VIEW}"));
    for (flags, set) in [("", "phong"), ("--effects auto", "auto"), ("--effects=-specular", "-specular")] {
        let found = picture(&s, &format!("--view phong.toml --shadows {flags}"));
        assert_eq!(found, picture(&s, &format!("{FLAGS} --shadows --effects={set}")), "{flags}");
    }
    assert_ne!(picture(&s, "--view phong.toml --shadows"), picture(&s, "--view view.toml --shadows"));
    // Lights replace lights.
    let (camera, _) = FLAGS.split_once("--light").unwrap();
    assert_eq!(picture(&s, "--view view.toml --sun 1,0,1"), picture(&s, &format!("{camera} --sun 1,0,1")));

    // Rays of a measurement are those from there.
    let hits = |flags: &str| {
        let run = s.ok(&format!("bench trace box.vxd --size 48x27 --repeat 1 --json {flags}"));
        run.json()["primary"]["hit_fraction"].as_f64().unwrap()
    };
    assert_eq!(hits("--view view.toml"), hits("--eye 4,3,6 --target 1,0.5,0.5 --view-up 0.1,1,0 --fov 40"));
    assert_ne!(hits("--view view.toml"), hits(""));
}

#[test]
fn an_area_is_its_points_and_each_light_has_its_own_shadow() {
    let s = sandbox();
    let area = |corner: &str, samples: u32, shadow: bool| {
        format!(
            "[camera]\neye = [4, 3, 6]\n[[light]]\ncolor = [1, 0.5, 2]\nshadow = {shadow}\n\
             area = {{ corner = {corner}, edges = [[2, 0, 0], [0, 0, 4]], samples = {samples} }}\n"
        )
    };
    s.write("one.toml", area("[1, 5, 0]", 1, false));
    assert_eq!(picture(&s, "--view one.toml"), picture(&s, "--eye 4,3,6 --light 2,5,2,1,0.5,2"));
    s.write("four.toml", area("[1, 5, 0]", 4, true));
    let points = [[1.5, 1.0], [2.5, 1.0], [1.5, 3.0], [2.5, 3.0]];
    let points = points.map(|[x, z]| format!("--light {x},5,{z},0.25,0.125,0.5")).join(" ");
    let shadows = picture(&s, &format!("--eye 4,3,6 --shadows {points}"));
    assert_eq!(picture(&s, "--view four.toml"), shadows);

    // Rays towards the one that casts shadows, to none, to both.
    let rays = |shadows: [bool; 2], flags: &str| {
        let [a, b] = shadows;
        let lights =
            format!("[[light]]\npoint = [2, 5, 2]\nshadow = {a}\n[[light]]\ndirection = [0, 1, 2]\nshadow = {b}\n");
        s.write("two.toml", lights);
        let run = s.ok(&format!("render box.vxd -o picture.png --size 48x27 --view two.toml --json {flags}"));
        run.json()["rays"]["shadow"].as_u64().unwrap()
    };
    let [none, first, second, both] =
        [[false; 2], [true, false], [false, true], [true; 2]].map(|lights| rays(lights, ""));
    assert_eq!((none, first + second), (0, both));
    assert!(first > 0 && second > 0);
    assert_eq!(rays([false; 2], "--shadows"), both);
}

#[test]
fn frames_are_pictures_along_the_path() {
    let s = sandbox();
    let path = "[[path]]\nframe = 1\neye = [4, 3, 6]\n[[path]]\nframe = 3\neye = [6, 3, 3]\nfov = 50\n\
                [[path]]\nframe = 5\neye = [5, 1, -4]\nfov = 30\n";
    s.write("tour.toml", format!("{VIEW}{path}"));
    let still = picture(&s, "--view tour.toml");
    let run = s.ok("render box.vxd -o a.png --depth-out d.pfm --size 48x27 --view tour.toml --frames 1-3 --json");
    // A key's frame is the picture from there; so is one between, on the curve.
    let keys = ["--fov 50", "--eye 5.1875,3.125,4.75 --fov 50", "--eye 6,3,3 --fov 50"];
    for (i, flags) in keys.into_iter().enumerate() {
        assert_eq!(
            s.read(&format!("a_000{}.png", i + 1)),
            picture(&s, &format!("--view tour.toml {flags}")),
            "{flags}"
        );
    }
    assert_ne!(s.read("a_0001.png"), still);
    picture(&s, "--view tour.toml --eye 6,3,3 --fov 50 --depth-out one.pfm");
    assert_eq!(s.read("d_0003.pfm"), s.read("one.pfm"));
    assert!(!s.path("a.png").exists() && !s.path("a_0004.png").exists() && !s.path("d.pfm").exists());

    // The report has each frame and the sums.
    let report = run.json();
    let frames = report["frames"].as_array().unwrap();
    assert_eq!(frames.iter().map(|frame| frame["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2, 3]);
    assert_eq!(frames[2]["file"], "a_0003.png");
    let hits = frames.iter().map(|frame| frame["hits"].as_u64().unwrap());
    assert_eq!(report["hits"].as_u64().unwrap(), hits.sum::<u64>());
    assert_eq!(report["rays"]["primary"], 3 * 4 * 48 * 27);

    // Other pictures, a level of detail and a mesh have frames, too; a flag holds for all of them.
    s.ok("render box.vxd -o n.png --size 48x27 --view tour.toml --frames 5 --show normals --lod 1");
    s.ok("render box.vxd -o picture.png --size 48x27 --view tour.toml --eye 5,1,-4 --fov 30 --show normals --lod 1");
    assert_eq!(s.read("n_0005.png"), s.read("picture.png"));
    s.ok("render box.obj -r 32 -o m.png --size 48x27 --view tour.toml --frames 3-4 --eye 4,3,6 --fov 40");
    assert_eq!((s.read("m_0003.png"), s.read("m_0004.png")), (still.clone(), still));
}

#[test]
fn what_is_wrong_is_refused_before_anything_is_drawn() {
    let s = sandbox();
    s.write("bad.toml", "[camera]\nfov = 45\n[[light]]\npoint = [1, 2]\n");
    s.write("bytes.toml", b"ambient = 1\n\xff");
    s.write("still.toml", VIEW);
    s.write("tour.toml", "[[path]]\nframe = 5\neye = [4, 3, 6]\n[[path]]\nframe = 9\neye = [5, 3, 6]\n");
    let through =
        "[camera]\ntarget = [0, 0, 0]\n[[path]]\nframe = 1\neye = [-1, 0, 0]\n[[path]]\nframe = 3\neye = [1, 0, 0]\n";
    s.write("through.toml", through);
    let wide = "[[path]]\nframe = 1\nfov = 10\n[[path]]\nframe = 2\nfov = 179\n[[path]]\nframe = 4\nfov = 179\n";
    s.write("wide.toml", wide);
    std::fs::create_dir(s.path("taken_0002.png")).unwrap();
    let before = s.files();
    let view = |rest: &str| format!("render box.vxd -o out.png --size 16x9 --view {rest}");
    for (line, code, words) in [
        (view("bad.toml"), 3, &["bad.toml:4: light 1: point: expected three numbers", "hint: see docs/view.md"][..]),
        (view("bytes.toml"), 3, &["bytes.toml:2: expected UTF-8"]),
        (view("no.toml"), 3, &["no.toml", "no such file"]),
        (view("."), 3, &["folder"]),
        (view("through.toml --frames 1-3"), 3, &["through.toml: frame 2: ", "same point", "hint: "]),
        (view("wide.toml --frames 1-4"), 3, &["wide.toml: frame 3: ", "field of view", "hint: "]),
        (view("still.toml --eye 1,0.5,0.5"), 2, &["same point", "--eye"]),
        (view("still.toml --frames 1-3"), 2, &["--frames 1-3: there is no camera path", "--view"]),
        (view("tour.toml --frames 4-9"), 2, &["frames 5 to 9", "try --frames 5-9"]),
        (view("tour.toml --frames 9-10"), 2, &["frames 5 to 9"]),
        (view("tour.toml --frames 9-5"), 2, &["5-9"]),
        (view("tour.toml --frames 0-5"), 2, &["each 1 to 9999"]),
        ("render box.vxd -o out.png --frames 1-3".to_owned(), 2, &["there is no camera path"]),
        ("render box.vxd -o taken.png --view wide.toml --frames 1-2".to_owned(), 1, &["taken_0002.png"]),
        ("render box.vxd -o out.png --sun 0,0,0".to_owned(), 2, &["direction"]),
        ("render box.vxd -o out.png --background 1,2".to_owned(), 2, &["one number or three"]),
        ("bench trace box.vxd --view bad.toml".to_owned(), 3, &["bad.toml:4"]),
        ("accuracy box.obj --view bad.toml".to_owned(), 3, &["bad.toml:4"]),
    ] {
        s.run(&line).fails(code, words);
    }
    assert_eq!(s.files(), before);
}

/// The example of docs/view.md, and the commands beside it.
#[test]
fn the_documented_example_is_drawn() {
    let s = sandbox();
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/view.md")).unwrap();
    let example = text.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    s.write("view.toml", example);
    let commands: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("voxdag ")).collect();
    assert_eq!(commands.len(), 2);
    for command in commands {
        let run = s.ok(&format!("{command} --size 32x18 --json"));
        let hits = run.json()["hits"].as_u64().unwrap();
        assert!(hits > 100 && hits < run.json()["rays"]["primary"].as_u64().unwrap(), "{command}: {hits}");
    }
    assert!(s.path("box.png").exists() && s.path("box_0048.png").exists() && !s.path("box_0049.png").exists());
    // Every key has its line in the tables.
    for key in ["ambient", "background", "eye", "target", "up", "fov", "point", "direction", "area", "color", "shadow"]
        .into_iter()
        .chain(["corner", "edges", "samples", "frame"])
    {
        assert!(text.lines().any(|line| line.starts_with('|') && line.contains(&format!("`{key}`"))), "{key}");
    }
}
