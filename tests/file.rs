//! Laws of the `.vxd` file: it comes back as it was written, version 1 loads for ever, `docs/format.md` shows the truth,
//! and whatever words are read either are refused or make a scene that is safe to use.

use voxdag::Geometry;
use voxdag::build::DagBuilder;
use voxdag::colors::{ColorMode, Colored, ColorsBuf};
use voxdag::dag::{Dag, DagError};
use voxdag::file::{self, LoadError, Parts, Scene, Section, WriteError};
use voxdag::grid::UpAxis;
use voxdag::grid::{Bounds, Grid};
use voxdag::layout::AnyGeometry;
use voxdag::materials::{AnyMaterials, Materials, Single};
use voxdag::rank::{AnyRank, Prefix, Rank, Totals};
use voxdag::ranked::{PackedBuf, Ranked};
use voxdag::ssvdag::SsvdagBuf;
use voxdag::table::{Entry, Table, TableBuf};
use voxdag::tree::{TreeBuf, TreeBuilder};
use voxdag::{Material, Morton};

const FIXTURE: &[u8] = include_bytes!("fixtures/v1.vxd");
const FIXTURE_2: &[u8] = include_bytes!("fixtures/v2.vxd");
const FIXTURE_3: &[u8] = include_bytes!("fixtures/v3.vxd");
const FIXTURE_4: &[u8] = include_bytes!("fixtures/v4.vxd");
const FORMAT: &str = include_str!("../docs/format.md");
const VOXELS: [[u32; 3]; 3] = [[0, 0, 0], [1, 0, 0], [3, 3, 3]];
const NAMES: [&str; 2] = ["red", "w\u{00e4}nde"];

/// A DAG of depth 2 that is one brick.
fn dag_words() -> Vec<u32> {
    let mask = VOXELS.iter().fold(0u64, |mask, &p| mask | 1 << Morton::encode(p).unwrap().0);
    let mut words = vec![0; 24];
    (words[0], words[1]) = (2, 1);
    words[2..22].fill(26);
    words.extend([mask as u32, (mask >> 32) as u32]);
    words
}

fn table_words(normals: bool) -> Vec<u32> {
    let mut table = TableBuf::new(3, normals).unwrap();
    let normal = Some([0.0, 1.0, 0.0]);
    let entries = VOXELS.iter().zip([0, 0, 1]).map(|(&p, material)| (Morton::encode(p).unwrap(), material));
    table.insert_all(entries.map(|(voxel, material)| (voxel, Entry { material, normal }))).unwrap();
    table.into_words()
}

fn materials() -> [Material; 2] {
    let red = Material { diffuse: [0.5, 0.0, 0.0], specular: [0.25; 3], shininess: 32, illum: 2, ..Material::GREY };
    [red, Material { opacity: 0.75, refraction: 1.5, ..Material::GREY }]
}

/// The tiny scene of the fixture and of `docs/format.md`.
fn parts<'a>(dag: &'a [u32], table: Option<&'a [u32]>, materials: &'a [Material]) -> Parts<'a> {
    Parts {
        grid: Grid { origin: [-1.0, 0.0, 2.5], voxel_size: 0.5, resolution: 4 },
        bounds: Bounds { min: [-1.0, 0.0, 2.5], max: [1.0, 2.0, 4.5] },
        up: UpAxis::Z,
        metres_per_unit: 0.001,
        geometry: Dag::new(dag).unwrap().into(),
        voxel_materials: match table {
            Some(words) => AnyMaterials::Table(Table::new(words).unwrap()),
            None => AnyMaterials::Single(Single(1)),
        },
        colors: None,
        materials,
        names: &NAMES[..materials.len()],
    }
}

