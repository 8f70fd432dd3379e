//! The pixels of a picture, as rays through them.

use core::ops::Range;

use crate::camera::{Camera, CameraError, Rays};
use crate::grid::Grid;
use crate::trace::{Query, Tile};

/// Largest width and height of a picture.
pub const MAX_SIDE: u32 = 65_536;

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

/// What all pixels of a picture share.
#[derive(Debug)]
pub(super) struct Frame {
    rays: Rays,
    /// The camera's eye in grid coordinates.
    eye: [f64; 3],
}

impl Frame {
    /// Of a picture of `[width, height]` pixels, whose `rows` are to go into `room` pixels.
    pub(super) fn new(
        camera: &Camera,
        grid: &Grid,
        [width, height]: [u32; 2],
        rows: &Range<u32>,
        room: usize,
    ) -> Result<Frame, RenderError> {
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(RenderError::Size { width, height });
        }
        if rows.start > rows.end || rows.end > height {
            return Err(RenderError::Rows { start: rows.start, end: rows.end, height });
        }
        let expected = u64::from(rows.end - rows.start) * u64::from(width);
        if room as u64 != expected {
            return Err(RenderError::Output { expected, found: room as u64 });
        }
        let rays = camera.rays(width, height).map_err(RenderError::Camera)?;
        Ok(Frame { rays, eye: grid.to_grid(camera.eye) })
    }

    /// The rays through places of the picture, in pixels from its upper left corner.
    pub(super) fn rays<'a>(&self, places: &'a [[f64; 2]]) -> Tile<'a> {
        self.rays.tile(self.eye, places)
    }

    /// The pixel in column `x` and row `y`.
    #[inline]
    fn pixel(&self, x: u32, y: u32) -> Pixel<'_> {
        Pixel { frame: self, corner: [x, y].map(f64::from) }
    }
}

/// A pixel, as the rays that pass through it.
#[derive(Clone, Copy, Debug)]
pub struct Pixel<'a> {
    frame: &'a Frame,
    corner: [f64; 2],
}

impl Pixel<'_> {
    /// The ray in grid coordinates, its direction not of unit length, through `place` (x and y from the pixel's upper
    /// left corner, 0 to 1; see [`Samples::position`](super::Samples::position)).
    #[inline]
    pub fn query(&self, place: [f64; 2]) -> Query {
        let Frame { rays, eye } = self.frame;
        Query::new(*eye, rays.direction(self.corner[0] + place[0], self.corner[1] + place[1]))
    }
}

/// Fills `out`, row by row, with what `look` makes of each pixel in `rows` (row 0 is the top) of a picture of
/// `[width, height]` pixels: for pictures that a program shades itself.
#[inline]
pub fn each_pixel<T>(
    camera: &Camera,
    grid: &Grid,
    size: [u32; 2],
    rows: Range<u32>,
    out: &mut [T],
    mut look: impl FnMut(&Pixel<'_>) -> T,
) -> Result<(), RenderError> {
    let frame = Frame::new(camera, grid, size, &rows, out.len())?;
    for (y, row) in rows.zip(out.chunks_exact_mut(size[0] as usize)) {
        for (x, pixel) in (0..).zip(row) {
            *pixel = look(&frame.pixel(x, y));
        }
    }
    Ok(())
}
