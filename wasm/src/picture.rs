//! From where a scene is seen, and how it is drawn, as JavaScript says it: numbers in typed arrays, choices by the names
//! that the command line has for them.

use voxdag::demo;
use voxdag::effects::Effects;
use voxdag::file::Scene;
use voxdag::normal::NormalKind;
use voxdag::render::{self, Samples, Supersample};
use voxdag::shade::{Light, LightKind};
use wasm_bindgen::prelude::*;

use crate::error;

/// A pinhole camera in the world.
#[wasm_bindgen]
#[derive(Clone, Copy)]
pub struct Camera(pub(crate) voxdag::camera::Camera);

#[wasm_bindgen]
impl Camera {
    /// Where it is, what it looks at, what points upwards in the picture (three numbers each), and the angle between the
    /// picture's top and bottom in degrees.
    #[wasm_bindgen(constructor)]
    pub fn new(eye: &[f64], target: &[f64], up: &[f64], fov: f64) -> Result<Camera, JsError> {
        let camera = voxdag::camera::Camera {
            eye: three("the eye", eye)?,
            target: three("the target", target)?,
            up: three("up", up)?,
            fov_y: fov,
        };
        camera.checked()?;
        Ok(Camera(camera))
    }

    /// That of the scene that comes along.
    pub fn demo() -> Camera {
        let view = demo::view();
        Camera(voxdag::camera::Camera { eye: view.eye, target: view.target, up: view.up, fov_y: view.fov_y })
    }

    /// Where it is.
    #[wasm_bindgen(getter)]
    pub fn eye(&self) -> Vec<f64> {
        self.0.eye.to_vec()
    }

    /// What it looks at.
    #[wasm_bindgen(getter)]
    pub fn target(&self) -> Vec<f64> {
        self.0.target.to_vec()
    }

    /// What points upwards.
    #[wasm_bindgen(getter)]
    pub fn up(&self) -> Vec<f64> {
        self.0.up.to_vec()
    }

    /// Degrees between the picture's top and bottom.
    #[wasm_bindgen(getter)]
    pub fn fov(&self) -> f64 {
        self.0.fov_y
    }
}

/// How a picture is made: one sample per pixel, normals of the plane through the 5^3 voxels around, and one light above the
/// eye, until something else is said.
#[wasm_bindgen]
#[derive(Clone)]
pub struct Settings {
    pub(crate) settings: render::Settings,
    supersample: Which,
    lights: Vec<Light>,
    /// For all lights, the one above the eye included.
    shadows: bool,
}

/// Which pixels take all samples.
#[derive(Clone, Copy)]
enum Which {
    All,
    Near,
    Adaptive,
}

/// In the order of [`NormalKind::ALL`].
const NORMALS: [&str; 8] = ["face", "stored", "gradient", "plane1", "plane2", "plane3", "ernerfeldt1", "ernerfeldt2"];

#[wasm_bindgen]
impl Settings {
    /// For a picture of so many pixels.
    #[wasm_bindgen(constructor)]
    pub fn new(width: u32, height: u32) -> Settings {
        Settings {
            settings: render::Settings { width, height, ..render::Settings::default() },
            supersample: Which::All,
            lights: Vec::new(),
            shadows: false,
        }
    }

    /// Adds the lights of the scene that comes along.
    #[wasm_bindgen(js_name = addDemoLights)]
    pub fn add_demo_lights(&mut self) {
        let view = demo::view();
        let light = |&(at, color): &([f64; 3], [f32; 3])| Light { kind: LightKind::Point(at), color, shadow: false };
        self.lights.extend(view.lights.iter().map(light));
        self.settings.ambient = view.ambient;
    }

    /// Adds a point light: its place, and red, green and blue in linear light.
    #[wasm_bindgen(js_name = addLight)]
    pub fn add_light(&mut self, place: &[f64], color: &[f32]) -> Result<(), JsError> {
        self.lights.push(Light {
            kind: LightKind::Point(three("the light's place", place)?),
            color: three("the light's colour", color)?,
            shadow: false,
        });
        Ok(())
    }

    /// Adds a light infinitely far away in a direction.
    #[wasm_bindgen(js_name = addSun)]
    pub fn add_sun(&mut self, direction: &[f64], color: &[f32]) -> Result<(), JsError> {
        self.lights.push(Light {
            kind: LightKind::Directional(three("the sun's direction", direction)?),
            color: three("the sun's colour", color)?,
            shadow: false,
        });
        Ok(())
    }

