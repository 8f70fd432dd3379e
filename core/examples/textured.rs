//! Textures without files: a picture made in code lies on the sides of a box, and each voxel takes its colour from there.
//!
//! `cargo run --release -p voxdag --features obj --example textured -- box.ppm` writes a picture.

use std::error::Error;
use std::sync::Arc;

use voxdag::camera::Camera;
use voxdag::render::{Samples, Settings, View, render_rows};
use voxdag::scene::{Build, Options};
use voxdag::texture::{Image, ImageError, Maps, Placement, Texture};
use voxdag::trace::Tracer;
use voxdag::{Grid, Material, Mesh};

/// The textures of the one material: chequers, white and a colour that goes from red on the left to blue on the right.
fn maps() -> Result<Maps, ImageError> {
    const SIDE: u32 = 256;
    let pixel = |x: u32, y: u32| {
        let is_white = (x / 32 + y / 32).is_multiple_of(2);
        let [r, g, b] = if is_white { [250; 3] } else { [255 - x as u8, 40, x as u8] };
        u32::from_le_bytes([r, g, b, 255]) // sRGB, and opaque
    };
    // Rows from the top.
    let pixels = (0..SIDE * SIDE).map(|i| pixel(i % SIDE, i / SIDE)).collect();
    let chequers = Texture::new(Arc::new(Image::new(SIDE, SIDE, pixels)?), Placement::default());
    Maps::new(Some(chequers), None)
}

/// What a [`Mesh`] borrows.
#[derive(Default)]
struct Sides {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    uvs: Vec<[[f32; 2]; 3]>,
}

/// A box from -1 to 1, the whole picture on each side.
fn sides() -> Sides {
    const CORNERS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut sides = Sides::default();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
        // The picture's axes: counter-clockwise seen from outside.
        let (across, up) = ((axis + 1) % 3, (axis + 2) % 3);
        let first = sides.positions.len() as u32;
        for [u, v] in CORNERS.map(|uv| uv.map(f64::from)) {
            let mut position = [sign; 3];
            position[across] = sign * (2.0 * u - 1.0);
            position[up] = 2.0 * v - 1.0;
            sides.positions.push(position);
        }
        for corners in [[0, 1, 2], [0, 2, 3]] {
            sides.triangles.push(corners.map(|corner| first + corner));
            sides.uvs.push(corners.map(|corner| CORNERS[corner as usize]));
        }
    }
    sides
}

/// A picture of the box, as bytes of red, green and blue.
fn draw(size: [u32; 2], resolution: u32) -> Result<Vec<u8>, Box<dyn Error>> {
    let Sides { positions, triangles, uvs } = sides();
    let mesh = Mesh { positions: &positions, triangles: &triangles, uvs: &uvs, ..Mesh::default() };
    let grid = Grid::fit(&mesh.validate()?, resolution)?;
    // By material id, as the palette below. After this the pictures are needed no more.
    let built = Build::new(&mesh, &grid, &Options::default())?.with_textures(&[maps()?]).run()?;

    // Ka and Kd are factors on the colour; without `textured` they are all there is.
    let material = Material { ambient: [1.0; 3], diffuse: [1.0; 3], textured: true, ..Material::GREY };
    let camera = Camera { eye: [2.5, 2.0, 4.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y: 40.0 };
    let view = View {
        tracer: Tracer::new(built.dag.dag()),
        materials: built.looks()?,
        palette: &[material],
        grid,
        camera,
        lights: &[camera.headlight(2.0)],
    };
    let settings = Settings { width: size[0], height: size[1], samples: Samples::Four, ..Settings::default() };
    let mut pixels = vec![0; (size[0] * size[1]) as usize];
    render_rows(&view, &settings, 0..size[1], &mut pixels)?;
    Ok(pixels.iter().flat_map(|pixel| pixel.to_le_bytes().into_iter().take(3)).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let Some(path) = std::env::args().nth(1) else {
        println!("name a file for the picture:");
        println!("cargo run --release -p voxdag --features obj --example textured -- box.ppm");
        return Ok(());
    };
    let size = [640, 480];
    let header = format!("P6 {} {} 255\n", size[0], size[1]).into_bytes();
    std::fs::write(&path, [header, draw(size, 512)?].concat())?;
    println!("{path}");
    Ok(())
}

#[test]
fn the_colours_of_the_picture_are_seen() {
    let rgb = draw([64, 48], 128).unwrap();
    let share = |is: fn([u8; 3]) -> bool| {
        rgb.chunks(3).filter(|p| is([p[0], p[1], p[2]])).count() as f64 / (rgb.len() / 3) as f64
    };
    // Half of the chequers have a colour; grey would be neither red nor blue anywhere.
    let red = share(|[r, g, b]| r > b.saturating_add(50) && r > g.saturating_add(50));
    let blue = share(|[r, g, b]| b > r.saturating_add(50) && b > g.saturating_add(50));
    assert!(red > 0.03 && blue > 0.03, "{red} of the picture is red, {blue} blue");
}
