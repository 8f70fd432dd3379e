//! Textures: any numbers make voxels with colours, the same ones for any order of triangles and corners.
//!
//! Bytes: triangles (u8, up to 24), a side of voxels (u8, up to 32), what the picture does (u8: bit 0 colours, bit 1 cuts
//! out, bit 2 clamps), width and height (u8 each, up to 16), scale, offset, base and gain (6 f32 of any bits); then per
//! triangle 9 bytes of corners and 6 f32 of texture coordinates; then pixels (u32).

use std::sync::Arc;

use voxdag::colors::{ColorMode, Colors};
use voxdag::scene::{Build, Options};
use voxdag::texture::{Image, Maps, Placement, Texture};
use voxdag::{Grid, Mesh};

use super::Bytes;

/// A triangle's corners and their texture coordinates.
type Corner = ([f64; 3], [f32; 2]);

/// See the head of the file.
pub fn textures(data: &[u8]) {
    let mut bytes = Bytes(data);
    let (count, side) = (bytes.u8() % 25, u32::from(bytes.u8() % 32) + 1);
    let (does, width, height) = (bytes.u8(), u32::from(bytes.u8() % 16) + 1, u32::from(bytes.u8() % 16) + 1);
    let mut number = || f32::from_bits(bytes.u32());
    let (scale, offset) = ([number(), number(), 1.0], [number(), number(), 0.0]);
    let placement = Placement { scale, offset, base: number(), gain: number(), clamp: does & 4 != 0 };
    let triangles: Vec<[Corner; 3]> = (0..count)
        .map(|_| {
            let corners = [(); 3].map(|()| bytes.array::<3>().map(|x| f64::from(x) / 255.0 * f64::from(side)));
            corners.map(|corner| (corner, [f32::from_bits(bytes.u32()), f32::from_bits(bytes.u32())]))
        })
        .collect();
    let pixels = (0..width * height).map(|_| bytes.u32()).collect();
    let image = Arc::new(Image::new(width, height, pixels).expect("as many pixels as it has"));
    let texture = |is_there: bool| is_there.then(|| Texture::new(image.clone(), placement));
    let maps = [Maps::new(texture(does & 1 != 0), texture(does & 2 != 0)).expect("small")];
    let grid = Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: side };

    let first = built(&triangles, &grid, &maps);
    let other: Vec<_> = triangles.iter().rev().map(|&[a, b, c]| [b, c, a]).collect();
    assert!(built(&other, &grid, &maps) == first, "another order gives other colours");
    for words in first.iter().flat_map(|(_, colors)| colors) {
        let colors = Colors::new(words).expect("what was made is right");
        (0..colors.count() + 70).for_each(|rank| _ = colors.get(rank));
    }
}

/// The words of the DAG and of its colours in both ways; nothing without triangles.
fn built(triangles: &[[Corner; 3]], grid: &Grid, maps: &[Maps]) -> Option<(Vec<u32>, Vec<Vec<u32>>)> {
    let positions: Vec<_> = triangles.as_flattened().iter().map(|corner| corner.0).collect();
    let indices: Vec<_> = (0..triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let uvs: Vec<_> = triangles.iter().map(|corners| corners.map(|corner| corner.1)).collect();
    let mesh = Mesh { positions: &positions, triangles: &indices, uvs: &uvs, ..Mesh::default() };
    let build = Build::new(&mesh, grid, &Options::default()).ok()?.with_textures(maps);
    let mut join = build.join().expect("a depth that there is");
    for part in 0..build.parts() {
        join.add(build.part(part).expect("no limit")).expect("in order");
    }
    let (dag, pending) = join.finish().expect("small");
    let colors = [ColorMode::Blocks, ColorMode::Raw].map(|mode| pending.colors(&dag.dag(), mode).expect("small"));
    Some((dag.words().to_vec(), colors.into_iter().flatten().map(|colors| colors.into_words()).collect()))
}
