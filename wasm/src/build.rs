//! From files to the words of a `.vxd`, on this thread; a worker that builds is cancelled by ending it.

use voxdag::file::{self, Parts};
use voxdag::grid::UpAxis;
use voxdag::obj::{self, Model, Warning};
use voxdag::scene::{Build, Options};
use voxdag::{Grid, Material};
use wasm_bindgen::prelude::*;

use crate::error;
use crate::files::Files;

#[wasm_bindgen]
extern "C" {
    /// A function that is told how much is done.
    #[wasm_bindgen(typescript_type = "(done: number, total: number) => void")]
    pub type Progress;

    #[wasm_bindgen(method)]
    fn call(this: &Progress, receiver: &JsValue, done: u32, total: u32);
}

/// Bytes that textures may take: a module has 4 GiB in all, and browsers on phones give less.
const MOST_TEXTURES: u64 = 1 << 30;

/// A scene that was built or read.
#[wasm_bindgen]
pub struct Built {
    words: Vec<u32>,
    triangles: Option<u32>,
    warnings: Vec<String>,
}

#[wasm_bindgen]
impl Built {
    /// Number of triangles; undefined for a scene that was built before.
    #[wasm_bindgen(getter)]
    pub fn triangles(&self) -> Option<u32> {
        self.triangles
    }

    /// What was not as it should be and did not stop the import, with file and line.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The words of the `.vxd` file, moved out: a second call gives none.
    #[wasm_bindgen(js_name = takeWords)]
    pub fn take_words(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.words)
    }
}

/// Builds the files' mesh with `resolution` voxels along its longest axis; `up` is "y" or "z". A scene that was built before
/// is checked and stays as it is. `progress(done, total)` is called between parts of the work.
#[wasm_bindgen]
pub fn build(files: &Files, resolution: u32, up: &str, progress: &Progress) -> Result<Built, JsError> {
    let name = files.main()?;
    let bytes = files.get(&name).unwrap_or(&[]);
    if name.to_ascii_lowercase().ends_with(".vxd") {
        let located = |why: file::LoadError| error(format!("{name}: {why}"));
        let words = file::words_from_bytes(bytes).map_err(located)?;
        file::read(&words).map_err(located)?;
        return Ok(Built { words, triangles: None, warnings: Vec::new() });
    }
    let up = match up {
        "y" => UpAxis::Y,
        "z" => UpAxis::Z,
        other => return Err(error(format!("up axis {other:?}: expected \"y\" or \"z\""))),
    };
    let resolve = |path: &str| files.resolve(&name, path).map(<[u8]>::to_vec);
    let mut model = obj::import(bytes, resolve).map_err(|why| error(place(&name, &why.0)))?;
    let over = |needed| error(format!("{name}: its textures take {needed} bytes, more than is to be had"));
    model.load_textures(|path, left| files.picture(&name, path, left), MOST_TEXTURES).map_err(over)?;
    let words = voxels(&model, resolution, up, progress).map_err(|why| error(format!("{name}: {why}")))?;
    let warnings = model.warnings.iter().map(|warning| place(&name, warning)).collect();
    Ok(Built { words, triangles: Some(model.triangles.len() as u32), warnings })
}

/// Where a message of the importer belongs: into the mesh or into a file beside it.
fn place(mesh: &str, Warning { file, line, message }: &Warning) -> String {
    format!("{}:{line}: {message}", if file.is_empty() { mesh } else { file })
}

/// The way from triangles to a file.
fn voxels(
    model: &Model,
    resolution: u32,
    up: UpAxis,
    progress: &Progress,
) -> Result<Vec<u32>, Box<dyn std::error::Error>> {
    let mesh = model.mesh();
    let bounds = mesh.validate()?;
    let grid = Grid::fit(&bounds, resolution)?;
    let build = Build::new(&mesh, &grid, &Options::default())?.with_textures(&model.textures);
    let mut join = build.join()?;
    for part in 0..build.parts() {
        join.add(build.part(part)?)?;
        progress.call(&JsValue::NULL, part as u32 + 1, build.parts() as u32);
    }
    let built = join.built()?;
    let looks = built.looks()?;
    let materials: Vec<Material> = model.palette(looks.colors.is_some()).collect();
    let names: Vec<&str> = model.materials.iter().map(|named| named.name.as_str()).collect();
    let parts = Parts {
        grid,
        bounds,
        up,
        metres_per_unit: 0.0,
        geometry: built.dag.dag().into(),
        voxel_materials: looks.materials,
        colors: looks.colors,
        materials: &materials,
        names: &names,
    };
    Ok(parts.to_vec()?)
}
