//! The loader of `.vxd` files: any words are refused, or make a scene that is safe to use.

use voxdag::build::DagBuilder;
use voxdag::camera::Camera;
use voxdag::dag::{Dag, HEADER};
use voxdag::file::{self, Parts, Scene};
use voxdag::grid::{Bounds, UpAxis};
use voxdag::materials::{AnyMaterials, Single};
use voxdag::normal::{NormalKind, normal};
use voxdag::render::{Samples, Settings, Supersample, View, render_rows};
use voxdag::table::{Entry, TableBuf};
use voxdag::trace::{Arithmetic, Query, TopBuf, Tracer};
use voxdag::{Grid, Material, Materials, Morton};

use super::Bytes;
use super::traversal::{Rule, SelfSimilar};
use crate::octree::count_voxels;

/// Words are read as a scene; what is accepted is traced, counted, drawn, joined, and written again.
///
/// Byte 0 chooses (modulo 6): 0, the rest are the words of a file; else a file of ours is changed, 1 to 5 being small and
/// large, with and without a table. A change takes a byte and a u16 for a place (modulo the length); by the byte (modulo 6):
/// 0 to 2 set, add, or xor a u32 that follows; 3 take out the word; 4 insert a u32; 5 copy the word at another u16 there. Then
/// lengths and checksums are made right, as far as the section table makes sense, unless bit 7 of byte 0 is set.
pub fn file(data: &[u8]) {
    let mut bytes = Bytes(data);
    let choice = bytes.u8();
    let mut words = match choice & 127 {
        0 => bytes.0.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
        template => {
            let mut words = template_file(template % 6);
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
        2 => (4, vec![Rule { mask: 0x96, octants: 0x1001_0110 }, Rule { mask: 0x17, octants: 0 }]),
        3 => (1, vec![Rule { mask: 0x0f, octants: 0 }]),
        4 => (21, vec![Rule { mask: 0xff, octants: 0 }]),
        _ => (21, vec![Rule { mask: 0x69, octants: 0x0010_1000 }, Rule { mask: 0x55, octants: 0x0100_0010 }]),
    };
    let words = SelfSimilar { rules, depth }.words();
    let mut table = TableBuf::new(8, number == 1).unwrap();
    if depth < 5 {
        let voxels = Dag::new(&words).unwrap().voxels().zip(0..);
        let entry = |i: u16| Entry { material: i % 2, normal: Some([0.0, 0.6, -0.8]) };
        table.insert_all(voxels.map(|(voxel, i)| (voxel, entry(i)))).unwrap();
    }
    let single = AnyMaterials::Single(Single(1));
    let parts = Parts {
        grid: Grid { origin: [0.5, -1.0, 2.0], voxel_size: 0.25, resolution: 1 << depth },
        bounds: Bounds { min: [0.5, -1.0, 2.0], max: [2.0, 2.0, 4.0] },
        up: if number.is_multiple_of(2) { UpAxis::Y } else { UpAxis::Z },
        metres_per_unit: 0.0,
        geometry: Dag::new(&words).unwrap().into(),
        voxel_materials: if number <= 2 { AnyMaterials::Table(table.as_table()) } else { single },
        materials: &[Material::GREY; 2],
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
    let dag = scene.geometry.as_dag().expect("a plain DAG");
    assert!(scene.grid.checked().is_ok() && scene.grid.depth() == dag.depth());

    // The voxels, as far as they can be counted off.
    let voxels: Vec<_> = dag.voxels().take(100).collect();
    assert!(voxels.is_sorted() && voxels.iter().all(|&voxel| dag.contains(voxel)));
    let stats = dag.stats().expect("memory for counts");
    assert_eq!(count_voxels(dag.words()), stats.voxels.into(), "number of voxels");
    assert!(stats.voxels >= voxels.len() as u64 && (voxels.len() == 100 || stats.voxels == voxels.len() as u64));

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
    if dag.depth() <= 12 || stats.nodes() < 40 {
        trace_and_draw(scene, &palette);
    }

    // Another builder takes it whole.
    let mut builder = DagBuilder::new(dag.depth()).unwrap();
    builder.append(Morton(0), &dag).expect("the same cube");
    let joined = builder.finish().expect("a DAG");
    assert!(Dag::new(joined.words()).is_ok(), "a DAG was joined to none");
    assert!(joined.dag().voxels().take(100).eq(voxels.iter().copied()), "a DAG was joined to another");
    assert!(joined.words().len() <= dag.words().len().max(HEADER));

    // What was read can be written, and is read as the same again.
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    let parts = Parts {
        grid: scene.grid,
        bounds: scene.bounds,
        up: scene.up,
        metres_per_unit: scene.metres_per_unit,
        geometry: scene.geometry,
        voxel_materials: scene.materials,
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

fn trace_and_draw(scene: &Scene<'_>, palette: &[Material]) {
    let dag = scene.geometry.as_dag().expect("a plain DAG");
    let size = f64::from(1u32 << dag.depth());
    let top = TopBuf::new(&dag, 2).unwrap();
    let tracer = Tracer::with_top(dag, top.as_top()).expect("the grid is this DAG's");
    for dir in [[1.0, 0.4, 0.3], [-1.0, 1.0, 1.0], [0.0, 0.0, -1.0]] {
        let query = Query::new(core::array::from_fn(|i| (0.37 - 2.0 * dir[i]) * size), dir);
        let hit = tracer.trace(Arithmetic::Exact, &query);
        assert_eq!(dag.trace(&query), hit, "with and without a top grid");
        assert_eq!(tracer.occluded(Arithmetic::Exact, &query), hit.is_some());
        assert!(tracer.hits(&query).take(50).all(|hit| dag.contains(hit.voxel)));
        if let Some(hit) = hit {
            normal(&Tracer::new(dag), scene.materials, &hit, dir, NormalKind::Stored);
            normal(&Tracer::new(dag), scene.materials, &hit, dir, NormalKind::Plane3);
        }
    }
    let camera = Camera::framing(&scene.bounds, scene.up);
    let lights = [camera.headlight(scene.bounds.radius())];
    let view = View { tracer, materials: scene.materials, palette, grid: scene.grid, camera, lights: &lights };
    // A box at the end of the range of numbers has no camera; any other makes a picture.
    let mut pixels = [0; 16];
    for supersample in [Supersample::near(dag, &camera, 0.5), Supersample::Adaptive { degrees: 2.0 }] {
        let settings = Settings { width: 4, height: 4, samples: Samples::Sixteen, supersample, ..Settings::default() };
        if render_rows(&view, &settings, 0..4, &mut pixels).is_ok() {
            assert!(pixels.iter().all(|pixel| pixel >> 24 == 255));
        }
    }
}
