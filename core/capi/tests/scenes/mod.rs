//! Scenes for the tests here, made by the core alone.

use voxdag::colors::{ColorMode, Colored, ColorsBuf};
use voxdag::file::Parts;
use voxdag::grid::UpAxis;
use voxdag::rank::{AnyRank, Prefix};
use voxdag::scene::{Build, MaterialMode, Options};
use voxdag::ssvdag::SsvdagBuf;
use voxdag::{Grid, Material, Mesh};
use voxdag_oracle::scenes::{Shape, cuboid, torus};

/// A ring, material 0, over a slab, material 1, in some units of their own.
pub fn shape() -> (Shape, Vec<u16>) {
    let mut shape = torus([0.0; 3], 3.0, 1.2, 48, 32);
    let mut materials = vec![0; shape.triangles.len()];
    shape.add(&cuboid([-4.5, -4.5, -2.5], [4.5, 4.5, -2.0]));
    materials.resize(shape.triangles.len(), 1);
    (shape.map(|[x, y, z]| [0.1 * x + 7.0, 0.1 * y, 0.1 * z - 3.0]), materials)
}

/// Something shiny and transparent, and something matte.
pub fn materials() -> [Material; 2] {
    let glass = Material {
        diffuse: [0.6, 0.1, 0.1],
        specular: [0.5, 0.4, 0.3],
        emission: [0.01, 0.0, 0.0],
        transmission: [0.5; 3],
        opacity: 0.75,
        refraction: 1.25,
        shininess: 40,
        illum: 7,
        ..Material::GREY
    };
    [glass, Material { ambient: [0.25; 3], ..Material::GREY }]
}

pub const NAMES: [&str; 2] = ["Ring aus Glas \u{2013} 1", "floor"];

/// What the file holds.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A DAG, a table with normals.
    Normals,
    /// A DAG, a tree, colours of material 1.
    Colors,
    /// An SSVDAG, a tree.
    Mirrors,
}

/// The words of the scene's file.
pub fn words(kind: Kind, resolution: u32) -> Vec<u32> {
    let (shape, ids) = shape();
    let mesh = Mesh { materials: &ids, ..shape.mesh() };
    let bounds = mesh.validate().unwrap();
    let grid = Grid::fit(&bounds, resolution).unwrap();
    let mode = if matches!(kind, Kind::Normals) { MaterialMode::TableNormals } else { MaterialMode::Tree };
    let build = Build::new(&mesh, &grid, &Options { materials: mode, ..Options::default() }).unwrap();
    let built = build.run().unwrap();
    let dag = built.dag.dag();

    let counts = Prefix::build(&dag).unwrap();
    let mut number = 0u8;
    let colors = dag.voxels().map(|_| {
        number = number.wrapping_add(37);
        Some([number, number ^ 0x55, 255 - number])
    });
    let colors = ColorsBuf::new(ColorMode::Raw, colors).unwrap();
    let colored = Colored::new(AnyRank::Prefix(Prefix::new(dag, &counts).unwrap()), colors.as_colors()).unwrap();
    let mirrors = SsvdagBuf::build(&dag).unwrap();
    let mut materials = materials();
    materials[1].textured = matches!(kind, Kind::Colors);
    let parts = Parts {
        grid,
        bounds,
        up: UpAxis::Z,
        metres_per_unit: 0.25,
        geometry: match kind {
            Kind::Mirrors => voxdag::layout::AnyGeometry::Ssvdag(mirrors.ssvdag()),
            _ => dag.into(),
        },
        voxel_materials: built.materials.as_materials(None).unwrap(),
        colors: matches!(kind, Kind::Colors).then_some(colored),
        materials: &materials,
        names: &NAMES,
    };
    parts.to_vec().unwrap()
}
