//! The shader as far as it can be tested without a graphics card: it is valid WGSL, every back end of naga writes it, and
//! the uniform says where things lie. What it computes is tested on an adapter, by tests/gpu.

use naga::back::{glsl, hlsl, msl, spv};
use naga::proc::BoundsCheckPolicies;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use voxdag::build::DagBuilder;
use voxdag::file::{Parts, Section};
use voxdag::grid::{Bounds, UpAxis};
use voxdag::layout::AnyGeometry;
use voxdag::materials::{AnyMaterials, Single};
use voxdag::ssvdag::SsvdagBuf;
use voxdag::table::TableBuf;
use voxdag::tree::TreeBuilder;
use voxdag::wgsl::{self, WgslError};
use voxdag::{Grid, Material, Morton};

fn checked(source: &str) -> (Module, ModuleInfo) {
    let module = naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    // No capabilities: what every card has.
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    (module, info)
}

fn picture() -> (Module, ModuleInfo) {
    checked(&format!("{}\n{}", wgsl::SOURCE, wgsl::PICTURE))
}

#[test]
fn the_source_is_valid_alone() {
    checked(wgsl::SOURCE);
}

#[test]
fn names_leave_all_others_to_the_host() {
    let (module, _) = picture();
    let functions = module.functions.iter().filter_map(|(_, function)| function.name.as_deref());
    let entries = module.entry_points.iter().map(|entry| entry.name.as_str());
    let globals = module.global_variables.iter().filter_map(|(_, variable)| variable.name.as_deref());
    let types = module.types.iter().filter_map(|(_, ty)| ty.name.as_deref());
    let constants = module.constants.iter().filter_map(|(_, constant)| constant.name.as_deref());
    for name in functions.chain(entries).chain(globals) {
        assert!(name.starts_with("vd_"), "{name}");
    }
    for name in types {
        assert!(name.starts_with("Vd"), "{name}");
    }
    for name in constants {
        assert!(name.starts_with("VD_"), "{name}");
    }
}

#[test]
fn every_back_end_writes_it() {
    let (module, info) = picture();
    let entry = || (ShaderStage::Compute, "vd_draw".to_string());

    let words = spv::write_vec(&module, &info, &spv::Options::default(), None).unwrap();
    assert!(words.len() > 1000);

    let options = msl::Options { lang_version: (2, 0), fake_missing_bindings: true, ..msl::Options::default() };
    let pipeline = msl::PipelineOptions { entry_point: Some(entry()), ..msl::PipelineOptions::default() };
    let (text, _) = msl::write_string(&module, &info, &options, &pipeline).unwrap();
    assert!(text.contains("vd_draw"));

    let options = hlsl::Options { fake_missing_bindings: true, ..hlsl::Options::default() };
    let pipeline = hlsl::PipelineOptions { entry_point: Some(entry()) };
    let mut text = String::new();
    hlsl::Writer::new(&mut text, &options, &pipeline).write(&module, &info, None).unwrap();
    assert!(text.contains("vd_draw"));

    let (options, mut text) = (glsl::Options::default(), String::new());
    let (shader_stage, entry_point) = entry();
    let pipeline = glsl::PipelineOptions { shader_stage, entry_point, multiview: None };
    glsl::Writer::new(&mut text, &module, &info, &options, &pipeline, BoundsCheckPolicies::default())
        .unwrap()
        .write()
        .unwrap();
    assert!(text.contains("void main()"));
}

/// A file of two voxels in a cube of 16, the second of another material.
fn file(geometry: impl Fn(voxdag::Dag<'_>) -> Option<SsvdagBuf>, materials: AnyMaterials<'_>) -> Vec<u32> {
    let mut builder = DagBuilder::new(4).unwrap();
    builder.push(Morton(0), 1).unwrap();
    builder.push(Morton(64 * 5), 1 << 63).unwrap();
    let dag = builder.finish().unwrap();
    let other = geometry(dag.dag());
    let parts = Parts {
        grid: Grid { origin: [0.0; 3], voxel_size: 1.0, resolution: 16 },
        bounds: Bounds { min: [0.0; 3], max: [1.0; 3] },
        up: UpAxis::Y,
        metres_per_unit: 0.0,
        geometry: other.as_ref().map_or(dag.dag().into(), |other| AnyGeometry::Ssvdag(other.ssvdag())),
        voxel_materials: materials,
        colors: None,
        materials: &[Material { diffuse: [0.25; 3], ..Material::GREY }; 7],
        names: &[""; 7],
    };
    parts.to_vec().unwrap()
}

#[test]
fn the_uniform_says_where_things_lie() {
    let mut builder = TreeBuilder::new(4).unwrap();
    builder.push(Morton(0), 1, &[3]).unwrap();
    builder.push(Morton(64 * 5), 1 << 63, &[6]).unwrap();
    let tree = builder.finish().unwrap();
    let words = file(|_| None, AnyMaterials::Tree(tree.tree()));
    let uniform = wgsl::scene(&words).unwrap();
    let at = |word: usize| uniform[word] as usize;

    // The DAG: its depth is its first word, and its root a mask word of two children.
    assert_eq!((uniform[1], words[at(0)]), (4, 4));
    assert_eq!(words[at(0) + at(2)].count_ones(), 1 + 1, "{:#x}", words[at(0) + at(2)]);
    // The first record's diffuse colour.
    assert_eq!((uniform[4], words[at(3) + 3]), (7, 0.25f32.to_bits()));
    // The tree, and its parts by docs/format.md.
    assert_eq!(&words[at(6)..at(6) + tree.words().len()], tree.words());
    let head = &words[at(6)..at(6) + 28];
    let mut part = 28 + (1 << (3 * head[1]));
    for (i, each) in [8, 2, 6, 16, 32, 2].into_iter().enumerate() {
        assert_eq!(at(7 + i), at(6) + part as usize, "part {i}");
        part += each * head[2 + i];
    }
    assert_eq!((at(13), uniform[14], uniform[15]), (at(6) + part as usize, 0, 0));
}

#[test]
fn one_material_and_a_dag_alone() {
    let words = file(|_| None, AnyMaterials::Single(Single(5)));
    let uniform = wgsl::scene(&words).unwrap();
    assert_eq!((uniform[5], &uniform[6..]), (5, &[0; 10][..]));

    let empty = DagBuilder::new(9).unwrap().finish().unwrap();
    assert_eq!(wgsl::dag(empty.dag())[..3], [0, 9, 0]);
    let mut brick = DagBuilder::new(1).unwrap();
    brick.push(Morton(0), 1).unwrap();
    let brick = brick.finish().unwrap();
    assert_eq!(wgsl::dag(brick.dag())[..3], [0, 1, 24]);
}

#[test]
fn what_the_shader_does_not_read_is_refused() {
    let ssvdag = file(|dag| Some(SsvdagBuf::build(&dag).unwrap()), AnyMaterials::Single(Single(0)));
    assert_eq!(wgsl::scene(&ssvdag), Err(WgslError::Unsupported { section: Section::Ssvdag }));
    let table = TableBuf::new(8, false).unwrap();
    let table = file(|_| None, AnyMaterials::Table(table.as_table()));
    assert_eq!(wgsl::scene(&table), Err(WgslError::Unsupported { section: Section::Table }));
    assert!(matches!(wgsl::scene(&table[1..]), Err(WgslError::Load(_))));
}
