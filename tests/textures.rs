//! Textures: what voxels take over from pictures, against formulas and a mean of our own, and how colours are kept.

use std::collections::BTreeMap;
use std::sync::Arc;

use voxdag::colors::{ColorMode, Colored, Colors, ColorsBuf, Painted};
use voxdag::materials::Single;
use voxdag::rank::{AnyRank, Prefix};
use voxdag::scene::{Build, Join, MaterialMode, Options};
use voxdag::texture::{Image, Maps, Placement, Texture};
use voxdag::voxelize::{Cover, VoxelizeError, Voxelizer};
use voxdag::{Grid, Materials, Mesh, Morton};
use voxdag_oracle::rng::Rng;

/// The linear light of an sRGB byte, by the standard's formula.
fn linear(byte: u8) -> f64 {
    let s = f64::from(byte) / 255.0;
    if s <= 0.04045 { s / 12.92 } else { libm::pow((s + 0.055) / 1.055, 2.4) }
}

/// The sRGB value of linear light, in steps of a byte.
fn encoded(x: f64) -> f64 {
    255.0 * if x <= 0.0031308 { 12.92 * x } else { 1.055 * libm::pow(x, 1.0 / 2.4) - 0.055 }
}

/// A picture whose pixels are given by column and row from the top.
fn picture(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Arc<Image> {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = pixels.map(|(x, y)| u32::from_le_bytes(pixel(x, y))).collect();
    Arc::new(Image::new(width, height, pixels).unwrap())
}

fn painted(image: &Arc<Image>, placement: Placement) -> Vec<Maps> {
    vec![Maps::new(Some(Texture::new(image.clone(), placement)), None).unwrap()]
}

/// Triangles of one material with texture coordinates.
#[derive(Clone)]
struct Sheet {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    uvs: Vec<[[f32; 2]; 3]>,
}

impl Sheet {
    /// A square in the plane z = 0.5 of `side` voxels, the whole picture on it.
    fn square(side: f64) -> Sheet {
        let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let corner = |k: usize| [f64::from(uvs[k][0]) * side, f64::from(uvs[k][1]) * side, 0.5];
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let of = |t: &[u32; 3]| t.map(|k| uvs[k as usize]);
        Sheet { positions: (0..4).map(corner).collect(), uvs: triangles.iter().map(of).collect(), triangles }
    }

    /// A sheet of random triangles, which meet, cross and lie in one plane, in a cube of `side` voxels.
    fn random(rng: &mut Rng, side: u64, count: usize) -> Sheet {
        let mut sheet = Sheet { positions: Vec::new(), triangles: Vec::new(), uvs: Vec::new() };
        for k in 0..count {
            let flat = k % 2 == 0;
            let first = sheet.positions.len() as u32;
            for _ in 0..3 {
                let mut at = [0; 3].map(|_: i32| rng.below(side * 4) as f64 / 4.0);
                at[2] = if flat { 3.5 } else { at[2] };
                sheet.positions.push(at);
            }
            sheet.triangles.push([first, first + 1, first + 2]);
            sheet.uvs.push([0; 3].map(|_| [0; 2].map(|_| rng.below(1000) as f32 / 333.0 - 1.0)));
        }
        sheet
    }

    fn mesh(&self) -> Mesh<'_> {
        let Sheet { positions, triangles, uvs } = self;
        Mesh { positions, triangles, uvs, ..Mesh::default() }
    }

    /// The voxels, each with its colour, as they are.
    fn colors(&self, grid: &Grid, maps: &[Maps]) -> Vec<([u32; 3], [u8; 3])> {
        let options = Options { materials: MaterialMode::Tree, ..Options::default() };
        let mesh = self.mesh();
        let build = Build::new(&mesh, grid, &options).unwrap().with_textures(maps);
        let mut join: Join<'_, '_> = build.join().unwrap();
        (0..build.parts()).for_each(|part| join.add(build.part(part).unwrap()).unwrap());
        let (dag, pending) = join.finish().unwrap();
        let counts = Prefix::build(&dag.dag()).unwrap();
        let rank = AnyRank::Prefix(Prefix::new(dag.dag(), &counts).unwrap());
        let Some(colors) = pending.colors(&dag.dag(), ColorMode::Raw).unwrap() else { return Vec::new() };
        assert!(Colors::new(colors.as_colors().words()).is_ok());
        let looks = Painted { materials: Single(0), colors: Colored::new(rank, colors.as_colors()).ok() };
        dag.dag().voxels().map(|voxel| (voxel.decode(), looks.color(voxel).unwrap())).collect()
    }
}

