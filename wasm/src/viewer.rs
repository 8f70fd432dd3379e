//! A scene that is looked at: rows of its picture, single rays, and what it holds.

use std::cell::Cell;

use voxdag::Material;
use voxdag::colors::Painted;
use voxdag::effects::Effects;
use voxdag::file::LoadError;
use voxdag::geometry::Geometry;
use voxdag::layout::AnyGeometry;
use voxdag::material::MaterialId;
use voxdag::materials::{AnyMaterials, Materials};
use voxdag::math;
use voxdag::normal::normal;
use voxdag::render::{Counters, Show, View, render_rows, show_rows};
use voxdag::shade::Light;
use voxdag::simd::Level;
use voxdag::trace::{Query, TopBuf, Tracer};
use voxdag::trees::{TOP_BITS, top_within, tracer, wide};
use voxdag::wide::{Wide, WideBuf};
use wasm_bindgen::Clamped;
use wasm_bindgen::prelude::*;

use crate::error;
use crate::loaded::Loaded;
use crate::picture::{Camera, Settings};

/// A scene that was loaded and checked.
#[wasm_bindgen]
pub struct Viewer {
    loaded: Loaded,
    palette: Vec<Material>,
    /// What rays go through: one kernel for whatever layout the file has.
    wide: WideBuf,
    top: Option<TopBuf>,
    rays: Cell<u64>,
}

#[wasm_bindgen]
impl Viewer {
    /// Takes the words of a `.vxd` file (`new Uint32Array(buffer)`), or says what is wrong with them.
    #[wasm_bindgen(constructor)]
    pub fn new(words: Vec<u32>) -> Result<Viewer, JsError> {
        let loaded = Loaded::new(words)?;
        let scene = loaded.scene();
        let palette = (0..scene.material_count()).map(|id| scene.material(id as MaterialId)).collect();
        // Files hold these two; matching no others keeps the module small.
        let wide = match scene.geometry {
            AnyGeometry::Dag(dag) => wide(&dag, None),
            AnyGeometry::Ssvdag(ssvdag) => wide(&ssvdag, None),
            _ => None,
        };
        let wide = wide.ok_or_else(|| error("out of memory: there is no room for the trees that rays go through"))?;
        let top = top_within(&wide.as_wide(), TOP_BITS, None);
        Ok(Viewer { palette, wide, top, loaded, rays: Cell::new(0) })
    }

    /// Draws rows `from` to `to` (row 0 is the top, the last one excluded): RGBA8, row by row. Rows can be drawn anywhere and
    /// in any order, best as multiples of 4; the bits are the same.
    #[wasm_bindgen(js_name = renderRows)]
    pub fn render_rows(
        &self,
        camera: &Camera,
        settings: &Settings,
        from: u32,
        to: u32,
    ) -> Result<Clamped<Vec<u8>>, JsError> {
        let scene = self.loaded.scene();
        let lights = settings.lights(scene, camera);
        let settings = settings.of(scene, camera);
        let mut pixels = room(settings.width, from, to)?;
        let view = self.view(camera, &lights);
        self.count(&render_rows(&view, &settings, from..to, &mut pixels)?);
        Ok(bytes(&pixels))
    }

    /// Works out rows of what a renderer sees: "normals", "depth", "level", "iterations" or "material". The words are turned
    /// into colours by [`Viewer::paint`] once all rows are there.
    #[wasm_bindgen(js_name = showRows)]
    pub fn show_rows(
        &self,
        camera: &Camera,
        settings: &Settings,
        what: &str,
        from: u32,
        to: u32,
    ) -> Result<Vec<u32>, JsError> {
        let show = named(what)?;
        let settings = settings.of(self.loaded.scene(), camera);
        let mut words = room(settings.width, from, to)?;
        let view = self.view(camera, &[]);
        self.count(&show_rows(&view, &settings, show, from..to, &mut words)?);
        Ok(words)
    }

    /// The smallest and the largest number in words of [`Viewer::show_rows`]; undefined where there are none.
    pub fn range(&self, what: &str, words: &[u32]) -> Result<Option<Vec<f32>>, JsError> {
        Ok(named(what)?.spread(words).map(|spread| vec![spread.min as f32, spread.max as f32]))
    }

    /// Turns words of [`Viewer::show_rows`] into pixels; numbers of the whole picture span `min` to `max`.
    pub fn paint(&self, what: &str, mut words: Vec<u32>, min: f32, max: f32) -> Result<Clamped<Vec<u8>>, JsError> {
        named(what)?.paint([min, max], self.loaded.scene().geometry.depth(), &mut words);
        Ok(bytes(&words))
    }

    /// What is seen through the place (x, y), in pixels from the upper left corner; undefined if it is nothing.
    pub fn pick(&self, camera: &Camera, settings: &Settings, x: f64, y: f64) -> Result<Option<Pick>, JsError> {
        let scene = self.loaded.scene();
        let settings = settings.of(scene, camera);
        let dir = camera.0.rays(settings.width, settings.height)?.direction(x, y);
        let (query, tracer) = (Query::new(scene.grid.to_grid(camera.0.eye), dir), self.tracer());
        let Some(hit) = tracer.trace(settings.arithmetic, &query) else { return Ok(None) };
        let id = scene.materials.id(hit.voxel);
        let position = scene.grid.to_world(math::add_scaled(query.origin, dir, hit.t));
        let way = math::sub(position, camera.0.eye);
        Ok(Some(Pick {
            voxel: hit.voxel.decode().to_vec(),
            position: position.to_vec(),
            normal: normal(&tracer, scene.materials, &hit, dir, settings.normals).direction.to_vec(),
            material: scene.name(id).to_string(),
            distance: math::sqrt(math::dot(way, way)),
        }))
    }