fn tiny() -> Vec<u32> {
    parts(&dag_words(), Some(&table_words(false)), &materials()).to_vec().unwrap()
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn assert_tiny(scene: &Scene<'_>) {
    assert_eq!(scene.grid, Grid { origin: [-1.0, 0.0, 2.5], voxel_size: 0.5, resolution: 4 });
    assert_eq!(scene.bounds, Bounds { min: [-1.0, 0.0, 2.5], max: [1.0, 2.0, 4.5] });
    assert_eq!((scene.up, scene.metres_per_unit), (UpAxis::Z, 0.001));
    assert_eq!(scene.geometry.voxels().map(Morton::decode).collect::<Vec<_>>(), VOXELS);
    let ids = |p| scene.materials.id(Morton::encode(p).unwrap());
    assert_eq!(VOXELS.map(ids), [0, 0, 1]);
    assert_eq!(ids([2, 2, 2]), 0, "a voxel that is not there has material 0");
    assert_eq!([scene.material(0), scene.material(1)], materials());
    assert_eq!(scene.material(2), Material::GREY);
    assert_eq!(scene.material_count(), 2);
    assert!(scene.name(0) == "red" && scene.name(1) == NAMES[1] && scene.name(2).is_empty());
    assert_eq!(scene.name(1).to_string(), NAMES[1]);
}

/// CRC-32 bit by bit, from its definition.
fn crc(words: &[u32]) -> u32 {
    let step = |crc: u32, byte: u8| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| c >> 1 ^ if c & 1 == 1 { 0xedb8_8320 } else { 0 })
    };
    !bytes(words).into_iter().fold(u32::MAX, step)
}

/// Makes the checksums of damaged words right, as far as the section table still makes sense.
fn mend(words: &mut [u32]) {
    let end = 32 + 6 * words[7].min(6) as usize;
    for row in (32..end).step_by(6) {
        let (offset, length) = (words[row + 2] as usize, words[row + 4] as usize);
        if let Some(section) = offset.checked_add(length).and_then(|end| words.get(offset..end)) {
            words[row + 1] = crc(section);
        }
    }
    words[end] = crc(&words[..end]);
}

/// Asks a scene everything there is to ask.
fn use_it(scene: &Scene<'_>) {
    assert!(scene.grid.checked().is_ok() && scene.grid.depth() == scene.geometry.depth());
    for voxel in scene.geometry.voxels().take(100).chain([Morton(u64::MAX)]) {
        let id = scene.materials.id(voxel);
        assert!(usize::from(id) < scene.material_count());
        assert!(scene.material(id).checked().is_ok());
        assert!(scene.materials.normal(voxel).is_none_or(|n| n.iter().all(|c| c.abs() <= 1.0)));
    }
    for id in [0, 1, 2, u16::MAX] {
        assert_eq!(scene.name(id).to_string().into_bytes(), scene.name(id).bytes().collect::<Vec<_>>());
        assert!(scene.material(id).checked().is_ok());
    }
}

/// The same scene with a tree, which takes version 2.
fn tiny_2(tree: &TreeBuf) -> Vec<u32> {
    let (dag, materials) = (dag_words(), materials());
    let parts = Parts { voxel_materials: AnyMaterials::Tree(tree.tree()), ..parts(&dag, None, &materials) };
    parts.to_vec().unwrap()
}

fn tree() -> TreeBuf {
    let mut builder = TreeBuilder::new(2).unwrap();
    let mask = VOXELS.iter().fold(0u64, |mask, &p| mask | 1 << Morton::encode(p).unwrap().0);
    builder.push(Morton(0), mask, &[0, 0, 1]).unwrap();
    builder.finish().unwrap()
}

/// Some voxels of a cube of depth 5, as an SSVDAG with ids by rank, which take version 3.
fn scattered() -> Vec<u32> {
    let codes: Vec<u64> = (0..1 << 15).step_by(97).collect();
    let [_, ssvdag] = ranked(5, &codes);
    ssvdag
}

/// The material of a voxel in [`ranked`] scenes.
fn id_of(code: u64) -> u16 {
    u16::from(code % 7 > 2)
}

