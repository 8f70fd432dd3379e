//! voxdag in the browser: meshes become scenes, scenes become pictures. No algorithm lives here.
//!
//! ```text
//! Files (dropped or chosen) -> build -> words of a .vxd -> Viewer in each worker -> rows of RGBA8, hits of single rays
//! ```
//!
//! Numbers, names and bytes come in as they are; whatever is wrong with them arrives in JavaScript as an `Error` that names
//! file and line. Nothing in here panics. A viewer holds no more than a file's words and what makes rays faster, so that
//! every worker of a page can have one of its own.

mod build;
mod files;
mod loaded;
mod picture;
mod viewer;

pub use build::{Built, build};
pub use files::Files;
pub use picture::{Camera, Settings};
pub use viewer::{Pick, Stats, Viewer};

use wasm_bindgen::prelude::*;

/// The version of this package.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").into()
}

/// How far a picture is from another one of the same size: the root of the mean square difference in linear light, 0 to 1.
/// Pixels are words of RGBA8, as in `new Uint32Array(imageData.data.buffer)`; NaN if there are not as many.
#[wasm_bindgen]
pub fn rmse(reference: &[u32], picture: &[u32]) -> f64 {
    voxdag::color::rmse(reference, picture)
}

/// Why something cannot be done, in words.
fn error(text: impl AsRef<str>) -> JsError {
    JsError::new(text.as_ref())
}
