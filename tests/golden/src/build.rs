//! The whole way from a scene's mesh to the words of its file. Covers, kinds of materials and up axes differ between
//! scenes, so that each is built once.

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use voxdag::file::Parts;
use voxdag::grid::UpAxis;
use voxdag::materials::{AnyMaterials, Single};
use voxdag::scene::{Build, MaterialMode, Options};
use voxdag::voxelize::Cover;
use voxdag::{Grid, Material, Mesh};

use crate::shapes::{self, MATERIALS, Shape};

/// The words of a scene's file, or why there are none; `None` if it takes features that are missing here.
pub fn words(name: &str) -> Option<Result<Vec<u32>, String>> {
    let exact = Options::default();
    let built = match name {
        "tiny" => small(shapes::tiny(), 9, UpAxis::Z, exact),
        "ball" => small(shapes::ball(), 90, UpAxis::Y, Options { materials: MaterialMode::None, ..exact }),
        "ring" => {
            let options = Options { cover: Cover::Inflated, materials: MaterialMode::TableNormals, ..exact };
            small(shapes::ring(), 100, UpAxis::Z, options)
        }
        "waves" => small(shapes::waves(), 128, UpAxis::Y, Options { cover: Cover::Thin, ..exact }),
        "soup" => small(shapes::soup(), 61, UpAxis::Y, Options { materials: MaterialMode::Table, ..exact }),
        // For little flash, and not among the cases.
        "little" => small(shapes::waves(), 40, UpAxis::Y, exact),
        #[cfg(feature = "hall")]
        "hall" => hall(),
        _ => return None,
    };
    Some(built)
}

/// A shape's file; its three materials differ in all that shading reads.
fn small(shape: Shape, resolution: u32, up: UpAxis, options: Options) -> Result<Vec<u32>, String> {
    let materials: [Material; MATERIALS] = core::array::from_fn(|i| {
        let mut colors = [[0.8, 0.3, 0.1], [0.2, 0.7, 0.3], [0.15, 0.25, 0.9]];
        colors.rotate_left(i);
        Material {
            ambient: colors[0],
            diffuse: colors[0],
            specular: colors[1].map(|x: f32| x / 2.0),
            shininess: [1, 37, 1000][i],
            illum: 2,
            ..Material::GREY
        }
    });
    file(&shape.mesh(), resolution, up, options, &materials, &["first", "second", "third"])
}

/// The demo's scene from its text, as the importer reads it.
#[cfg(feature = "hall")]
fn hall() -> Result<Vec<u32>, String> {
    use voxdag::demo;

    let library = |path: &str| (path == demo::MTL_NAME).then(|| demo::mtl().into_bytes());
    let model = voxdag::obj::import(demo::obj().as_bytes(), library).map_err(|e| e.to_string())?;
    let materials: Vec<Material> = model.materials.iter().map(|m| m.material).collect();
    let names: Vec<&str> = model.materials.iter().map(|m| m.name.as_str()).collect();
    file(&model.mesh(), 96, UpAxis::Y, Options::default(), &materials, &names)
}

fn file(
    mesh: &Mesh<'_>,
    resolution: u32,
    up: UpAxis,
    options: Options,
    materials: &[Material],
    names: &[&str],
) -> Result<Vec<u32>, String> {
    let bounds = mesh.validate().map_err(|e| e.to_string())?;
    let grid = Grid::fit(&bounds, resolution).map_err(|e| e.to_string())?;
    let built = Build::new(mesh, &grid, &options).and_then(|build| build.run()).map_err(|e| e.to_string())?;
    let voxel_materials = match built.materials.as_materials(None).unwrap() {
        AnyMaterials::Single(_) => AnyMaterials::Single(Single(1)),
        kept => kept,
    };
    let parts = Parts {
        grid,
        bounds,
        up,
        metres_per_unit: 0.01,
        geometry: built.dag.dag().into(),
        voxel_materials,
        colors: None,
        materials,
        names,
    };
    parts.to_vec().map_err(|e| format!("the file cannot be written: {e}"))
}