    /// The view that shows all of the scene.
    #[wasm_bindgen(getter)]
    pub fn camera(&self) -> Camera {
        let scene = self.loaded.scene();
        Camera(voxdag::camera::Camera::framing(&scene.bounds, scene.up))
    }

    /// Names of the effects that the materials call for; shadows depend on the lights.
    #[wasm_bindgen(getter)]
    pub fn effects(&self) -> Vec<String> {
        let lights = [self.camera().0.headlight(1.0)];
        Effects::needed(&self.palette, &lights).names().map(String::from).collect()
    }

    /// Whether normals can be "stored".
    #[wasm_bindgen(getter, js_name = hasNormals)]
    pub fn has_normals(&self) -> bool {
        self.loaded.scene().materials.has_normals()
    }

    /// Rays that were followed for rows so far.
    #[wasm_bindgen(getter)]
    pub fn rays(&self) -> f64 {
        self.rays.get() as f64
    }

    /// What the scene holds. O(words).
    pub fn stats(&self) -> Result<Stats, JsError> {
        let scene = self.loaded.scene();
        let counted = scene.geometry.stats();
        let counted = counted.map_err(|bytes| error(format!("out of memory: {bytes} bytes could not be had")))?;
        Ok(Stats {
            resolution: scene.grid.resolution,
            voxels: counted.voxels as f64,
            dag_bytes: size_of_val(scene.geometry.words()) as f64,
            file_bytes: size_of_val(self.loaded.words()) as f64,
            materials: scene.material_count() as u32,
            radius: scene.bounds.radius(),
        })
    }

    /// The bytes of the `.vxd` file.
    pub fn save(&self) -> Result<Vec<u8>, JsError> {
        let mut bytes = Vec::new();
        let length = size_of_val(self.loaded.words());
        bytes.try_reserve_exact(length).map_err(|_| LoadError::Memory { bytes: length as u64 })?;
        bytes.extend(self.loaded.words().iter().flat_map(|word| word.to_le_bytes()));
        Ok(bytes)
    }
}

impl Viewer {
    /// What answers rays.
    fn tracer(&self) -> Tracer<'_, Wide<'_>> {
        tracer(self.wide.as_wide(), self.top.as_ref()).with_level(Level::best())
    }

    fn view<'a>(&'a self, camera: &Camera, lights: &'a [Light]) -> View<'a, Painted<'a, AnyMaterials<'a>>, Wide<'a>> {
        let scene = self.loaded.scene();
        let (grid, materials) = (scene.grid, scene.looks());
        View { tracer: self.tracer(), materials, palette: &self.palette, grid, camera: camera.0, lights }
    }

    fn count(&self, counters: &Counters) {
        self.rays.set(self.rays.get() + counters.primary + counters.shadow + counters.secondary);
    }
}

/// What a ray meets.
#[wasm_bindgen(getter_with_clone)]
pub struct Pick {
    /// The voxel: x, y, z.
    pub voxel: Vec<u32>,
    /// Where the ray meets it, in the world.
    pub position: Vec<f64>,
    /// The surface's direction there, of unit length.
    pub normal: Vec<f32>,
    /// Name of the material.
    pub material: String,
    /// From the eye, in the world's units.
    pub distance: f64,
}

/// What a scene holds.
#[wasm_bindgen]
pub struct Stats {
    /// Voxels along the longest axis.
    pub resolution: u32,
    /// Filled voxels; exact up to 2^53.
    pub voxels: f64,
    /// Bytes of nodes and bricks.
    #[wasm_bindgen(js_name = dagBytes)]
    pub dag_bytes: f64,
    /// Bytes of the whole file.
    #[wasm_bindgen(js_name = fileBytes)]
    pub file_bytes: f64,
    /// Number of materials.
    pub materials: u32,
    /// Half the diagonal of the mesh's box.
    pub radius: f64,
}

/// The view of a name.
fn named(what: &str) -> Result<Show, JsError> {
    Ok(match what {
        "normals" => Show::Normals,
        "depth" => Show::Depth,
        "level" => Show::Level,
        "iterations" => Show::Iterations,
        "material" => Show::Material,
        _ => {
            let names = "\"normals\", \"depth\", \"level\", \"iterations\" or \"material\"";
            return Err(error(format!("view {what:?}: expected {names}")));
        }
    })
}

/// Room for the pixels of rows; that they lie in the picture is checked when they are drawn.
fn room(width: u32, from: u32, to: u32) -> Result<Vec<u32>, JsError> {
    let pixels = u64::from(width) * u64::from(to.saturating_sub(from));
    let refused = || error(format!("no memory for {pixels} pixels"));
    let length = usize::try_from(pixels).map_err(|_| refused())?;
    let mut room = Vec::new();
    room.try_reserve_exact(length).map_err(|_| refused())?;
    room.resize(length, 0);
    Ok(room)
}

fn bytes(pixels: &[u32]) -> Clamped<Vec<u8>> {
    Clamped(pixels.iter().flat_map(|pixel| pixel.to_le_bytes()).collect())
}