/// Files of the voxels with ids by rank, as a DAG and as an SSVDAG.
fn ranked(depth: u8, codes: &[u64]) -> [Vec<u32>; 2] {
    let mut builder = DagBuilder::new(depth).unwrap();
    for brick in codes.chunk_by(|a, b| a >> 6 == b >> 6) {
        builder.push(Morton(brick[0] & !63), brick.iter().map(|code| 1 << (code & 63)).sum()).unwrap();
    }
    let dag = builder.finish().unwrap();
    let ssvdag = SsvdagBuf::build(&dag.dag()).unwrap();
    let entries = codes.iter().map(|&code| (Morton(code), Entry { material: id_of(code), normal: None }));
    let ids = PackedBuf::from_entries(entries).unwrap();
    let (prefix, totals) = (Prefix::build(&dag.dag()).unwrap(), Totals::build(&ssvdag.ssvdag()).unwrap());
    let layouts = [
        (dag.dag().into(), AnyRank::Prefix(Prefix::new(dag.dag(), &prefix).unwrap())),
        (AnyGeometry::Ssvdag(ssvdag.ssvdag()), AnyRank::Totals(Totals::new(ssvdag.ssvdag(), &totals).unwrap())),
    ];
    let all = materials();
    let made = layouts.map(|(geometry, rank)| {
        let voxel_materials = AnyMaterials::Ranked(Ranked::new(rank, ids.as_packed()).unwrap());
        let grid = Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: 1 << depth };
        Parts { grid, geometry, voxel_materials, ..parts(dag.words(), None, &all) }
    });
    // Ranks of one layout are none of the other's.
    let mixed = Parts { geometry: made[1].geometry, ..made[0] };
    assert_eq!(mixed.to_vec(), Err(WriteError::Representation));
    made.map(|parts| parts.to_vec().unwrap())
}

/// To make the fixtures again after a new version: `VOXDAG_BLESS=1 cargo test -p voxdag-oracle --test file`, into a file
/// of a new name. The one of version 1 must never change.
#[test]
fn version_1_loads_for_ever() {
    if std::env::var_os("VOXDAG_BLESS").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/new.vxd");
        std::fs::write(path, bytes(&tiny())).unwrap();
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/new_2.vxd");
        std::fs::write(path, bytes(&tiny_2(&tree()))).unwrap();
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/new_3.vxd");
        std::fs::write(path, bytes(&scattered())).unwrap();
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/new_4.vxd");
        std::fs::write(path, bytes(&painted(ColorMode::Blocks))).unwrap();
    }
    let words = file::words_from_bytes(FIXTURE).unwrap();
    assert_tiny(&file::read(&words).unwrap());
    assert_eq!(bytes(&tiny()), FIXTURE, "the writer changed its words: that takes a new version and a new fixture");
}

#[test]
fn version_2_loads_for_ever() {
    let words = file::words_from_bytes(FIXTURE_2).unwrap();
    assert_tiny(&file::read(&words).unwrap());
    assert_eq!(
        bytes(&tiny_2(&tree())),
        FIXTURE_2,
        "the writer changed its words: that takes a new version and a new fixture"
    );
    // To a reader of version 1 the tree is a section like any other that it does not know.
    let mut older = words;
    older[1] = 1;
    mend(&mut older);
    assert!(matches!(file::read(&older).unwrap().materials, AnyMaterials::Single(Single(0))));
}

/// The scene's voxels with their materials are what they were made of.
fn assert_ranked(words: &[u32], codes: &[u64]) {
    let scene = file::read(words).unwrap();
    let found: Vec<_> = scene.geometry.voxels().map(|voxel| (voxel.0, scene.materials.id(voxel))).collect();
    let expected: Vec<_> = codes.iter().map(|&code| (code, id_of(code))).collect();
    assert_eq!(found, expected);
}

#[test]
fn version_3_loads_for_ever() {
    let words = file::words_from_bytes(FIXTURE_3).unwrap();
    assert_ranked(&words, &(0..1 << 15).step_by(97).collect::<Vec<_>>());
    assert_eq!(
        bytes(&scattered()),
        FIXTURE_3,
        "the writer changed its words: that takes a new version and a new fixture"
    );
    // To a reader of version 2 there is no geometry in it.
    let mut older = words;
    older[1] = 2;
    mend(&mut older);
    assert_eq!(file::read(&older).unwrap_err(), LoadError::Missing { section: Section::Dag });
}

