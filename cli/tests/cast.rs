//! `voxdag cast` on scenes whose answers are known.

mod common;
use common::{GRID, Sandbox};

const HEADER: &str = "hit,t,x,y,z,face,material,nx,ny,nz";
const MISS: &str = "0,,,,,,,,,";

/// With one voxel, from (10.5, 21, 31.5) to (11, 21.5, 32) in the world.
fn one_voxel() -> Sandbox {
    let s = Sandbox::new();
    s.scene("one.vxd", GRID, &[([1, 2, 3], 1)]);
    s
}

/// The lines after the header of what `cast one.vxd FLAGS` makes of some rays.
fn hits(s: &Sandbox, rays: &str, flags: &str) -> Vec<String> {
    s.write("rays.csv", rays);
    let out = s.ok(&format!("cast one.vxd --rays rays.csv {flags}")).stdout;
    let (header, lines) = out.split_once('\n').unwrap();
    assert_eq!(header, HEADER);
    lines.lines().map(str::to_owned).collect()
}

#[test]
fn every_face_is_hit_at_its_time() {
    let s = one_voxel();
    for (ray, hit) in [
        ("10.75,21.25,40,0,0,-2", "1,4.0000000000000000e0,1,2,3,+z,1,0,0,1"),
        ("10.75,21.25,29.5,0,0,0.5", "1,4.0000000000000000e0,1,2,3,-z,1,0,0,-1"),
        ("0.5,21.25,31.75,8,0,0", "1,1.2500000000000000e0,1,2,3,-x,1,-1,0,0"),
        ("12,21.25,31.75,-1,0,0", "1,1.0000000000000000e0,1,2,3,+x,1,1,0,0"),
        ("10.75,20,31.75,0,0.25,0", "1,4.0000000000000000e0,1,2,3,-y,1,0,-1,0"),
        ("10.75,121.5,31.75,0,-100,0", "1,1.0000000000000000e0,1,2,3,+y,1,0,1,0"),
        // From within, and with limits: a hit at tmax does not count.
        ("10.75,21.25,31.75,0,0,-1", "1,0.0000000000000000e0,1,2,3,inside,1,0,0,1"),
        ("10.75,21.25,40,0,0,-2,4.125,inf", "1,4.1250000000000000e0,1,2,3,inside,1,0,0,1"),
        ("10.75,21.25,40,0,0,-2,0,4", MISS),
        ("10.75,21.25,40,0,0,-2,0,0x1.0000000000001p2", "1,4.0000000000000000e0,1,2,3,+z,1,0,0,1"),
        // Past it, away from it, and no rays at all.
        ("11,21.25,40,0,0,-2", MISS),
        ("10.75,21.25,40,0,0,2", MISS),
        ("10.75,21.25,40,0,0,0", MISS),
        ("nan,21.25,40,0,0,-2", MISS),
    ] {
        assert_eq!(hits(&s, ray, ""), [hit], "{ray}");
        for arithmetic in ["f64", "f32"] {
            // The textbook knows no last bit of f64.
            if !ray.contains("0x1.0000000000001p2") {
                assert_eq!(hits(&s, ray, &format!("--arithmetic {arithmetic}")), [hit], "{arithmetic} {ray}");
            }
        }
    }
}

#[test]
fn world_and_grid_give_the_same_hits() {
    let s = one_voxel();
    let world = "10.75,21.25,40,0.03125,0.015625,-2\n9,19,29.5,1.5,2.25,2.25\n10.75,21.25,40,0,0,2\n";
    let grid = "1.5,2.5,20,0.0625,0.03125,-4\n-2,-2,-1,3,4.5,4.5\n1.5,2.5,20,0,0,4\n";
    let found = hits(&s, world, "");
    assert_eq!(found.len(), 3);
    assert!(found[0].starts_with("1,4.0") && found[1].starts_with("1,") && found[2] == MISS, "{found:?}");
    assert_eq!(hits(&s, grid, "--space grid"), found);
}

#[test]
fn the_same_numbers_in_hexadecimal_are_the_same_rays() {
    let s = one_voxel();
    let decimal = "10.8,21.1,40,0.01,0.02,-2\n10.75,21.25,1e1,0,0,3.3\n";
    let hexadecimal = "0x1.599999999999ap3,0x1.519999999999ap4,0x28,0x1.47ae147ae147bp-7,0X1.47AE147AE147BP-6,-0x1p1\n\
                       0x1.58p3,0x1.54p+4,0xa,0x0p0,-0x0,0x1.a666666666666p1\n";
    let found = hits(&s, decimal, "");
    assert!(found.iter().all(|hit| hit.starts_with("1,")), "{found:?}");
    assert_eq!(hits(&s, hexadecimal, ""), found);
    // All 17 digits bring the same bits back.
    let t: f64 = found[1].split(',').nth(1).unwrap().parse().unwrap();
    assert_eq!(t, 43.0 / 6.6);
}

#[test]
fn a_header_blank_lines_and_crlf_are_no_rays() {
    let s = one_voxel();
    let ray = "10.75,21.25,40,0,0,-2";
    let plain = hits(&s, &format!("{ray}\n{ray}\n"), "");
    assert_eq!(plain.len(), 2);
    let dressed = format!("\u{feff}\r\n ox,oy,oz,dx,dy,dz\r\n\r\n{ray}\r\n  \r\n{ray}");
    assert_eq!(hits(&s, &dressed, ""), plain);
    assert_eq!(hits(&s, "", ""), [""; 0]);
    assert_eq!(hits(&s, "ox,oy,oz,dx,dy,dz", ""), [""; 0]);
}

