//! Rows of pixels: camera rays traced, shaded, averaged and encoded.
//!
//! In: a view of a scene, settings, a range of rows and room for their pixels. Out: RGBA8 pixels and how many rays they
//! took. A pixel depends on nothing but the scene, the settings and its place: rows can be rendered in any order, on
//! any number of threads, and give the same bits. Nothing is allocated.
//!
//! Rays run in grid coordinates, surfaces are lit in the world's: the map between them keeps directions. Materials and
//! normals are looked up at hits only.

mod sampling;

use core::ops::Range;

use crate::camera::{Camera, CameraError, Rays};
use crate::color::{self, Mean};
use crate::dag::Dag;
use crate::geometry::Geometry;
use crate::grid::Grid;
use crate::material::Material;
use crate::materials::Materials;
use crate::math;
use crate::normal::{self, NormalKind};
use crate::shade::{self, Light, Surface};
use crate::trace::{Arithmetic, Hit, Query, Tracer};
use sampling::{CENTER, Seen, Smooth};
pub use sampling::{Samples, Supersample};

/// Largest width and height of a picture.
pub const MAX_SIDE: u32 = 65_536;

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
}

impl Default for Settings {
    /// 1024 x 1024, one sample, exact rays, [`NormalKind::Plane2`], faint ambient light and a light grey background.
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

/// How many rays were traced, and what they met.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Counters {
    /// Rays from the camera.
    pub primary: u64,
    /// Rays towards lights.
    pub shadow: u64,
    /// Rays from surfaces elsewhere.
    pub secondary: u64,
    /// Primary rays that met a voxel.
    pub hits: u64,
    /// Pixels that took all samples of a pattern of more than one.
    pub supersampled: u64,
}

impl core::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Counters) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.secondary += other.secondary;
        self.hits += other.hits;
        self.supersampled += other.supersampled;
    }
}

/// Why rows cannot be rendered.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RenderError {
    /// Width or height is not 1 to 65 536.
    Size {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The rows end after the picture, or before they start.
    Rows {
        /// First row asked for.
        start: u32,
        /// The row after the last one.
        end: u32,
        /// Rows of the picture.
        height: u32,
    },
    /// The room for pixels is not that of the rows.
    Output {
        /// Pixels in the rows.
        expected: u64,
        /// Pixels that `out` holds.
        found: u64,
    },
    /// The camera sees nothing.
    Camera(CameraError),
}

impl core::fmt::Display for RenderError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            RenderError::Size { width, height } => {
                write!(f, "a picture of {width} x {height} is out of range: expected 1 to {MAX_SIDE} pixels a side")
            }
            RenderError::Rows { start, end, height } => {
                write!(f, "rows {start} to {end} do not lie in a picture of {height} rows")
            }
            RenderError::Output { expected, found } => {
                write!(f, "the output has room for {found} pixels: expected {expected}, rows times width")
            }
            RenderError::Camera(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for RenderError {}

/// A pixel, as the rays that pass through it.
#[derive(Clone, Copy, Debug)]
pub struct Pixel<'a> {
    rays: &'a Rays,
    /// The camera's eye in grid coordinates.
    eye: [f64; 3],
    corner: [f64; 2],
}

impl Pixel<'_> {
    /// The ray in grid coordinates, its direction not of unit length, through `place` (x and y from the pixel's upper
    /// left corner, 0 to 1; see [`Samples::position`]).
    #[inline]
    pub fn query(&self, place: [f64; 2]) -> Query {
        Query::new(self.eye, self.rays.direction(self.corner[0] + place[0], self.corner[1] + place[1]))
    }
}

/// Fills `out`, row by row, with what `look` makes of each pixel in `rows` (row 0 is the top) of a picture of
/// `[width, height]` pixels: for pictures that a program shades itself.
#[inline]
pub fn each_pixel<T>(
    camera: &Camera,
    grid: &Grid,
    [width, height]: [u32; 2],
    rows: Range<u32>,
    out: &mut [T],
    mut look: impl FnMut(&Pixel<'_>) -> T,
) -> Result<(), RenderError> {
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(RenderError::Size { width, height });
    }
    if rows.start > rows.end || rows.end > height {
        return Err(RenderError::Rows { start: rows.start, end: rows.end, height });
    }
    let expected = u64::from(rows.end - rows.start) * u64::from(width);
    if out.len() as u64 != expected {
        return Err(RenderError::Output { expected, found: out.len() as u64 });
    }
    let rays = camera.rays(width, height).map_err(RenderError::Camera)?;
    let eye = grid.to_grid(camera.eye);
    for (y, row) in rows.zip(out.chunks_exact_mut(width as usize)) {
        for (x, pixel) in row.iter_mut().enumerate() {
            *pixel = look(&Pixel { rays: &rays, eye, corner: [x as f64, f64::from(y)] });
        }
    }
    Ok(())
}

