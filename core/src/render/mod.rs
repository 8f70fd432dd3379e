//! Rows of pixels: camera rays traced, shaded, averaged and encoded.
//!
//! In: a view of a scene, settings, a range of rows and room for their pixels. Out: RGBA8 pixels and how many rays they
//! took. A pixel depends on nothing but the scene, the settings and its place: rows can be rendered in any order, on
//! any number of threads, and give the same bits. Nothing is allocated.
//!
//! ```text
//! rows -> tiles of 16 x 4 pixels -> batches of samples -> rays, materials, normals, light by light with its shadows
//! ```
//!
//! Rays run in grid coordinates, surfaces are lit in the world's: the map between them keeps directions. Materials and
//! normals are looked up at hits only. What a surface mirrors and lets through is traced and shaded the same way.

mod batch;
mod bend;
mod follow;
mod frame;
mod kernel;
mod sampling;
mod shadow;
mod show;
mod tile;

use core::ops::Range;

use crate::camera::Camera;
use crate::dag::Dag;
use crate::effects::Effects;
use crate::geometry::Geometry;
use crate::grid::Grid;
use crate::material::Material;
use crate::materials::Materials;
use crate::normal::NormalKind;
use crate::shade::Light;
use crate::trace::{Arithmetic, Tracer};
use batch::Batch;
use follow::{Follow, GOES_ON, Waiting};
use frame::Frame;
pub use frame::{MAX_SIDE, Pixel, RenderError, each_pixel};
use kernel::Chosen;
pub use kernel::{Full, Kernel, Phong, Shadows};
pub use sampling::{Samples, Supersample};
pub use show::{Show, Spread, show_rows};
use tile::Tile;

/// How a picture is made.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Settings {
    /// Pixels per row, 1 to 65 536.
    pub width: u32,
    /// Rows, 1 to 65 536.
    pub height: u32,
    /// Samples of the pixels that `supersample` chooses.
    pub samples: Samples,
    /// Which pixels take all of `samples`.
    pub supersample: Supersample,
    /// Whether these pixels are covered with red.
    pub mark_supersampled: bool,
    /// Where normals come from.
    pub normals: NormalKind,
    /// How rays are traced.
    pub arithmetic: Arithmetic,
    /// Linear colour of the light that comes from everywhere.
    pub ambient: [f32; 3],
    /// Linear colour where there is nothing.
    pub background: [f32; 3],
    /// Effects that may be drawn: of these the ones that materials and lights call for ([`Effects::needed`]).
    pub effects: Effects,
    /// How high above a surface the rays start that leave it, along its fitted normal, where the way there is free: 1 is just
    /// above its steps, `|nx| + |ny| + |nz|` voxels along the unit normal n and a thousandth more. 0 is on the steps, exact by
    /// index.
    pub lift: f32,
}

impl Default for Settings {
    /// 1024 x 1024, one sample, exact rays, [`NormalKind::Plane2`], faint ambient light, a light grey background, all
    /// effects that the scene calls for, and rays that start just above the steps.
    fn default() -> Settings {
        Settings {
            width: 1024,
            height: 1024,
            samples: Samples::One,
            supersample: Supersample::All,
            mark_supersampled: false,
            normals: NormalKind::Plane2,
            arithmetic: Arithmetic::Exact,
            ambient: [0.2; 3],
            // sRGB (222, 226, 230).
            background: [0.730_46, 0.760_525, 0.791_298],
            effects: Effects::ALL,
            lift: 1.0,
        }
    }
}

/// What is looked at, and from where.
#[derive(Clone, Copy, Debug)]
pub struct View<'a, M, G = Dag<'a>> {
    /// The voxels, and what rays through them are answered by.
    pub tracer: Tracer<'a, G>,
    /// Which material each voxel has.
    pub materials: M,
    /// The materials by id; an id beyond them is drawn in [`Material::GREY`].
    pub palette: &'a [Material],
    /// Where the voxels lie in the world.
    pub grid: Grid,
    /// The camera, in the world.
    pub camera: Camera,
    /// The lights, in the world.
    pub lights: &'a [Light],
}

