//! A picture by the example shader against the one that the core draws: the demo's hall, Phong's model, fitted normals.

use voxdag::camera::Camera;
use voxdag::effects::Effects;
use voxdag::file::Parts;
use voxdag::render::{Settings, View, render_rows};
use voxdag::scene::{Build, Options};
use voxdag::trace::Tracer;
use voxdag::{Grid, Material, demo, file, wgsl};

use crate::gpu::Gpu;

const SIZE: [u32; 2] = [320, 240];
/// The least that counts as the same picture: rounding moves a channel by one step here and there.
const LEAST_PSNR: f64 = 50.0;

/// Draws both; 1 if they differ too much.
pub fn check(gpu: &Gpu) -> u64 {
    let words = hall(512);
    let scene = file::read(&words).expect("as written");
    let demo::DemoView { eye, target, up, fov_y, .. } = demo::view();
    let camera = Camera { eye, target, up, fov_y };
    let lights = [camera.headlight(scene.bounds.radius() / 8.0)];
    let settings = Settings { width: SIZE[0], height: SIZE[1], effects: Effects::PHONG, ..Settings::default() };
    let palette: Vec<Material> = (0..scene.material_count()).map(|id| scene.material(id as u16)).collect();

    let uniform = wgsl::scene(&words).expect("a DAG and a tree");
    let uploaded = gpu.scene(&words, &uniform);
    let place = scene.grid.to_grid(camera.eye);
    let rays = camera.rays(SIZE[0], SIZE[1]).expect("a camera");
    let [corner, right, below] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| rays.direction(x, y));
    let light = match lights[0].kind {
        voxdag::shade::LightKind::Point(p) => scene.grid.to_grid(p),
        voxdag::shade::LightKind::Directional(_) => unreachable!("a headlight has a place"),
    };
    let picture = words_of(place, corner, [right, below], light, &settings);
    let pipeline = gpu.pipeline("vd_draw");
    let groups = SIZE.map(|side| side.div_ceil(8));
    let input = (&picture[..], wgpu::BufferUsages::UNIFORM);
    let count = (SIZE[0] * SIZE[1]) as usize;
    let start = std::time::Instant::now();
    let pixels = gpu.run(&pipeline, &uploaded, input, groups, count);
    let seconds = start.elapsed().as_secs_f64();

    let view = View {
        tracer: Tracer::new(scene.geometry),
        materials: scene.materials,
        palette: &palette,
        grid: scene.grid,
        camera,
        lights: &lights,
    };
    let mut expected = vec![0; count];
    let counters = render_rows(&view, &settings, 0..SIZE[1], &mut expected).expect("a picture");
    let (psnr, most, different) = compare(&expected, &pixels);
    let [width, height] = SIZE;
    println!("picture of {width} x {height} pixels, {} of them hits, in {seconds:.2} s:", counters.hits);
    println!("  {psnr:.1} dB from the core's; {different} pixels differ, by at most {most} of 255\n");
    if let Ok(path) = std::env::var("VOXDAG_GPU_PICTURE") {
        let save = |name: &str, pixels: &[u32]| {
            let mut text = format!("P6 {} {} 255\n", SIZE[0], SIZE[1]).into_bytes();
            pixels.iter().for_each(|pixel| text.extend_from_slice(&pixel.to_le_bytes()[..3]));
            std::fs::write(format!("{path}/{name}.ppm"), text).expect("the folder can be written");
        };
        save("gpu", &pixels);
        save("cpu", &expected);
    }
    u64::from(!(psnr >= LEAST_PSNR && counters.hits > 1000))
}

/// The uniform `vd_picture`.
fn words_of(eye: [f64; 3], corner: [f64; 3], ends: [[f64; 3]; 2], light: [f64; 3], settings: &Settings) -> Vec<u32> {
    let float = |v: [f64; 3]| v.map(|x| (x as f32).to_bits());
    let [dx, dy] = ends.map(|end| core::array::from_fn(|i| end[i] - corner[i]));
    let rows = [
        (eye, settings.width),
        (corner, settings.height),
        (dx, settings.ambient[0].to_bits()),
        (dy, 0),
        (light, 0),
        (settings.background.map(f64::from), 0),
    ];
    rows.into_iter().flat_map(|(v, last)| float(v).into_iter().chain([last])).collect()
}

/// PSNR of the sRGB bytes, the largest difference, and the number of pixels that differ.
fn compare(a: &[u32], b: &[u32]) -> (f64, u8, usize) {
    let (mut sum, mut most, mut different) = (0.0, 0, 0);
    for (a, b) in a.iter().zip(b) {
        different += usize::from(a != b);
        for (a, b) in a.to_le_bytes().into_iter().zip(b.to_le_bytes()).take(3) {
            sum += f64::from(a.abs_diff(b)) * f64::from(a.abs_diff(b));
            most = most.max(a.abs_diff(b));
        }
    }
    let mean = sum / (3 * a.len()) as f64;
    (10.0 * libm::log10(255.0 * 255.0 / mean), most, different)
}

/// The demo's scene as a file.
fn hall(resolution: u32) -> Vec<u32> {
    let library = |path: &str| (path == demo::MTL_NAME).then(|| demo::mtl().into_bytes());
    let model = voxdag::obj::import(demo::obj().as_bytes(), library).expect("the demo is a mesh");
    let materials: Vec<Material> = model.materials.iter().map(|m| m.material).collect();
    let names: Vec<&str> = model.materials.iter().map(|m| m.name.as_str()).collect();
    let mesh = model.mesh();
    let bounds = mesh.validate().expect("the demo is valid");
    let grid = Grid::fit(&bounds, resolution).expect("the demo has a size");
    let built = Build::new(&mesh, &grid, &Options::default()).and_then(|build| build.run()).expect("room");
    let parts = Parts {
        grid,
        bounds,
        up: voxdag::grid::UpAxis::Y,
        metres_per_unit: 0.0,
        geometry: built.dag.dag().into(),
        voxel_materials: built.materials.as_materials(None).expect("a tree"),
        colors: None,
        materials: &materials,
        names: &names,
    };
    parts.to_vec().expect("a file")
}