/// The colour of a voxel in [`painted`] scenes.
fn color_of(rank: u64) -> [u8; 3] {
    [(rank * 3) as u8, 200, if rank < 200 { 90 } else { (rank * rank) as u8 }]
}

/// Some voxels of a cube of depth 5 with a tree and colours beside it, which take version 4.
fn painted(mode: ColorMode) -> Vec<u32> {
    let mut builder = DagBuilder::new(5).unwrap();
    let mut tree = TreeBuilder::new(5).unwrap();
    for brick in (0..512).step_by(3) {
        let code = Morton(brick << 6);
        builder.push(code, 0x8000_0100_0000_0011).unwrap();
        tree.push(code, 0x8000_0100_0000_0011, &[0, 1, 1, (brick % 2) as u16]).unwrap();
    }
    let (dag, tree) = (builder.finish().unwrap(), tree.finish().unwrap());
    let counts = Prefix::build(&dag.dag()).unwrap();
    let prefix = Prefix::new(dag.dag(), &counts).unwrap();
    let colors = ColorsBuf::new(mode, (0..prefix.count()).map(|rank| Some(color_of(rank)))).unwrap();
    let mut materials = materials();
    materials[1].textured = true;
    let grid = Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: 32 };
    let good = Parts {
        grid,
        voxel_materials: AnyMaterials::Tree(tree.tree()),
        colors: Some(Colored::new(AnyRank::Prefix(prefix), colors.as_colors()).unwrap()),
        ..parts(dag.words(), None, &materials)
    };
    // Textured materials and colours go together, and the ranks are those of the geometry.
    let without = Parts { colors: None, ..good }.to_vec();
    assert_eq!(without, Err(WriteError::Invalid(LoadError::Material { index: 1, field: "textured" })));
    let ssvdag = SsvdagBuf::build(&dag.dag()).unwrap();
    let mixed = Parts { geometry: AnyGeometry::Ssvdag(ssvdag.ssvdag()), ..good };
    assert_eq!(mixed.to_vec(), Err(WriteError::Representation));
    good.to_vec().unwrap()
}

#[test]
fn version_4_loads_for_ever() {
    let words = file::words_from_bytes(FIXTURE_4).unwrap();
    for (words, slack) in [(&words, 16), (&painted(ColorMode::Raw), 0)] {
        let scene = file::read(words).unwrap();
        assert!(scene.material(1).textured && !scene.material(0).textured);
        for (rank, voxel) in (0..).zip(scene.geometry.voxels()) {
            let (found, expected) = (scene.looks().color(voxel).unwrap(), color_of(rank));
            assert!((0..3).all(|i| found[i].abs_diff(expected[i]) <= slack), "rank {rank}: {found:?} {expected:?}");
        }
    }
    let again = painted(ColorMode::Blocks);
    assert_eq!(bytes(&again), FIXTURE_4, "the writer changed its words: that takes a new version and a new fixture");
    // To a reader of version 3 the colours are a section that it does not know, but the texture a bit that means nothing.
    let mut older = words;
    older[1] = 3;
    mend(&mut older);
    assert_eq!(file::read(&older).unwrap_err(), LoadError::Material { index: 1, field: "textured" });
}

/// Ids by rank over both layouts, as deep as counts of two words: what is written is read, and no count can be wrong.
#[test]
fn ranked_ids_are_read_back() {
    for depth in [0, 2, 5, 11, 21] {
        let last = (1u64 << (3 * u32::from(depth))) - 1;
        let codes = [0, 1, 9, last / 3, last / 2, last - last.min(1), last].map(|code| code & last);
        let codes: Vec<u64> = std::collections::BTreeSet::from(codes).into_iter().collect();
        for words in ranked(depth, &codes) {
            assert_ranked(&words, &codes);
            let counts = (32..).step_by(6).find(|&row| words[row] == 7).unwrap();
            let (first, length) = (words[counts + 2] as usize, words[counts + 4] as usize);
            for at in first..first + length {
                let mut damaged = words.clone();
                damaged[at] ^= 1;
                mend(&mut damaged);
                assert!(matches!(file::read(&damaged), Err(LoadError::Ranks(_))), "depth {depth}, word {at}");
            }
        }
    }
}