fn unit_grid(resolution: u32) -> Grid {
    Grid { origin: [0.0; 3], voxel_size: 1.0, resolution }
}

/// One pixel a voxel: every voxel has its pixel, the picture's top row on top, however it is laid.
#[test]
fn a_test_card_is_upright() {
    let side = 16;
    let card = picture(side, side, |x, y| [16 * x as u8, 16 * y as u8, (x * y) as u8, 255]);
    let sheet = Sheet::square(f64::from(side));
    let pixel = |x: u32, y: u32| [16 * x as u8, 16 * y as u8, (x * y) as u8];
    let check = |placement: Placement, expected: &dyn Fn(u32, u32) -> [u8; 3]| {
        // The grid goes on behind the far border, so that the border is not moved; voxels that only touch it do not count.
        let found = sheet.colors(&unit_grid(2 * side), &painted(&card, placement));
        let found: Vec<_> = found.into_iter().filter(|([x, y, _], _)| x.max(y) < &side).collect();
        assert_eq!(found.len(), (side * side) as usize);
        for ([x, y, _], color) in found {
            assert_eq!(color, expected(x, y), "at {x}, {y} with {placement:?}");
        }
    };
    check(Placement::default(), &|x, y| pixel(x, side - 1 - y));
    let shifted = Placement { offset: [0.25, 0.5, 0.0], ..Placement::default() };
    check(shifted, &|x, y| pixel((x + 4) % side, (2 * side - 1 - (y + 8)) % side));
    check(Placement { clamp: true, ..shifted }, &|x, y| pixel((x + 4).min(15), (side - 1).saturating_sub(y + 8)));
    let mirrored = Placement { scale: [-1.0, 1.0, 1.0], ..Placement::default() };
    check(mirrored, &|x, y| pixel(side - 1 - x, side - 1 - y));
}

/// Four times as many pixels as voxels each way: each voxel has the mean light of its sixteen.
#[test]
fn fine_pictures_are_averaged_in_linear_light() {
    let (side, fine) = (16u32, 64);
    let checks = picture(fine, fine, |x, y| if (x + y) % 2 == 0 { [255, 255, 255, 255] } else { [0, 0, 0, 255] });
    let expected = encoded(0.5);
    for ([x, y, _], color) in
        Sheet::square(f64::from(side)).colors(&unit_grid(side), &painted(&checks, Placement::default()))
    {
        for channel in color {
            assert!((f64::from(channel) - expected).abs() <= 1.0, "{color:?} at {x}, {y}: expected {expected}");
        }
    }
}