/// Renders `rows` (row 0 is the top) into `out`, row by row: a pixel is `u32::from_le_bytes([red, green, blue, 255])`.
pub fn render_rows<M: Materials, G: Geometry>(
    view: &View<'_, M, G>,
    settings: &Settings,
    rows: Range<u32>,
    out: &mut [u32],
) -> Result<Counters, RenderError> {
    let background = settings.background.map(color::quantize);
    let smooth = match settings.supersample {
        Supersample::Adaptive { degrees } => Some(Smooth::within(degrees)),
        _ => None,
    };
    let mut counters = Counters::default();
    let mut trace = |query: &Query| {
        let hit = view.tracer.trace(settings.arithmetic, query);
        counters.primary += 1;
        counters.hits += u64::from(hit.is_some());
        hit
    };
    let mut supersampled = 0;
    each_pixel(&view.camera, &view.grid, [settings.width, settings.height], rows, out, |pixel| {
        // Choose the pattern, and its first samples; what the centre's ray met is not asked for again.
        let mut center = None;
        let chosen = match settings.supersample {
            Supersample::All | Supersample::Adaptive { .. } => true,
            Supersample::Slab { axis, from, to } => {
                let hit = trace(&pixel.query(CENTER));
                center = Some(hit);
                let layer = hit.and_then(|hit| hit.voxel.decode().get(usize::from(axis)).copied());
                layer.is_some_and(|layer| (from..to).contains(&layer))
            }
            Supersample::Region { from, to } => (0..2).all(|i| (from[i]..to[i]).contains(&(pixel.corner[i] as u32))),
        };
        let samples = if chosen { settings.samples } else { Samples::One };
        let (mut left, mut others) = match smooth {
            Some(_) => (samples.corners(), samples.all() & !samples.corners()),
            None => (samples.all(), 0),
        };

        // Take them, and the others as well where two of them part.
        let (mut mean, mut first) = (Mean::default(), None);
        while left != 0 {
            let place = samples.position(left.trailing_zeros());
            left &= left - 1;
            let query = pixel.query(place);
            let hit = match center {
                Some(hit) if place == CENTER => hit,
                _ => trace(&query),
            };
            let surface = hit.map(|hit| look(view, settings, &query, &hit));
            mean.add(surface.map_or(background, |(color, _)| color.map(color::quantize)));
            if let (Some(smooth), true) = (smooth, others != 0) {
                let seen = surface.map(|(_, seen)| seen);
                if !smooth.joins(*first.get_or_insert(seen), seen) {
                    left |= core::mem::take(&mut others);
                }
            }
        }

        let many = chosen && others == 0 && samples != Samples::One;
        supersampled += u64::from(many);
        let mut rgb = mean.srgb8();
        if many && settings.mark_supersampled {
            rgb = [255, rgb[1] / 3, rgb[2] / 3];
        }
        let [red, green, blue] = rgb;
        u32::from_le_bytes([red, green, blue, 255])
    })?;
    Ok(Counters { supersampled, ..counters })
}

/// What the surface at a hit sends back along the ray, linear red, green, blue; and which surface it is.
fn look<M: Materials, G: Geometry>(
    view: &View<'_, M, G>,
    settings: &Settings,
    query: &Query,
    hit: &Hit,
) -> ([f32; 3], Seen) {
    let id = view.materials.id(hit.voxel);
    let material = view.palette.get(usize::from(id)).unwrap_or(&Material::GREY);
    let normal = normal::normal(&view.tracer, view.materials, hit, query.dir, settings.normals).direction;
    let back = math::normalize(query.dir.map(|x| -x)).unwrap_or([0.0; 3]);
    let surface = Surface {
        point: view.grid.to_world(math::add_scaled(query.origin, query.dir, hit.t)),
        normal,
        view: back.map(|x| x as f32),
    };
    let color = shade::shade(material, &surface, settings.ambient, view.lights);
    (color, Seen { voxel: hit.voxel, material: id, normal })
}