#[test]
fn a_scene_has_a_table_or_a_tree() {
    // The tiny scene's words, with the tree's section behind the table's.
    let (first, tree) = (tiny(), tree());
    let (rows, end) = (32..56, 56);
    let mut words = first[..end].to_vec();
    let offset = first.len() as u32 + 6;
    words.extend([5, 0, offset, 0, tree.words().len() as u32, 0, 0]);
    words.extend(&first[end + 1..]);
    words.extend(tree.words());
    for row in rows.step_by(6) {
        words[row + 2] += 6;
    }
    (words[1], words[2], words[7]) = (2, words.len() as u32, 5);
    mend(&mut words);
    assert_eq!(file::read(&words).unwrap_err(), LoadError::Conflict { first: Section::Table, second: Section::Tree });
}

/// The bytes in lines such as `0x0040  00 01 ..  what it is` of the document.
#[test]
fn the_document_shows_the_fixture() {
    let mut shown = Vec::new();
    for line in FORMAT.lines().filter(|line| line.starts_with("0x")) {
        let mut columns = line.split("  ");
        let offset = usize::from_str_radix(&columns.next().unwrap()[2..], 16).unwrap();
        assert_eq!(offset, shown.len(), "{line}");
        shown.extend(columns.next().unwrap().split(' ').map(|byte| u8::from_str_radix(byte, 16).unwrap()));
    }
    assert_eq!(shown, FIXTURE);
}

#[test]
fn what_is_written_is_read() {
    let (dag, all) = (dag_words(), materials());
    for normals in [false, true] {
        let table = table_words(normals);
        let words = parts(&dag, Some(&table), &all).to_vec().unwrap();
        let scene = file::read(&words).unwrap();
        assert_tiny(&scene);
        let stored = scene.materials.normal(Morton(0));
        assert_eq!(stored, normals.then_some([0.0, 1.0, 0.0]));
    }
    let words = parts(&dag, None, &all).to_vec().unwrap();
    let scene = file::read(&words).unwrap();
    assert!(matches!(scene.materials, AnyMaterials::Single(Single(1))));
    use_it(&scene);
}

#[test]
fn the_largest_list_of_materials_is_read() {
    let (dag, many) = (dag_words(), vec![Material::GREY; 1 << 16]);
    let names: Vec<_> = (0..many.len()).map(|i| i.to_string()).collect();
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    let parts = Parts { materials: &many, names: &names, ..parts(&dag, None, &[]) };
    let words = parts.to_vec().unwrap();
    let scene = file::read(&words).unwrap();
    assert!(scene.material_count() == 1 << 16 && scene.name(u16::MAX) == "65535" && scene.name(0) == "0");
    let (more, names) = (vec![Material::GREY; (1 << 16) + 1], vec![""; (1 << 16) + 1]);
    let error = Parts { materials: &more, names: &names, ..parts }.to_vec().unwrap_err();
    assert!(matches!(error, WriteError::Invalid(LoadError::MaterialCount { .. })));
}

#[test]
fn head_and_body_are_the_file() {
    let (dag, table, all) = (dag_words(), table_words(true), materials());
    let parts = parts(&dag, Some(&table), &all);
    let mut head = vec![u32::MAX; parts.head_len() as usize + 5];
    let written = parts.write_head(&mut head).unwrap();
    assert_eq!(written as u64, parts.head_len());
    let whole = [&head[..written], &parts.body().concat()].concat();
    assert_eq!(whole, parts.to_vec().unwrap());
    assert_eq!(whole.len() as u64, parts.file_len());
    let needed = whole.len();
    assert_eq!(parts.write_into(&mut vec![0; needed - 3]), Err(WriteError::Full { missing: 3 }));
    assert_eq!(parts.write_head(&mut head[..written - 1]), Err(WriteError::Full { missing: 1 }));
    assert_eq!(parts.write_into(&mut vec![7; needed + 1]), Ok(needed));
}

