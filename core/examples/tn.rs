use voxdag::camera::Camera;
use voxdag::materials::Single;
use voxdag::normal::*;
use voxdag::trace::*;
use voxdag::{layout::*, match_geometry};
struct Clock;
struct T(u64);
fn cpu() -> u64 { std::fs::read_to_string("/proc/thread-self/schedstat").unwrap().split(' ').next().unwrap().parse().unwrap() }
impl Clock { fn now() -> T { std::thread::yield_now(); T(cpu()) } }
impl T { fn elapsed(&self) -> std::time::Duration { std::thread::yield_now(); std::time::Duration::from_nanos(cpu() - self.0) } }
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let bytes = std::fs::read(&args[1]).unwrap();
    let words = voxdag::file::words_from_bytes(&bytes).unwrap();
    let scene = voxdag::file::read(&words).unwrap();
    let tile: u32 = args[2].parse().unwrap();
    let arg = args[3].clone(); let chunk: usize = std::env::var("CHUNK").map_or(256, |c| c.parse().unwrap());
    let camera = Camera::framing(&scene.bounds, scene.up);
    let rays = camera.rays(1920, 1080).unwrap();
    let eye = scene.grid.to_grid(camera.eye);
    let mut pixels: Vec<[u32; 2]> = (0..1080).flat_map(|y| (0..1920).map(move |x| [x, y])).collect();
    if tile > 0 { pixels.sort_by_key(|p| (p[1] / (if tile == 16 { 4 } else { tile }), p[0] / tile, p[1], p[0])); }
    match_geometry!(scene.geometry, dag => {
    let top = TopBuf::new(&dag, 6).unwrap();
    let tracer = Tracer::with_top(dag, top.as_top()).unwrap();
    let found: Vec<_> = pixels.iter().filter_map(|p| {
        let d = rays.direction(p[0] as f64 + 0.5, p[1] as f64 + 0.5);
        tracer.trace(Arithmetic::Exact, &Query::new(eye, d)).map(|h| (h, d))
    }).collect();
    let (hits, dirs): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let mut out = vec![Normal { direction: [0.0; 3], confidence: Confidence::Face }; hits.len()];
    let mut plain = out.clone();
    for (name, kind) in [("gradient", NormalKind::Gradient), ("plane1", NormalKind::Plane1), ("plane2", NormalKind::Plane2), ("plane3", NormalKind::Plane3)] {
        if arg != "all" && !arg.contains(name) { continue; }
        let mut best = vec![1e9f64; 7];
        if let Some(one) = args.get(4) {
            let level = voxdag::simd::Level::all().find(|l| l.name() == one);
            let mut best = 1e9f64;
            if one == "single" {
                for _ in 0..15 {
                    let t = Clock::now();
                    for i in 0..hits.len() { plain[i] = normal(&tracer, Single(0), &hits[i], dirs[i], kind); }
                    best = best.min(1e9 * t.elapsed().as_secs_f64() / hits.len() as f64);
                }
                println!("{name} {best:.1}");
                continue;
            }
            for _ in 0..30 {
                let t = Clock::now();
                for ((h, d), o) in hits.chunks(chunk).zip(dirs.chunks(chunk)).zip(out.chunks_mut(chunk)) {
                    normals(level, &tracer, Single(0), h, d, kind, o);
                }
                best = best.min(1e9 * t.elapsed().as_secs_f64() / hits.len() as f64);
            }
            println!("{name} {best:.1}");
            continue;
        }
        let levels: Vec<_> = [None].into_iter().chain(voxdag::simd::Level::all().map(Some)).collect();
        for _ in 0..args.get(4).map_or(7, |_| 30) {
            let t = Clock::now();
            for i in 0..hits.len() { plain[i] = normal(&tracer, Single(0), &hits[i], dirs[i], kind); }
            best[6] = best[6].min(1e9 * t.elapsed().as_secs_f64() / hits.len() as f64);
            for (i, &level) in levels.iter().enumerate() {
                let t = Clock::now();
                for ((h, d), o) in hits.chunks(chunk).zip(dirs.chunks(chunk)).zip(out.chunks_mut(chunk)) {
                    normals(level, &tracer, Single(0), h, d, kind, o);
                }
                best[i] = best[i].min(1e9 * t.elapsed().as_secs_f64() / hits.len() as f64);
                assert!(plain == out);
            }
        }
        let planes = out.iter().filter(|n| matches!(n.confidence, Confidence::Plane { .. })).count();
        print!("{name:9} planes {:.3} single {:.1}", planes as f64 / hits.len() as f64, best[6]);
        for (i, level) in levels.iter().enumerate() { print!(" {} {:.1}", level.map_or("none", |l| l.name()), best[i]); }
        println!();
    }
    });
}
