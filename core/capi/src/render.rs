//! Rows of pixels: a camera, lights, settings.

use voxdag::camera::Camera;
use voxdag::effects::Effects;
use voxdag::render::{Counters, Samples, Settings, Supersample, View, render_rows};
use voxdag::shade::{Light, LightKind};

use crate::border::Caller;
use crate::error::{Failure, VoxdagError, VoxdagStatus};
use crate::ray::arithmetic;
use crate::scene::{VoxdagScene, with_tracer};
use crate::surface::normal_kind;

/// A pinhole camera in the world.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VoxdagCamera {
    /// Where it is.
    pub eye: [f64; 3],
    /// What it looks at: the middle of the picture.
    pub target: [f64; 3],
    /// What points upwards in the picture, of any length.
    pub up: [f64; 3],
    /// Angle between the picture's top and bottom in degrees, above 0 and below 180.
    pub fov_y: f64,
}

/// Where a light is.
#[repr(u32)]
pub enum VoxdagLightKind {
    /// At a position.
    Point = 0,
    /// Infinitely far away, in a direction as seen from the scene.
    Directional = 1,
}

/// A light in the world; its strength does not fall with distance.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VoxdagLight {
    /// `VOXDAG_LIGHT_KIND_*`.
    pub kind: u32,
    /// Whether what stands in its way casts a shadow: 1 or 0.
    pub shadow: u32,
    /// The position, or the direction, of any length but 0.
    pub position: [f64; 3],
    /// Linear red, green, blue, none below 0; 1 is white at full strength.
    pub color: [f32; 3],
}

/// The largest `VoxdagSettings.lift`: beyond it things do not touch their shadows.
const MOST_LIFT: f32 = 16.0;

/// Which pixels take all samples.
#[repr(u32)]
pub enum VoxdagSupersample {
    /// Every pixel.
    All = 0,
    /// Those of a rectangle; the others take their centre.
    Region = 1,
    /// Those whose corner samples do not all see one smooth surface; every pixel where there are fewer than 16 samples.
    Adaptive = 2,
}

/// Effects that may be drawn, one bit each. Those that materials and lights do not call for cost nothing.
#[repr(u32)]
pub enum VoxdagEffects {
    /// Matte surfaces in light that nothing keeps away.
    None = 0,
    /// Highlights.
    Specular = 1,
    /// Shadows of the lights that cast them.
    Shadows = 2,
    /// Reflections.
    Mirror = 4,
    /// Seeing through.
    Transparency = 8,
    /// Rays that bend where they enter and leave.
    Refraction = 16,
    /// Light of its own.
    Emission = 32,
    /// Colours of textures.
    Textures = 64,
    /// All there are.
    All = 127,
}

/// How a picture is made. Begin with `voxdag_settings_default()`.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VoxdagSettings {
    /// Pixels per row, 1 to 65,536.
    pub width: u32,
    /// Rows, 1 to 65,536.
    pub height: u32,
    /// Samples of a pixel: 1, 4, 5, 16 or 64.
    pub samples: u32,
    /// `VOXDAG_SUPERSAMPLE_*`: which pixels take all of them.
    pub supersample: u32,
    /// For REGION: first column and row, the column and the row after the last ones.
    pub region: [u32; 4],
    /// For ADAPTIVE: how many degrees the normals of one surface may differ, 0 to 90.
    pub degrees: f32,
    /// `VOXDAG_NORMALS_*`.
    pub normals: u32,
    /// `VOXDAG_ARITHMETIC_*`.
    pub arithmetic: u32,
    /// Sum of `VOXDAG_EFFECTS_*`.
    pub effects: u32,
    /// Linear colour of the light that comes from everywhere.
    pub ambient: [f32; 3],
    /// Linear colour where there is nothing.
    pub background: [f32; 3],
    /// How high above a surface the rays start that leave it, in steps of voxels, 0 to 16; 1 is just above its steps, 0 on
    /// them.
    pub lift: f32,
}

/// How many rays were traced.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct VoxdagCounters {
    /// From the camera.
    pub primary: u64,
    /// Towards lights that cast shadows.
    pub shadow: u64,
    /// That go on from surfaces.
    pub secondary: u64,
    /// Primary ones that met a voxel.
    pub hits: u64,
}

/// 1024 x 1024, one sample, exact rays, `VOXDAG_NORMALS_PLANE2`, faint ambient light, a light grey background, all effects
/// that the scene calls for.
#[unsafe(no_mangle)]
pub extern "C" fn voxdag_settings_default() -> VoxdagSettings {
    let Settings { width, height, samples, ambient, background, lift, .. } = Settings::default();
    VoxdagSettings {
        width,
        height,
        samples: samples.count(),
        supersample: VoxdagSupersample::All as u32,
        region: [0; 4],
        degrees: 2.0,
        normals: crate::VoxdagNormals::Plane2 as u32,
        arithmetic: crate::VoxdagArithmetic::Exact as u32,
        effects: VoxdagEffects::All as u32,
        ambient,
        background,
        lift,
    }
}

/// The default view of a scene: all of it, from the right, above and in front; and the default light, white, above the eye,
/// without shadows. `light` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_camera_default(
    scene: *const VoxdagScene,
    camera: *mut VoxdagCamera,
    light: *mut VoxdagLight,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let scene = &caller.one("scene", scene)?.scene;
        let view = Camera::framing(&scene.bounds, scene.up);
        let Camera { eye, target, up, fov_y } = view;
        caller.put("camera", camera, VoxdagCamera { eye, target, up, fov_y })?;
        if light.is_null() {
            return Ok(());
        }
        let Light { kind, color, shadow } = view.headlight(scene.bounds.radius());
        let (kind, position) = match kind {
            LightKind::Point(position) => (VoxdagLightKind::Point, position),
            LightKind::Directional(direction) => (VoxdagLightKind::Directional, direction),
        };
        caller.put("light", light, VoxdagLight { kind: kind as u32, shadow: shadow.into(), position, color })
    })
}