#[test]
fn what_no_reader_takes_is_not_written() {
    let (dag, table, all) = (dag_words(), table_words(false), materials());
    let good = parts(&dag, Some(&table), &all);
    let nan = [Material { refraction: f32::NAN, ..Material::GREY }, Material::GREY];
    let dull = [Material { shininess: 0, ..Material::GREY }, Material::GREY];
    let odd = [Material::GREY, Material { illum: 11, ..Material::GREY }];
    let refused = |parts: Parts<'_>| match parts.to_vec() {
        Err(WriteError::Invalid(error)) => error,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(Parts { materials: &nan, ..good }), LoadError::Material { index: 0, field: "refraction" });
    assert_eq!(refused(Parts { materials: &dull, ..good }), LoadError::Material { index: 0, field: "shininess" });
    assert_eq!(refused(Parts { materials: &odd, ..good }), LoadError::Material { index: 1, field: "illum" });
    assert_eq!(
        refused(Parts { materials: &all[..1], names: &["one"], ..good }),
        LoadError::MaterialId { count: 1, found: 1 }
    );
    assert_eq!(refused(Parts { materials: &[], names: &[], ..good }), LoadError::MaterialCount { found: 0 });
    let grid = Grid { resolution: 5, ..good.grid };
    assert_eq!(refused(Parts { grid, ..good }), LoadError::Depth { expected: 3, found: 2 });
    let grid = Grid { voxel_size: -1.0, ..good.grid };
    assert!(matches!(refused(Parts { grid, ..good }), LoadError::Grid(_)));
    let bounds = Bounds { min: [2.0; 3], ..good.bounds };
    assert_eq!(refused(Parts { bounds, ..good }), LoadError::Bounds);
    assert_eq!(refused(Parts { metres_per_unit: f64::INFINITY, ..good }), LoadError::Unit);
    assert_eq!(Parts { names: &["one"], ..good }.to_vec(), Err(WriteError::Names { found: 1 }));
}

#[test]
fn files_of_other_kinds_are_named() {
    let words = tiny();
    let swapped: Vec<_> = words.iter().map(|word| word.swap_bytes()).collect();
    assert_eq!(file::read(&swapped).unwrap_err(), LoadError::Endianness);
    assert_eq!(file::words_from_bytes(&bytes(&swapped)), Err(LoadError::Endianness));
    for text in ["# cube\nv 0 0 0\n", "v 1 2 3", "mtllib a.mtl\r\n"] {
        assert_eq!(file::words_from_bytes(text.as_bytes()), Err(LoadError::Text), "{text}");
    }
    assert!(matches!(file::words_from_bytes(b"\x89PNG\r\n\x1a\n"), Err(LoadError::Magic { .. })));
    let odd = [&bytes(&words)[..], &[0]].concat();
    assert_eq!(file::words_from_bytes(&odd), Err(LoadError::NotWords { bytes: odd.len() as u64 }));
    for short in [&b""[..], b"VXD"] {
        assert_eq!(file::words_from_bytes(short), Err(LoadError::Truncated { expected: 32, found: 0 }));
    }
    assert_eq!(file::words_from_bytes(&bytes(&words)).as_deref(), Ok(&words[..]));
    let mut later = words;
    later[1] = file::VERSION + 1;
    assert_eq!(file::read(&later).unwrap_err(), LoadError::Version { found: file::VERSION + 1 });
}

