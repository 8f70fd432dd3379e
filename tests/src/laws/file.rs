//! The loader of `.vxd` files: any words are refused, or make a scene that is safe to use.

use voxdag::build::DagBuilder;
use voxdag::camera::Camera;
use voxdag::colors::{ColorMode, Colored, ColorsBuf};
use voxdag::dag::{Dag, HEADER};
use voxdag::file::{self, Parts, Scene};
use voxdag::grid::{Bounds, UpAxis};
use voxdag::layout::AnyGeometry;
use voxdag::materials::{AnyMaterials, Single};
use voxdag::normal::{NormalKind, normal};
use voxdag::rank::{AnyRank, MoxelDagBuf, OffsetsBuf, Prefix, Rank, Totals};
use voxdag::ranked::{Packed, PackedBuf, Ranked};
use voxdag::render::{Samples, Settings, Supersample, View, render_rows};
use voxdag::shade::Light;
use voxdag::ssvdag::{Ssvdag, SsvdagBuf};
use voxdag::table::{Entry, TableBuf};
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::{Geometry, Grid, Material, Materials, Morton, match_geometry};

use super::Bytes;
use super::traversal::{Rule, SelfSimilar};
use crate::mirrors;
use crate::octree::{VoxelSet, count_voxels};

/// Words are read as a scene; what is accepted is traced, counted, drawn, joined, and written again.
///
/// Byte 0 chooses: 0, the rest are the words of a file; else a file of ours is changed, small and large, in both
/// layouts, with one material, a table, or ids by rank (modulo 12), or from 96 on (modulo 4) with colours. A change takes a byte and a u16 for a place (modulo the length); by the byte (modulo 6):
/// 0 to 2 set, add, or xor a u32 that follows; 3 take out the word; 4 insert a u32; 5 copy the word at another u16 there. Then
/// lengths and checksums are made right, as far as the section table makes sense, unless bit 7 of byte 0 is set.
pub fn file(data: &[u8]) {
    let mut bytes = Bytes(data);
    let choice = bytes.u8();
    let mut words = match choice & 127 {
        0 => bytes.0.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
        template => {
            let mut words = template_file(if template < 96 { template % 12 } else { 12 + template % 4 });
            while !bytes.is_empty() && words.len() < 10_000 {
                change(&mut words, &mut bytes);
            }
            words
        }
    };
    if choice & 128 == 0 {
        mend(&mut words);
    }
    match file::read(&words) {
        Ok(scene) => use_all(&scene),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A file of ours.
fn template_file(number: u8) -> Vec<u32> {
    let (depth, rules) = match number {
        1 => (2, vec![Rule { mask: 0x81, octants: 0 }]),
        2 | 6 | 8 | 12.. => (4, vec![Rule { mask: 0x96, octants: 0x1001_0110 }, Rule { mask: 0x17, octants: 0 }]),
        3 | 11 => (1, vec![Rule { mask: 0x0f, octants: 0 }]),
        4 | 9 => (21, vec![Rule { mask: 0xff, octants: 0 }]),
        _ => (21, vec![Rule { mask: 0x69, octants: 0x0010_1000 }, Rule { mask: 0x55, octants: 0x0100_0010 }]),
    };
    let words = SelfSimilar { rules, depth }.words();
    let dag = Dag::new(&words).unwrap();
    let mut table = TableBuf::new(8, number == 1).unwrap();
    let mut ids = PackedBuf::new().unwrap();
    if depth < 5 {
        let entry = |i: u16| Entry { material: i % 2, normal: Some([0.0, 0.6, -0.8]) };
        table.insert_all(dag.voxels().zip(0..).map(|(voxel, i)| (voxel, entry(i)))).unwrap();
        (0..dag.voxels().count()).for_each(|i| ids.push(i as u16 % 2).unwrap());
    }
    let (ssvdag, prefix) = (SsvdagBuf::build(&dag).unwrap(), Prefix::build(&dag).unwrap());
    let totals = Totals::build(&ssvdag.ssvdag()).unwrap();
    let (geometry, rank) = match number {
        7 | 8 | 10 | 11 | 13 | 15 => {
            let totals = Totals::new(ssvdag.ssvdag(), &totals).unwrap();
            (AnyGeometry::Ssvdag(ssvdag.ssvdag()), AnyRank::Totals(totals))
        }
        _ => (dag.into(), AnyRank::Prefix(Prefix::new(dag, &prefix).unwrap())),
    };
    // Where there are too many voxels to list, their ids are all 0 and take no bits.
    let mut ids = ids.into_words();
    let voxels = rank.count();
    (ids[2], ids[3]) = (voxels as u32, (voxels >> 32) as u32);
    let mode = if number < 14 { ColorMode::Blocks } else { ColorMode::Raw };
    // Alike but for a few, of which some do not matter.
    let color = |i: u64| (i % 5 != 3).then(|| [i as u8, 200, if i > 100 { (i * i) as u8 } else { 7 }]);
    let colors = (number >= 12).then(|| ColorsBuf::new(mode, (0..voxels).map(color)).unwrap());
    let textured = Material { textured: colors.is_some(), ..Material::GREY };
    let parts = Parts {
        grid: Grid { origin: [0.5, -1.0, 2.0], voxel_size: 0.25, resolution: 1 << depth },
        bounds: Bounds { min: [0.5, -1.0, 2.0], max: [2.0, 2.0, 4.0] },
        up: if number.is_multiple_of(2) { UpAxis::Y } else { UpAxis::Z },
        metres_per_unit: 0.0,
        geometry,
        voxel_materials: match number {
            0..=2 | 11 | 12 => AnyMaterials::Table(table.as_table()),
            3..=5 | 7 | 13 => AnyMaterials::Single(Single(1)),
            _ => AnyMaterials::Ranked(Ranked::new(rank, Packed::new(&ids).unwrap()).unwrap()),
        },
        colors: colors.as_ref().map(|colors| Colored::new(rank, colors.as_colors()).unwrap()),
        materials: &[Material::GREY, textured],
        names: &["grau", "wei\u{df}"],
    };
    parts.to_vec().expect("a good file")
}

fn change(words: &mut Vec<u32>, bytes: &mut Bytes<'_>) {
    if words.is_empty() {
        words.push(0);
    }
    let (kind, place) = (bytes.u8() % 6, usize::from(bytes.u16()) % words.len());
    match kind {
        0 => words[place] = bytes.u32(),
        1 => words[place] = words[place].wrapping_add(bytes.u32()),
        2 => words[place] ^= bytes.u32(),
        3 => _ = words.remove(place),
        4 => words.insert(place, bytes.u32()),
        _ => words[place] = words[usize::from(bytes.u16()) % words.len()],
    }
}

/// Makes the length and the checksums right.
fn mend(words: &mut [u32]) {
    let length = words.len() as u32;
    let Some(rows) = words.get(7).map(|&n| n.min(1000) as usize) else { return };
    words[2] = length;
    let end = 32 + 6 * rows;
    if end >= words.len() {
        return;
    }
    for row in (32..end).step_by(6) {
        let (offset, length) = (words[row + 2] as usize, words[row + 4] as usize);
        if let Some(section) = offset.checked_add(length).and_then(|end| words.get(offset..end)) {
            words[row + 1] = crc(section);
        }
    }
    words[end] = crc(&words[..end]);
}

/// CRC-32 by its definition, four bits at a time.
fn crc(words: &[u32]) -> u32 {
    const TABLE: [u32; 16] = {
        let mut table = [0; 16];
        let mut i = 0;
        while i < 16 {
            let mut crc = i as u32;
            let mut bit = 0;
            while bit < 4 {
                crc = crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 };
                bit += 1;
            }
            table[i] = crc;
            i += 1;
        }
        table
    };
    let nibble = |crc: u32, nibble: u32| crc >> 4 ^ TABLE[((crc ^ nibble) & 15) as usize];
    !words.iter().fold(u32::MAX, |crc, &word| (0..8).fold(crc, |crc, i| nibble(crc, word >> (4 * i))))
}

/// Asks a scene everything there is to ask: nothing panics, and what can be compared agrees.
fn use_all(scene: &Scene<'_>) {
    match_geometry!(scene.geometry, geometry => use_all_of(scene, geometry));
}

fn use_all_of<G: Geometry>(scene: &Scene<'_>, geometry: G) {
    assert!(scene.grid.checked().is_ok() && scene.grid.depth() == geometry.depth());

    // The voxels, as far as they can be counted off.
    let voxels: Vec<_> = geometry.voxels().take(100).collect();
    assert!(voxels.is_sorted() && voxels.iter().all(|&voxel| geometry.contains(voxel)));
    let stats = scene.geometry.stats().expect("memory for counts");
    assert!(stats.voxels >= voxels.len() as u64 && (voxels.len() == 100 || stats.voxels == voxels.len() as u64));
    if let Some(rank) = scene.materials.rank() {
        assert_eq!(rank.count(), stats.voxels);
        assert!(voxels.iter().zip(0..).all(|(&voxel, i)| rank.rank(voxel) == Some(i)));
    }

    // Materials and names.
    for &voxel in voxels.iter().take(20).chain(&[Morton(u64::MAX), Morton(0)]) {
        let id = scene.materials.id(voxel);
        assert!(usize::from(id) < scene.material_count());
        let normal = scene.materials.normal(voxel);
        assert!(normal.is_none_or(|n| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5), "{normal:?}");
    }
    let count = scene.material_count();
    let ids = || (0..count).map(|id| id as u16);
    let names: Vec<_> = ids().map(|id| scene.name(id).to_string()).collect();
    assert!(ids().zip(&names).all(|(id, name)| scene.name(id) == name.as_str()));
    let palette: Vec<_> = ids().map(|id| scene.material(id)).collect();
    assert!(palette.iter().all(|material| material.checked() == Ok(*material)));

    // Rays, normals and a picture; only so large that a ray through a fractal ends soon.
    if geometry.depth() <= 12 || stats.nodes() < 40 {
        trace_and_draw(scene, geometry, &palette);
    }

    match scene.geometry {
        AnyGeometry::Dag(dag) => rebuild(dag, stats.voxels, &voxels),
        AnyGeometry::Ssvdag(ssvdag) if stats.voxels < 5000 => reread(ssvdag, stats.voxels),
        _ => {}
    }

    // What was read can be written, and is read as the same again.
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    let parts = Parts {
        grid: scene.grid,
        bounds: scene.bounds,
        up: scene.up,
        metres_per_unit: scene.metres_per_unit,
        geometry: scene.geometry,
        voxel_materials: scene.materials,
        colors: scene.colors,
        materials: &palette,
        names: &names,
    };
    let again = parts.to_vec().expect("what was read can be written");
    let again = file::read(&again).expect("what was written can be read");
    assert_eq!((again.grid, again.bounds, again.up), (scene.grid, scene.bounds, scene.up));
    assert_eq!(again.geometry.words(), scene.geometry.words());
    assert!(ids().zip(&palette).all(|(id, material)| again.material(id) == *material));
    assert!(ids().zip(names).all(|(id, name)| again.name(id) == name));
}

/// What is made of a DAG has its voxels, of which some are given, in as many words or fewer.
fn rebuild(dag: Dag<'_>, count: u64, voxels: &[Morton]) {
    assert_eq!(count_voxels(dag.words()), count.into(), "number of voxels");
    let mut builder = DagBuilder::new(dag.depth()).unwrap();
    builder.append(Morton(0), &dag).expect("the same cube");
    let joined = builder.finish().expect("a DAG");
    assert!(Dag::new(joined.words()).is_ok(), "a DAG was joined to none");
    assert!(joined.dag().voxels().take(100).eq(voxels.iter().copied()), "a DAG was joined to another");
    assert!(joined.words().len() <= dag.words().len().max(HEADER));

    let merged = SsvdagBuf::build(&dag).expect("an SSVDAG");
    assert_eq!(merged.ssvdag().stats().unwrap().voxels, count, "an SSVDAG of other voxels");
    let (offsets, moxels) = (OffsetsBuf::build(&dag).unwrap(), MoxelDagBuf::build(&dag).unwrap());
    let (offsets, moxels) = (offsets.as_offsets(), moxels.as_moxel_dag());
    assert_eq!([offsets.count(), moxels.count()], [count; 2]);
    for (&voxel, i) in voxels.iter().zip(0..) {
        assert!(merged.ssvdag().contains(voxel));
        assert_eq!([offsets.rank(voxel), moxels.rank(voxel)], [Some(i); 2], "rank of {voxel:?}");
    }
}

/// An SSVDAG's voxels are those that its words mean by the documentation, and can be packed as tightly.
fn reread(ssvdag: Ssvdag<'_>, count: u64) {
    let set = VoxelSet::new(ssvdag.voxels().map(Morton::decode));
    assert_eq!(set.codes().len() as u64, count);
    assert_eq!(mirrors::voxels(ssvdag.words()), set, "the words mean other voxels by the documentation");
    let plain = set.words(ssvdag.depth());
    let again = SsvdagBuf::build(&Dag::new(&plain).unwrap()).unwrap();
    assert!(again.ssvdag().stored() <= ssvdag.stored(), "a hostile one is smaller");
}

fn trace_and_draw<G: Geometry>(scene: &Scene<'_>, geometry: G, palette: &[Material]) {
    let size = f64::from(1u32 << geometry.depth());
    let top = TopBuf::new(&geometry, 2).unwrap();
    let (plain, tracer) = (Tracer::new(geometry), Tracer::with_top(geometry, top.as_top()).expect("its own grid"));
    for dir in [[1.0, 0.4, 0.3], [-1.0, 1.0, 1.0], [0.0, 0.0, -1.0]] {
        let query = Query::new(core::array::from_fn(|i| (0.37 - 2.0 * dir[i]) * size), dir);
        let hit = tracer.trace(Arithmetic::Exact, &query);
        assert_eq!(plain.trace(Arithmetic::Exact, &query), hit, "with and without a top grid");
        assert_eq!(tracer.occluded(Arithmetic::Exact, &query), hit.is_some());
        assert!(tracer.hits(&query).take(50).all(|hit| geometry.contains(hit.voxel)));
        if let Some(hit) = hit {
            normal(&plain, scene.materials, &hit, dir, NormalKind::Stored);
            normal(&plain, scene.materials, &hit, dir, NormalKind::Plane3);
        }
    }
    let camera = Camera::framing(&scene.bounds, scene.up);
    let lights = [Light { shadow: true, ..camera.headlight(scene.bounds.radius()) }];
    let view = View { tracer, materials: scene.looks(), palette, grid: scene.grid, camera, lights: &lights };
    // A box at the end of the range of numbers has no camera; any other makes a picture.
    let mut pixels = [0; 16];
    for supersample in [Supersample::near(geometry, &camera, 0.5), Supersample::Adaptive { degrees: 2.0 }] {
        let settings = Settings { width: 4, height: 4, samples: Samples::Sixteen, supersample, ..Settings::default() };
        if render_rows(&view, &settings, 0..4, &mut pixels).is_ok() {
            assert!(pixels.iter().all(|pixel| pixel >> 24 == 255));
        }
    }
}
