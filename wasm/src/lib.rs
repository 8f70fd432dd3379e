//! voxdag in the browser: a [`Viewer`] over a `.vxd` file's words.
//!
//! In: a `Uint32Array`. Out: what the scene holds; errors arrive in JavaScript as `Error` with the core's own text. No
//! algorithm lives here, and nothing in here panics.

use voxdag::file::{self, Scene};
use wasm_bindgen::prelude::*;

/// The version of this package.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").into()
}

/// A scene that was loaded and checked.
#[wasm_bindgen]
pub struct Viewer {
    words: Vec<u32>,
}

#[wasm_bindgen]
impl Viewer {
    /// Takes the words of a `.vxd` file (`new Uint32Array(buffer)`), or says what is wrong with them.
    #[wasm_bindgen(constructor)]
    pub fn new(words: Vec<u32>) -> Result<Viewer, JsError> {
        file::read(&words)?;
        Ok(Viewer { words })
    }

    /// Voxels along the longest axis.
    pub fn resolution(&self) -> Result<u32, JsError> {
        Ok(self.scene()?.grid.resolution)
    }

    /// Number of filled voxels; exact up to 2^53.
    pub fn voxels(&self) -> Result<f64, JsError> {
        let stats = self.scene()?.geometry.stats();
        let stats = stats.map_err(|bytes| JsError::new(&format!("out of memory: {bytes} bytes could not be had")))?;
        Ok(stats.voxels as f64)
    }

    /// Names of the materials, by id.
    pub fn materials(&self) -> Result<Vec<String>, JsError> {
        let scene = self.scene()?;
        Ok((0..=u16::MAX).take(scene.material_count()).map(|id| scene.name(id).to_string()).collect())
    }

    /// The view over the words. Checks them again, O(words).
    fn scene(&self) -> Result<Scene<'_>, JsError> {
        Ok(file::read(&self.words)?)
    }
}