#[test]
fn d07_d10_every_length_but_the_right_one_is_refused() {
    let mut words = tiny();
    for len in 0..words.len() {
        let error = file::read(&words[..len]).unwrap_err();
        assert!(matches!(error, LoadError::Truncated { found, .. } if found == len as u64), "{len}: {error}");
        // Nor does a cut file pass if its header says that it is that short.
        let mut cut = words[..len].to_vec();
        if len > 60 {
            cut[2] = len as u32;
            mend(&mut cut);
            assert!(file::read(&cut).is_err(), "{len}");
        }
    }
    words.push(0);
    assert!(matches!(file::read(&words), Err(LoadError::Trailing { .. })));
    words[2] += 1;
    mend(&mut words);
    assert!(matches!(file::read(&words), Err(LoadError::Trailing { .. })));
}

/// Every bit that flips is noticed, as every word is under a checksum or is one.
#[test]
fn every_flipped_bit_is_refused() {
    let words = tiny();
    for bit in 0..32 * words.len() {
        let mut bad = words.clone();
        bad[bit / 32] ^= 1 << (bit % 32);
        let error = file::read(&bad).expect_err("a flipped bit was not noticed");
        assert!(!error.to_string().is_empty());
    }
}

/// With the checksums made right again, words either are refused or make a scene that is safe to use.
#[test]
fn d03_d09_damage_under_right_checksums_is_refused_or_harmless() {
    let mut loaded = 0;
    let (dag, all, table) = (dag_words(), materials(), table_words(true));
    for words in [parts(&dag, Some(&table), &all).to_vec().unwrap(), parts(&dag, None, &all).to_vec().unwrap()] {
        for at in 0..words.len() {
            let old = words[at];
            let flips = (0..32).map(|bit| old ^ 1 << bit);
            let others =
                [0, 1, old.wrapping_add(1), old.wrapping_sub(1), 0x7fc0_0000, 0xff80_0000, u32::MAX >> 1, u32::MAX];
            for new in flips.chain(others) {
                let mut bad = words.clone();
                bad[at] = new;
                mend(&mut bad);
                if let Ok(scene) = file::read(&bad) {
                    use_it(&scene);
                    loaded += 1;
                }
            }
        }
    }
    assert!(loaded > 1000, "only {loaded} damaged files got as far as being used");
}

/// Inserts a row and its section (at the end of the file) into the tiny file.
fn with_section(kind: u32, section: &[u32]) -> Vec<u32> {
    let mut words = tiny();
    let end = 32 + 6 * words[7] as usize;
    for row in (32..end).step_by(6) {
        words[row + 2] += 6;
    }
    words.splice(end..end, [kind, 0, words.len() as u32 + 6, 0, section.len() as u32, 0]);
    words[7] += 1;
    words.extend_from_slice(section);
    words[2] = words.len() as u32;
    mend(&mut words);
    words
}

#[test]
fn sections_are_skipped_missed_and_not_doubled() {
    let later = with_section(77, &[1, 2, 3]);
    assert_tiny(&file::read(&later).unwrap());
    let mut damaged = later;
    *damaged.last_mut().unwrap() = 4;
    assert!(matches!(file::read(&damaged), Err(LoadError::UnknownCrc { kind: 77, .. })));
    let twice = with_section(1, &dag_words());
    assert_eq!(file::read(&twice).unwrap_err(), LoadError::Duplicate { section: Section::Dag });
    for (row, section) in [(0, Section::Materials), (1, Section::Names), (2, Section::Dag)] {
        let mut words = tiny();
        words[32 + 6 * row] = 77;
        mend(&mut words);
        assert_eq!(file::read(&words).unwrap_err(), LoadError::Missing { section });
    }
    // Without its table all voxels have the one material that the header names.
    let mut words = tiny();
    words[32 + 6 * 3] = 77;
    mend(&mut words);
    assert!(matches!(file::read(&words).unwrap().materials, AnyMaterials::Single(Single(0))));
}