#[test]
fn a_line_that_is_no_ray_is_named_and_nothing_is_left() {
    let s = one_voxel();
    for (rays, words) in [
        ("0,0,0,0,0,1\n\n0,0,0,0,0\n", &["rays.csv:3:", "5 fields", "ox,oy,oz,dx,dy,dz"][..]),
        ("ox,oy,oz,dx,dy,dz\r\n\r\n0,0,0,0,0,1\r\n0,0,zero,0,0,1\r\n", &["rays.csv:4:", "`zero` is not a number"]),
        ("0,0,0,0,0,x\n", &["rays.csv:1:", "`x`"]),
        ("a,b,c\nd,e,f\n", &["rays.csv:2:", "`d`"]),
        ("0,0,0,0,0,1e999\n", &["rays.csv:1:", "too large"]),
        ("0,0,0,0,0,0x1p1024\n", &["rays.csv:1:", "too large"]),
        ("0,0,0,0,0,1.7e308\n", &["rays.csv:1:", "grid coordinates"]),
        ("0,0,0,0,0,1\n\u{1}\n", &["rays.csv:2:"]),
    ] {
        s.write("rays.csv", rays);
        let before = s.files();
        s.run("cast one.vxd --rays rays.csv -o hits.csv").fails(3, words);
        assert_eq!(s.files(), before);
    }
    // Deep in a long file, too.
    s.write("rays.csv", "0,0,0,0,0,1\n".repeat(123_455) + "oops\n" + &"0,0,0,0,0,1\n".repeat(9));
    s.run("cast one.vxd --rays rays.csv -o hits.csv").fails(3, &["rays.csv:123456:", "`oops`"]);
    s.run("cast one.vxd --rays none.csv -o hits.csv").fails(3, &["none.csv", "no such file"]);
    s.run("cast one.vxd --rays rays.csv -o hits.txt").fails(2, &["hits.txt", ".csv"]);
    s.run("cast one.vxd --rays rays.csv -o rays.csv").fails(2, &["never overwritten"]);
    s.run("cast one.vxd --rays rays.csv --json").fails(2, &["-o"]);
    s.run("cast one.vxd --rays rays.csv --normals stored -o hits.csv").fails(2, &["table-normals"]);
}

#[test]
fn order_and_bytes_do_not_depend_on_threads_or_on_where_rays_come_from() {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 40");
    let mut seed = 7u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / (1u64 << 31) as f64 * 4.0 - 1.0
    };
    let rays: String = (0..20_000)
        .map(|_| {
            let [a, b, c, d, e, f]: [f64; 6] = std::array::from_fn(|_| random());
            format!("{a},{b},{c},{d},{e},{f}\n")
        })
        .collect();
    s.write("rays.csv", &rays);
    let report = s.ok("cast box.vxd --rays rays.csv -o one.csv --threads 1 --json").json();
    s.ok("cast box.vxd --rays rays.csv -o three.csv --threads 3");
    let one = s.read("one.csv");
    assert!(one == s.read("three.csv"));

    let mut child = s
        .command("cast box.vxd --rays - -o -")
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let feeder = std::thread::spawn(move || std::io::Write::write_all(&mut stdin, rays.as_bytes()).unwrap());
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    assert!(output.status.success() && output.stdout == one);

    // Every line is what the library says of that ray, and the report counts them.
    let text = String::from_utf8(one).unwrap();
    let words: Vec<u32> = s.read("box.vxd").chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect();
    let scene = voxdag::file::read(&words).unwrap();
    let mut count = 0;
    for (ray, line) in String::from_utf8(s.read("rays.csv")).unwrap().lines().zip(text.lines().skip(1)) {
        let n: Vec<f64> = ray.split(',').map(|x| x.parse().unwrap()).collect();
        let dir = [n[3], n[4], n[5]].map(|d| d / scene.grid.voxel_size);
        let hit = voxdag::trace::Tracer::new(scene.geometry).trace(
            voxdag::trace::Arithmetic::Exact,
            &voxdag::trace::Query::new(scene.grid.to_grid([n[0], n[1], n[2]]), dir),
        );
        let found: Vec<_> = line.split(',').collect();
        assert_eq!(found.len(), 10);
        match hit {
            Some(hit) => {
                assert_eq!(found[1].parse(), Ok(hit.t));
                assert_eq!(found[2..5].join(","), hit.voxel.decode().map(|x| x.to_string()).join(","));
                count += 1;
            }
            None => assert_eq!(line, MISS),
        }
    }
    assert_eq!((&report["rays"], &report["hits"]), (&20_000.into(), &count.into()));
}

#[test]
fn a_program_that_waits_for_its_answer_gets_it() {
    use std::io::{BufRead, BufReader, Write};
    let s = one_voxel();
    let mut child = s
        .command("cast one.vxd --rays -")
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    let mut stdin = child.stdin.take().unwrap();
    for i in 0..3 {
        writeln!(stdin, "10.75,21.25,{},0,0,-2", 34 + 2 * i).unwrap();
        if i == 0 {
            assert_eq!(answers.next().as_deref(), Some(HEADER));
        }
        assert!(answers.next().unwrap().starts_with(&format!("1,{}.0", 1 + i)));
    }
    drop(stdin);
    assert!(child.wait().unwrap().success());
}