/// The mean of nearest pixels in linear light over the part of the triangle that is in the voxel, by many points; `None` for
/// parts of less than 0.8 voxels.
fn mean_in(sheet: &Sheet, voxel: [u32; 3], size: u32, pixel: &dyn Fn(u32, u32) -> [u8; 4]) -> Option<[f64; 3]> {
    let steps = 220;
    let (mut sum, mut count) = ([0.0; 3], 0u32);
    let [a, b, c] = sheet.triangles[0].map(|v| sheet.positions[v as usize]);
    for i in 0..steps {
        for j in 0..steps - i {
            let (s, t) = ((f64::from(i) + 0.3) / f64::from(steps), (f64::from(j) + 0.3) / f64::from(steps));
            let at: [f64; 3] = core::array::from_fn(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
            if at.map(|x| x.floor() as u32) != voxel {
                continue;
            }
            let uv = [0, 1].map(|k| {
                let [a, b, c] = sheet.uvs[0].map(|uv| f64::from(uv[k]));
                a + s * (b - a) + t * (c - a)
            });
            let [x, y] = [uv[0], 1.0 - uv[1]].map(|x| ((x - x.floor()) * f64::from(size)) as u32 % size);
            let [r, g, b, _] = pixel(x, y);
            [r, g, b].iter().zip(&mut sum).for_each(|(byte, sum)| *sum += linear(*byte));
            count += 1;
        }
    }
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
    let cross = [0, 1, 2].map(|i| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
    let area = libm::sqrt(cross.iter().map(|x| x * x).sum()) * f64::from(count) / f64::from(steps * steps);
    (area > 0.8).then(|| sum.map(|x| x / f64::from(count)))
}

/// Slanted triangles under smooth pictures of any scale: near to the mean over what the voxel cuts out of them.
#[test]
fn colors_come_near_to_the_mean_over_the_voxel() {
    let size = 128;
    // Two waves across the picture, which repeats without a seam.
    let wave = |k: u32, phase: f64| {
        let turn = core::f64::consts::TAU * 2.0 * f64::from(k) / f64::from(size);
        (127.5 + 100.0 * libm::sin(turn + phase)) as u8
    };
    let pixel = |x: u32, y: u32| [wave(x, 0.0), wave(y, 1.0), wave(x + y, 2.0), 255];
    let image = picture(size, size, pixel);
    let mut channels = 0;
    for seed in 0..12 {
        let mut rng = Rng::new(seed);
        let mut corner = || [0; 3].map(|_: i32| rng.below(16 << 8) as f64 / 256.0);
        let positions = vec![corner(), corner(), corner()];
        let mut uv = || [0; 2].map(|_| rng.below(1000) as f32 / 700.0);
        let uvs = vec![[uv(), uv(), uv()]];
        let sheet = Sheet { positions, triangles: vec![[0, 1, 2]], uvs };
        let (mut error, mut worst, mut count) = (0.0, 0.0f64, 0);
        for (voxel, color) in sheet.colors(&unit_grid(16), &painted(&image, Placement::default())) {
            let Some(mean) = mean_in(&sheet, voxel, size, &pixel) else { continue };
            for (found, expected) in color.iter().zip(mean) {
                let off = (f64::from(*found) - encoded(expected)).abs();
                (error, worst, count) = (error + off, worst.max(off), count + 1);
            }
        }
        channels += count;
        let mean = error / f64::from(count);
        assert!(mean < 5.0 && worst < 16.0, "seed {seed}: off by {mean} of 255 on average, {worst} at most");
    }
    assert!(channels > 400, "{channels} channels are too few");
}

/// The order of triangles and of their corners changes no colour, not even where triangles lie in one plane.
#[test]
fn colors_do_not_depend_on_the_order() {
    let image = picture(64, 64, |x, y| [(x * 4) as u8, (y * 4) as u8, (x ^ y) as u8 * 4, 255]);
    let maps = painted(&image, Placement::default());
    for seed in 0..20 {
        let mut rng = Rng::new(seed);
        let sheet = Sheet::random(&mut rng, 16, 30);
        let expected = sheet.colors(&unit_grid(16), &maps);
        assert!(expected.len() > 100);
        let mut other = sheet.clone();
        for k in 0..other.triangles.len() {
            let with = rng.below(other.triangles.len() as u64) as usize;
            other.triangles.swap(k, with);
            other.uvs.swap(k, with);
            let turn = rng.below(3) as usize;
            other.triangles[k].rotate_left(turn);
            other.uvs[k].rotate_left(turn);
        }
        assert!(other.colors(&unit_grid(16), &maps) == expected, "seed {seed}");
    }
}

/// A disc is cut out of a square by opacity, and by brightness where there is none; half or more of a voxel stays.
#[test]
fn a_brick_is_cut_out_as_the_whole_is() {
    let image = picture(8, 8, |x, y| [255, 255, 255, if (x + y) % 3 == 0 { 255 } else { 0 }]);
    let dissolve = Some(Texture::new(image, Placement::default()));
    let (sheet, grid, maps) = (Sheet::square(32.0), unit_grid(32), [Maps::new(None, dissolve).unwrap()]);
    let mesh = sheet.mesh();
    let voxelizer = Voxelizer::new(&mesh, &grid, Cover::Exact).unwrap().with_textures(&maps);
    let mut marked = BTreeMap::new();
    for subtree in 0..voxelizer.subtrees() {
        let base = voxelizer.subtree_code(subtree).0;
        let whole = voxelizer.voxelize::<VoxelizeError>(subtree, |brick| {
            marked.extend(brick.triangles.iter().map(|&(triangle, mask)| ((triangle, base | brick.code.0), mask)));
            Ok(())
        });
        whole.unwrap();
    }
    let count: u32 = marked.values().map(|mask: &u64| mask.count_ones()).sum();
    assert!((200..600).contains(&count), "{count} of 1024 voxels");
    for code in (0..32 * 32 * 32).step_by(64).map(Morton) {
        for triangle in [0, 1] {
            let expected = marked.get(&(triangle, code.0)).copied().unwrap_or(0);
            assert_eq!(voxelizer.brick(triangle, code), expected, "{triangle} at {code:?}");
        }
    }
}

#[test]
fn what_is_cut_out_is_empty() {
    let side = 32;
    let inside = |x: u32, y: u32| {
        let d = [x, y].map(|k| f64::from(k) + 0.5 - 64.0);
        d[0] * d[0] + d[1] * d[1] < 50.0 * 50.0
    };
    let by_opacity = picture(128, 128, |x, y| [9, 9, 9, if inside(x, y) { 255 } else { 0 }]);
    let by_brightness = picture(128, 128, |x, y| if inside(x, y) { [255; 4] } else { [0, 0, 0, 255] });
    let white = picture(1, 1, |_, _| [255; 4]);
    let sheet = Sheet::square(f64::from(side));
    for image in [by_opacity, by_brightness] {
        let [diffuse, dissolve] = [&white, &image].map(|image| Some(Texture::new(image.clone(), Placement::default())));
        let found = sheet.colors(&unit_grid(side), &[Maps::new(diffuse, dissolve).unwrap()]);
        for y in 0..side {
            for x in 0..side {
                let pixels = (0..16).filter(|k| inside(4 * x + k % 4, 127 - (4 * y + k / 4))).count();
                let is_there = found.iter().any(|(voxel, _)| *voxel == [x, y, 0]);
                // Blending reaches half a pixel across the border of the voxel.
                if !(5..12).contains(&pixels) {
                    assert_eq!(is_there, pixels >= 8, "at {x}, {y}: {pixels} of 16 pixels");
                }
            }
        }
    }
}

/// What is built at once has the colours that are made step by step, by whatever ranks the materials go.
#[test]
fn built_at_once_is_built_by_parts() {
    let card = picture(64, 64, |x, y| [4 * x as u8, 4 * y as u8, (x * y) as u8, 255]);
    let (sheet, maps, grid) = (Sheet::square(40.0), painted(&card, Placement::default()), unit_grid(40));
    let expected = sheet.colors(&grid, &maps);
    let modes = [MaterialMode::Tree, MaterialMode::Table, MaterialMode::Ranked, MaterialMode::Moxels];
    for materials in modes {
        let options = Options { materials, colors: ColorMode::Raw, ..Options::default() };
        let mesh = sheet.mesh();
        let built = Build::new(&mesh, &grid, &options).unwrap().with_textures(&maps).run().unwrap();
        let looks = built.looks().unwrap();
        let found = built.dag.dag().voxels().map(|voxel| (voxel.decode(), looks.color(voxel).unwrap()));
        assert!(found.eq(expected.iter().copied()), "{materials:?}");
        assert!(built.dag.dag().voxels().all(|voxel| looks.id(voxel) == 0));

        // Without textures ranks are there only where materials go by them; colours without ranks are refused.
        let mut plain = Build::new(&mesh, &grid, &options).unwrap().run().unwrap();
        assert!(plain.looks().unwrap().colors.is_none());
        plain.colors = built.colors;
        let by_rank = matches!(materials, MaterialMode::Ranked | MaterialMode::Moxels);
        assert_eq!(plain.looks().is_ok(), by_rank);
    }
}

/// Leaves on white that is cut out: what is left of the surface is green, at its borders, too, and however coarse. The
/// opacity may stand in the same picture, in another one of another size, or the other way round.
#[test]
fn what_is_cut_out_lends_no_color() {
    const GREEN: [u8; 3] = [30, 200, 10];
    let leaf = |x: u32, y: u32, size: u32| !(x * 8 / size + y * 32 / size).is_multiple_of(3);
    let [r, g, b] = GREEN;
    let card = picture(128, 128, |x, y| if leaf(x, y, 128) { [r, g, b, 255] } else { [255, 255, 255, 0] });
    let opaque = picture(128, 128, |x, y| if leaf(x, y, 128) { [r, g, b, 255] } else { [255; 4] });
    let mask = picture(256, 256, |x, y| if leaf(x, y, 256) { [255; 4] } else { [0, 0, 0, 255] });
    let holes = picture(128, 128, |x, y| if leaf(x, y, 128) { [r, g, b, 0] } else { [255; 4] });
    let turned = Placement { base: 1.0, gain: -1.0, ..Placement::default() };
    let lay = |image: &Arc<Image>, placement| Some(Texture::new(image.clone(), placement));
    let plain = Placement::default();
    for (what, color, cut) in [
        ("in itself", lay(&card, plain), lay(&card, plain)),
        ("apart", lay(&opaque, plain), lay(&mask, plain)),
        ("inverted", lay(&holes, plain), lay(&holes, turned)),
    ] {
        let maps = [Maps::new(color, cut).unwrap()];
        for side in [1, 4, 16, 37, 64, 128, 200] {
            let found = Sheet::square(f64::from(side)).colors(&unit_grid(side), &maps);
            assert!(!found.is_empty() && (side < 64 || found.len() < (side * side) as usize));
            for (voxel, color) in &found {
                // Half a pixel beyond the border is left where half of a voxel is.
                let near = (0..3).all(|i| color[i].abs_diff(GREEN[i]) <= 1);
                assert!(near, "{what}: {color:?} at {voxel:?}, {side} voxels");
            }
        }
    }
}

/// Without a picture that cuts, opacity is none: what is drawn coarse is the mean of what is drawn fine.
#[test]
fn opacity_of_what_is_not_cut_out_counts_for_nothing() {
    let checks = |opacity: u8| {
        picture(64, 64, move |x, y| if (x / 4 + y / 4) % 2 == 0 { [255, 0, 0, 255] } else { [0, 0, 255, opacity] })
    };
    for side in [1, 4, 16, 64] {
        let [faint, opaque] = [8, 255].map(|opacity| {
            Sheet::square(f64::from(side)).colors(&unit_grid(side), &painted(&checks(opacity), Placement::default()))
        });
        assert!(faint == opaque, "{side} voxels");
    }
}

/// What the words of blocks say by the documentation.
fn decoded(words: &[u32], rank: u64) -> [u8; 3] {
    let count = u64::from(words[0]) | u64::from(words[1]) << 32;
    let blocks = count.div_ceil(64) as usize;
    let groups = blocks.div_ceil(64);
    let (block, k) = ((rank / 64) as usize, (rank % 64) as usize);
    let [a, b] = [words[4 + groups + 2 * block], words[4 + groups + 2 * block + 1]];
    let rgb = |w: u32| [w as u8, (w >> 8) as u8, (w >> 16) as u8];
    let width = match b >> 29 {
        7 => 24,
        bits => bits as usize,
    };
    let offset = (a >> 24 | (b >> 24 & 31) << 8) as usize;
    let start = 4 + groups + 2 * blocks + words[4 + block / 64] as usize + offset;
    let bit = |i: usize| words[start + i / 32] >> (i % 32) & 1;
    let value = (0..width).fold(0, |value, i| value | bit(k * width + i) << i);
    if width == 24 {
        return rgb(value);
    }
    let most = f64::from((1u32 << width) - 1).max(1.0);
    core::array::from_fn(|i| {
        let (first, second) = (f64::from(rgb(a)[i]), f64::from(rgb(b)[i]));
        (first + (second - first) * f64::from(value) / most + 0.5).floor() as u8
    })
}

/// Blocks keep colours as closely as they say, in no more bits than they say, and say so in documented words.
#[test]
fn blocks_keep_colors_closely() {
    let mut rng = Rng::new(7);
    let mut noise = |most: u64| rng.below(most) as u8;
    let smooth = |i: u64| [i as u8 / 2, 60 + (i % 64) as u8, 200 - (i % 64) as u8];
    type Kind<'a> = (&'a str, f64, Box<dyn FnMut(u64) -> Option<[u8; 3]> + 'a>);
    let kinds: [Kind<'_>; 6] = [
        ("one colour", 1.1, Box::new(|_| Some([17, 18, 200]))),
        ("two colours", 2.1, Box::new(|i| Some(if i % 3 == 0 { [255, 0, 9] } else { [0, 90, 250] }))),
        ("smooth", 5.1, Box::new(move |i| Some(smooth(i)))),
        ("every third", 5.1, Box::new(move |i| (i % 3 == 0).then(|| smooth(i)))),
        ("none", 1.1, Box::new(|_| None)),
        ("noise", 25.1, Box::new(move |_| Some([noise(256), noise(256), noise(256)]))),
    ];
    for (name, most_bits, mut color) in kinds {
        let colors: Vec<_> = (0..10_000 + 37).map(&mut color).collect();
        let buf = ColorsBuf::new(ColorMode::Blocks, colors.iter().copied()).unwrap();
        let bits = 32.0 * buf.as_colors().words().len() as f64 / colors.len() as f64;
        assert!(bits <= most_bits, "{name}: {bits} bits");
        let view = Colors::new(buf.as_colors().words()).unwrap();
        for (first, block) in (0..).step_by(64).zip(colors.chunks(64)) {
            let (mut error, mut count) = (0.0, 0);
            for (rank, color) in (first..).zip(block) {
                assert_eq!(view.get(rank), decoded(view.words(), rank), "{name}, rank {rank}");
                for (found, expected) in view.get(rank).iter().zip(color.iter().flatten()) {
                    let off = f64::from(found.abs_diff(*expected));
                    error += off * off;
                    count += 1;
                }
            }
            assert!(error <= 8.0 * f64::from(count), "{name}: a block is off by {error} for {count}");
        }
        // As they are, they are the very same.
        let raw = ColorsBuf::new(ColorMode::Raw, colors.iter().copied()).unwrap();
        let raw = Colors::new(raw.as_colors().words()).unwrap();
        assert!((0..).zip(&colors).all(|(rank, color)| color.is_none_or(|color| raw.get(rank) == color)), "{name}");
        let end = colors.len() as u64;
        assert_eq!([view.get(end), raw.get(end), view.get(u64::MAX)], [[255; 3]; 3]);
    }
}

/// Every wrong word of colours is refused or changes nothing but colours.
#[test]
fn damaged_colors_are_refused_or_harmless() {
    for mode in [ColorMode::Blocks, ColorMode::Raw] {
        let colors = (0..200u64).map(|i| Some([i as u8, (i * i) as u8, if i < 100 { 3 } else { (i * 77) as u8 }]));
        let words = ColorsBuf::new(mode, colors).unwrap().into_words();
        let mut refused = 0;
        for at in 0..words.len() {
            for bit in 0..32 {
                let mut damaged = words.clone();
                damaged[at] ^= 1 << bit;
                match Colors::new(&damaged) {
                    Ok(view) => (0..260).for_each(|rank| _ = view.get(rank)),
                    Err(_) => refused += 1,
                }
            }
            assert!(Colors::new(&words[..at]).is_err(), "{mode:?} cut to {at} words");
        }
        assert!(refused >= 32 * 4, "{mode:?}: only {refused} refused");
    }
}