#[test]
fn d04_errors_say_where() {
    let good = tiny();
    let section = |kind| (32..).step_by(6).find(|&row| good[row] == kind).map(|row| good[row + 2] as usize).unwrap();
    let read = |at: usize, value: u32| {
        let mut words = good.clone();
        words[at] = value;
        mend(&mut words);
        file::read(&words).map(|_| ()).unwrap_err()
    };
    assert_eq!(read(5, 0), LoadError::UpAxis { found: 0 });
    assert_eq!(read(6, 1), LoadError::Reserved { word: 6 });
    assert_eq!(read(31, 1), LoadError::Reserved { word: 31 });
    assert_eq!(read(4, 9), LoadError::Depth { expected: 4, found: 2 });
    assert_eq!(read(section(1) + 22, 5), LoadError::Dag(DagError::Header { word: 22 }));
    assert_eq!(read(section(3) + 20 + 16, f32::NAN.to_bits()), LoadError::Material { index: 1, field: "refraction" });
    assert_eq!(read(section(3) + 19, 1), LoadError::Material { index: 0, field: "illum" });
    assert_eq!(read(section(4) + 1, 10), LoadError::Name { index: 0 });
    assert_eq!(read(section(4) + 3, u32::from_le_bytes(*b"r\xffdw")), LoadError::Name { index: 0 });
    assert_eq!(read(section(4) + 5, u32::from_le_bytes(*b"e\0\0x")), LoadError::Name { index: 2 });
    // Numbers of the header, each next to one that is right.
    let number = |at: usize, value: f64| {
        let mut words = good.clone();
        (words[at], words[at + 1]) = (value.to_bits() as u32, (value.to_bits() >> 32) as u32);
        mend(&mut words);
        file::read(&words).map(|_| ()).unwrap_err()
    };
    for value in [f64::NAN, f64::INFINITY, 1e300] {
        assert_eq!(number(16, value), LoadError::Bounds, "{value}");
    }
    assert_eq!(number(22, f64::INFINITY), LoadError::Bounds);
    for value in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(number(28, value), LoadError::Unit, "{value}");
        assert!(matches!(number(14, value), LoadError::Grid(_)));
    }
    assert!(matches!(number(8, f64::NAN), LoadError::Grid(_)));
    // Fewer words than there are, by the header alone.
    let length = good.len() as u64;
    assert_eq!(read(2, good[2] - 1), LoadError::Trailing { expected: length - 1, found: length });
    // A material that no table of them can hold, and names out of place.
    let (dag, all) = (dag_words(), materials());
    let mut alone = parts(&dag, None, &all).to_vec().unwrap();
    alone[6] = 1 << 16;
    mend(&mut alone);
    assert_eq!(file::read(&alone).unwrap_err(), LoadError::MaterialId { count: 1 << 16, found: 1 << 16 });
    assert_eq!(read(section(4), 1), LoadError::Name { index: 0 });
    for (end, expected) in [(13, 7), (8, 5), (0, 3)] {
        assert_eq!(read(section(4) + 2, end), LoadError::Names { expected, found: 6 });
    }
    let three = [all[0], all[1], Material::GREY];
    let mut named = Parts { materials: &three, names: &["ab", "c", "d"], ..parts(&dag, None, &all) }.to_vec().unwrap();
    let names = named[32 + 6 + 2] as usize;
    assert_eq!(named[names..][..4], [0, 2, 3, 4]);
    named[names + 2] = 1;
    mend(&mut named);
    assert_eq!(file::read(&named).unwrap_err(), LoadError::Name { index: 1 });
    // Part of a material behind the last one.
    let mut more = parts(&dag, None, &all).to_vec().unwrap();
    let names = more[32 + 6 + 2] as usize;
    more.insert(names, 0);
    more[32 + 4] += 1;
    (1..more[7] as usize).for_each(|row| more[32 + 6 * row + 2] += 1);
    more[2] += 1;
    mend(&mut more);
    assert_eq!(file::read(&more).unwrap_err(), LoadError::MaterialCount { found: 41 });
    let crc_word = good[33];
    let mut words = good.clone();
    words[section(3)] ^= 1;
    let found = crc(&words[section(3)..section(4)]);
    let word = section(3) as u64;
    assert_eq!(
        file::read(&words).unwrap_err(),
        LoadError::Crc { section: Section::Materials, word, expected: crc_word, found }
    );
}
