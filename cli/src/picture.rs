//! From a scene to pixels, rows on all cores, and from pixels to a PNG.

use std::io::Write;

use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;
use serde::Serialize;
use voxdag::camera::Camera;
use voxdag::render::{self, Counters, Settings};

use crate::error::{Error, Kind, Result};
use crate::options::{ArithmeticArg, MachineArgs, NormalsArg, PictureArgs};
use crate::progress::Progress;
use crate::{report, stats};

/// A finished picture and what it took.
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// Row by row from the top left; red in the lowest byte.
    pixels: Vec<u32>,
    pub rays: Rays,
    /// Primary rays that hit a voxel.
    pub hits: u64,
    /// Names of what the scene called for.
    pub effects: Vec<&'static str>,
    pub trace_ms: f64,
}

/// Rays by their purpose.
#[derive(Clone, Copy, Serialize)]
pub struct Rays {
    pub primary: u64,
    pub shadow: u64,
    pub secondary: u64,
}

impl Picture {
    /// Encodes the picture as PNG.
    pub fn write_png(&self, file: impl Write) -> std::io::Result<()> {
        let bytes: Vec<u8> = self.pixels.iter().flat_map(|p| p.to_le_bytes()).collect();
        image::codecs::png::PngEncoder::new(file)
            .write_image(&bytes, self.width, self.height, ExtendedColorType::Rgba8)
            .map_err(std::io::Error::other)
    }
}
