//! Occupancy and material trees on the adapter: every answer must be the core's, also for empty voxels and outside.

use std::collections::BTreeMap;

use voxdag::build::DagBuilder;
use voxdag::file::Parts;
use voxdag::grid::{Bounds, UpAxis};
use voxdag::materials::AnyMaterials;
use voxdag::tree::TreeBuilder;
use voxdag::{Grid, Material, Morton, wgsl};
use voxdag_oracle::rng::Rng;

use crate::gpu::Gpu;
use crate::rays::WORDS;

/// Materials of voxels in cubes of all depths, with few and many of them in bricks and by halves; how many were wrong.
pub fn check(gpu: &Gpu) -> u64 {
    let pipeline = gpu.pipeline("ask_voxels");
    let (mut asked, mut wrong) = (0, 0);
    for seed in 0..36 {
        let mut rng = Rng::new(seed);
        let depth = seed as u8 % 9;
        let ids = [1, 2, 3, 5, 20, 70][rng.below(6) as usize];
        // Many patterns need wide places.
        let voxels = if depth == 8 { 200_000 } else { rng.below(20_000) };
        let noise = rng.below(2) == 0;
        let map: BTreeMap<u64, u16> = (0..voxels)
            .map(|_| {
                let v = [(); 3].map(|()| rng.below(1 << depth) as u32);
                let id =
                    if noise { rng.below(ids) as u16 } else { ((v[0] + 2 * v[1]) / 8 * 12347 % ids as u32) as u16 };
                (Morton::encode(v).expect("within the cube").0, id)
            })
            .collect();
        let words = file(depth, &map);
        let uniform = wgsl::scene(&words).expect("a DAG and a tree");
        let scene = voxdag::file::read(&words).expect("as written");

        let outside = [[1u32 << depth; 3], [u32::MAX; 3], [0, 1 << 21, 0]];
        let random = (0..20_000).map(|_| [(); 3].map(|()| rng.below(1 << depth) as u32));
        let places: Vec<[u32; 3]> =
            map.keys().map(|&code| Morton(code).decode()).chain(random).chain(outside).collect();
        let questions: Vec<u32> =
            places.iter().flat_map(|p| p.iter().copied().chain([0; WORDS - 3]).collect::<Vec<_>>()).collect();
        let groups = [places.len().div_ceil(64) as u32, 1];
        let uploaded = gpu.scene(&words, &uniform);
        let input = (&questions[..], wgpu::BufferUsages::STORAGE);
        let answers = gpu.run(&pipeline, &uploaded, input, groups, questions.len());
        for (place, answer) in places.iter().zip(answers.as_chunks::<WORDS>().0) {
            let code = Morton::encode(*place);
            let filled = code.is_some_and(|code| map.contains_key(&code.0));
            let id = code.map_or(0, |code| voxdag::Materials::id(&scene.materials, code));
            if [answer[0], answer[1]] != [u32::from(filled), u32::from(id)] {
                wrong += 1;
                if wrong == 1 {
                    println!("  first: seed {seed}, {place:?}: {:?}, expected {filled}, {id}", &answer[..2]);
                }
            }
            asked += 1;
        }
    }
    println!("occupancy and material of {asked} voxels: {wrong} wrong\n");
    wrong
}

/// A file of the map's voxels with a tree of their materials.
fn file(depth: u8, map: &BTreeMap<u64, u16>) -> Vec<u32> {
    let mut dag = DagBuilder::new(depth).expect("a depth");
    let mut tree = TreeBuilder::new(depth).expect("a depth");
    let mut bricks: BTreeMap<u64, (u64, Vec<u16>)> = BTreeMap::new();
    for (&code, &id) in map {
        let (mask, ids) = bricks.entry(code & !63).or_default();
        *mask |= 1 << (code & 63);
        ids.push(id);
    }
    for (&code, (mask, ids)) in &bricks {
        dag.push(Morton(code), *mask).expect("in order");
        tree.push(Morton(code), *mask, ids).expect("in order");
    }
    let (dag, tree) = (dag.finish().expect("room"), tree.finish().expect("room"));
    let materials = [Material::GREY; 70];
    let parts = Parts {
        grid: Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: 1 << depth },
        bounds: Bounds { min: [0.0; 3], max: [1.0; 3] },
        up: UpAxis::Y,
        metres_per_unit: 0.0,
        geometry: dag.dag().into(),
        voxel_materials: AnyMaterials::Tree(tree.tree()),
        colors: None,
        materials: &materials,
        names: &[""; 70],
    };
    parts.to_vec().expect("a file")
}