    /// Whether lights cast shadows.
    #[wasm_bindgen(setter)]
    pub fn set_shadows(&mut self, shadows: bool) {
        self.shadows = shadows;
    }

    /// Rays per pixel: 1, 4, 5, 16 or 64.
    #[wasm_bindgen(setter)]
    pub fn set_samples(&mut self, samples: u32) -> Result<(), JsError> {
        let refused = || error(format!("{samples} samples: expected 1, 4, 5, 16 or 64"));
        self.settings.samples = Samples::new(samples).ok_or_else(refused)?;
        Ok(())
    }

    /// Which pixels take all samples: "all", "near" (those that show the nearer half) or "adaptive" (those where surfaces
    /// are not smooth).
    #[wasm_bindgen(setter)]
    pub fn set_supersample(&mut self, which: &str) -> Result<(), JsError> {
        self.supersample = match which {
            "all" => Which::All,
            "near" => Which::Near,
            "adaptive" => Which::Adaptive,
            _ => return Err(error(format!("supersample {which:?}: expected \"all\", \"near\" or \"adaptive\""))),
        };
        Ok(())
    }

    /// Whether pixels that take all samples are covered with red.
    #[wasm_bindgen(setter, js_name = markSupersampled)]
    pub fn set_mark_supersampled(&mut self, mark: bool) {
        self.settings.mark_supersampled = mark;
    }

    /// Where normals come from: "face", "stored", "gradient", "plane1" to "plane3", "ernerfeldt1" or "ernerfeldt2".
    #[wasm_bindgen(setter)]
    pub fn set_normals(&mut self, kind: &str) -> Result<(), JsError> {
        let found = NORMALS.iter().position(|name| *name == kind);
        let refused = || error(format!("normals {kind:?}: expected one of {}", NORMALS.join(", ")));
        self.settings.normals = NormalKind::ALL[found.ok_or_else(refused)?];
        Ok(())
    }

    /// Effects that may be drawn, by name: "specular", "shadows", "mirror", "transparency", "refraction", "emission", "textures".
    #[wasm_bindgen(setter)]
    pub fn set_effects(&mut self, names: Vec<String>) -> Result<(), JsError> {
        let mut effects = Effects::NONE;
        for name in &names {
            let refused = || error(format!("effect {name:?}: expected {}", all_effects()));
            effects = effects.union(Effects::named(name).ok_or_else(refused)?);
        }
        self.settings.effects = effects;
        Ok(())
    }

    /// Light from everywhere, linear.
    #[wasm_bindgen(setter)]
    pub fn set_ambient(&mut self, color: &[f32]) -> Result<(), JsError> {
        self.settings.ambient = three("the ambient light", color)?;
        Ok(())
    }

    /// Colour where there is nothing, linear.
    #[wasm_bindgen(setter)]
    pub fn set_background(&mut self, color: &[f32]) -> Result<(), JsError> {
        self.settings.background = three("the background", color)?;
        Ok(())
    }
}

impl Settings {
    /// As the core takes them, for a scene seen by a camera.
    pub(crate) fn of(&self, scene: &Scene<'_>, camera: &Camera) -> render::Settings {
        let supersample = match self.supersample {
            Which::All => Supersample::All,
            Which::Near => Supersample::near(scene.geometry, &camera.0, 0.5),
            Which::Adaptive => Supersample::Adaptive { degrees: 2.0 },
        };
        render::Settings { supersample, ..self.settings }
    }

    /// The lights, or the default one.
    pub(crate) fn lights(&self, scene: &Scene<'_>, camera: &Camera) -> Vec<Light> {
        let mut lights = self.lights.clone();
        if lights.is_empty() {
            // Above the eye as the picture has it.
            let upright = camera.0.checked().unwrap_or(camera.0);
            lights.push(upright.headlight(scene.bounds.radius()));
        }
        lights.iter_mut().for_each(|light| light.shadow = self.shadows);
        lights
    }
}

/// Three numbers.
fn three<T: Copy>(what: &str, numbers: &[T]) -> Result<[T; 3], JsError> {
    numbers.try_into().map_err(|_| error(format!("{what} has {} numbers: expected 3", numbers.len())))
}

fn all_effects() -> String {
    Effects::ALL.names().collect::<Vec<_>>().join(", ")
}