/// Draws the rows `first_row` to `end_row - 1` (row 0 is the top) of a picture. Pixels depend on nothing but scene, camera,
/// lights, settings and their place: threads may draw rows of one picture at the same time; fastest for a multiple of 4.
/// Takes up to 350 KiB of stack where rays go on from surfaces, else 200 KiB; the heap only for lights.
///
/// lights: `light_count` of them; null if there are none.
/// pixels: room for `pixel_count` pixels, at least (end_row - first_row) * width, row by row: red in the lowest 8 bits, then
/// green, then blue, then 255, so on a machine that stores the low byte first the bytes R, G, B, A.
/// counters: may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_render_rows(
    scene: *const VoxdagScene,
    camera: *const VoxdagCamera,
    lights: *const VoxdagLight,
    light_count: usize,
    settings: *const VoxdagSettings,
    first_row: u32,
    end_row: u32,
    pixels: *mut u32,
    pixel_count: usize,
    counters: *mut VoxdagCounters,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let scene = caller.one("scene", scene)?;
        let camera = caller.one("camera", camera)?.checked()?;
        let settings = caller.one("settings", settings)?.checked()?;
        let given = caller.slice("lights", lights, light_count)?;
        let mut lights = Vec::new();
        lights.try_reserve_exact(given.len()).map_err(|_| Failure::Memory { needed: size_of_val(given) as u64 })?;
        for (index, light) in given.iter().enumerate() {
            lights.push(light.checked().ok_or(Failure::Light { index: index as u64 })?);
        }
        // Of rows that are not in the picture and of too few pixels the renderer complains; nothing is cleared for the former.
        let rows = if end_row <= settings.height { end_row.saturating_sub(first_row) } else { 0 };
        let needed = u64::from(rows) * u64::from(settings.width);
        let pixels = caller.cleared("pixels", pixels, needed.min(pixel_count as u64) as usize)?;
        let (palette, materials, grid) = (&scene.palette[..], scene.scene.looks(), scene.scene.grid);
        let drawn = with_tracer!(scene, tracer => {
            let view = View { tracer, materials, palette, grid, camera, lights: &lights };
            render_rows(&view, &settings, first_row..end_row, pixels)
        });
        let Counters { primary, shadow, secondary, hits, .. } = drawn?;
        if counters.is_null() {
            return Ok(());
        }
        caller.put("counters", counters, VoxdagCounters { primary, shadow, secondary, hits })
    })
}

impl VoxdagCamera {
    fn checked(&self) -> Result<Camera, Failure> {
        let VoxdagCamera { eye, target, up, fov_y } = *self;
        let camera = Camera { eye, target, up, fov_y };
        // Checked, but not turned upright, which the renderer does itself.
        camera.checked()?;
        Ok(camera)
    }
}

impl VoxdagLight {
    fn checked(&self) -> Option<Light> {
        let kind = match self.kind {
            0 => LightKind::Point(self.position),
            1 => LightKind::Directional(self.position),
            _ => return None,
        };
        let is_somewhere = self.position.iter().all(|x| x.is_finite()) && (self.kind == 0 || self.position != [0.0; 3]);
        let shines = self.color.iter().all(|x| x.is_finite() && *x >= 0.0);
        (is_somewhere && shines).then_some(Light { kind, color: self.color, shadow: self.shadow != 0 })
    }
}

impl VoxdagSettings {
    fn checked(&self) -> Result<Settings, Failure> {
        let VoxdagSettings { width, height, ambient, background, lift, degrees, .. } = *self;
        for (name, value, most) in
            [("ambient", ambient, f32::MAX), ("background", background, f32::MAX), ("lift", [lift; 3], MOST_LIFT)]
        {
            if !value.iter().all(|x| (0.0..=most).contains(x)) {
                return Err(Failure::NotFinite { name });
            }
        }
        let supersample = match self.supersample {
            0 => Supersample::All,
            1 => {
                let [x0, y0, x1, y1] = self.region;
                if x0 > x1 || y0 > y1 {
                    return Err(Failure::NotFinite { name: "region" });
                }
                Supersample::Region { from: [x0, y0], to: [x1, y1] }
            }
            2 if (0.0..=90.0).contains(&degrees) => Supersample::Adaptive { degrees },
            2 => return Err(Failure::NotFinite { name: "degrees" }),
            found => return Err(Failure::Choice { name: "supersample", found }),
        };
        if self.effects & !(VoxdagEffects::All as u32) != 0 {
            return Err(Failure::Choice { name: "set of effects", found: self.effects });
        }
        let effects = Effects::ALL.iter().enumerate().filter(|(bit, _)| self.effects >> bit & 1 != 0);
        Ok(Settings {
            width,
            height,
            samples: Samples::new(self.samples)
                .ok_or(Failure::Choice { name: "number of samples", found: self.samples })?,
            supersample,
            normals: normal_kind(self.normals)?,
            arithmetic: arithmetic(self.arithmetic)?,
            ambient,
            background,
            effects: effects.fold(Effects::NONE, |set, (_, effect)| set.union(effect)),
            lift,
            ..Settings::default()
        })
    }
}