/// How many rays were traced, what they met, and what else was worked out. What is not called for counts 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Counters {
    /// Rays from the camera.
    pub primary: u64,
    /// Rays towards lights that cast shadows, from surfaces that face them; without the short ones to where they start.
    pub shadow: u64,
    /// Rays that go on from surfaces: mirrored, or through what is transparent.
    pub secondary: u64,
    /// Primary rays that met a voxel.
    pub hits: u64,
    /// Highlights worked out, one power each.
    pub highlights: u64,
    /// Normals worked out from the voxels around a hit; those on the way of a shadow ray are not counted.
    pub normals: u64,
    /// Colours of textures looked up.
    pub textures: u64,
    /// Pixels that took all samples of a pattern of more than one.
    pub supersampled: u64,
    /// Time, by the kernel's clock ([`Kernel::now`]), that shadow rays took, with the short ones to where they start and those through
    /// what is transparent.
    pub shadow_time: u64,
    /// Time that rays that go on took, with those to where they start if there are no shadow rays, and with the shading of
    /// what they meet, but for the shadows there.
    pub secondary_time: u64,
}

impl core::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Counters) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.secondary += other.secondary;
        self.hits += other.hits;
        self.highlights += other.highlights;
        self.normals += other.normals;
        self.textures += other.textures;
        self.supersampled += other.supersampled;
        self.shadow_time += other.shadow_time;
        self.secondary_time += other.secondary_time;
    }
}

/// Renders `rows` (row 0 is the top) into `out`, row by row: a pixel is `u32::from_le_bytes([red, green, blue, 255])`.
///
/// Fastest for a multiple of 4 rows. Takes up to 200 KiB of stack, most of it for 256 samples on their way, up to 350 KiB where
/// rays go on from surfaces, and no heap.
///
/// Draws by the kernel [`Shadows`] where that is enough, else by [`Full`]: narrower ones save code, but no time.
pub fn render_rows<M: Materials, G: Geometry>(
    view: &View<'_, M, G>,
    settings: &Settings,
    rows: Range<u32>,
    out: &mut [u32],
) -> Result<Counters, RenderError> {
    let effects = settings.effects.intersection(Effects::needed(view.palette, view.lights));
    if Shadows::EFFECTS.contains(effects) {
        render_rows_by::<Shadows, M, G>(view, settings, rows, out)
    } else {
        render_rows_by::<Full, M, G>(view, settings, rows, out)
    }
}

/// The same by a kernel that is named, `render_rows_by::<Phong, _, _>(..)`: a program that names one links the code of that
/// one. What the kernel cannot draw is off.
#[inline(never)] // one code, however it is called
pub fn render_rows_by<K: Kernel, M: Materials, G: Geometry>(
    view: &View<'_, M, G>,
    settings: &Settings,
    rows: Range<u32>,
    out: &mut [u32],
) -> Result<Counters, RenderError> {
    let size = [settings.width, settings.height];
    let frame = Frame::new(&view.camera, &view.grid, size, &rows, out.len())?;
    let effects = settings.effects.intersection(Effects::needed(view.palette, view.lights));
    let settings = &Chosen::<K>::new(settings, effects);
    let mut batch = Batch::new();
    // Room for rays that go on is taken only where there are some.
    if settings.effects().intersects(GOES_ON) {
        Ok(with_follow(&frame, view, settings, &mut batch, rows, out))
    } else {
        Ok(draw(&frame, Tile::new(view, settings, &mut batch, None), settings.width, rows, out))
    }
}

#[inline(never)]
fn with_follow<K: Kernel, M: Materials, G: Geometry>(
    frame: &Frame,
    view: &View<'_, M, G>,
    settings: &Chosen<K>,
    batch: &mut Batch,
    rows: Range<u32>,
    out: &mut [u32],
) -> Counters {
    // Each where it stays: what is moved takes its room twice.
    let mut more = Batch::new();
    let mut waiting = Waiting::new();
    let follow = Follow { batch: &mut more, waiting: &mut waiting };
    draw(frame, Tile::new(view, settings, batch, Some(follow)), settings.width, rows, out)
}

/// Draws rows tile by tile.
#[inline]
fn draw<K: Kernel, M: Materials, G: Geometry>(
    frame: &Frame,
    mut tile: Tile<'_, K, M, G>,
    width: u32,
    rows: Range<u32>,
    out: &mut [u32],
) -> Counters {
    let strips = out.chunks_mut(tile::HEIGHT as usize * width as usize);
    for (y, strip) in rows.step_by(tile::HEIGHT as usize).zip(strips) {
        for x in (0..width).step_by(tile::WIDTH as usize) {
            tile.draw(frame, [x, y], strip);
        }
    }
    tile.counters()
}
