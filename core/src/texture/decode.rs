//! Picture files to pixels: PNG, JPEG, BMP and TGA, told apart by what they begin with (TGA, which begins with nothing of
//! its own, by its name).
//!
//! In: the bytes of a file. Out: a picture, or what is wrong with the file. Sizes are checked before memory is taken.

use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use std::io::Cursor;

use image::error::LimitErrorKind;
use image::{ImageError, ImageFormat, ImageReader, Limits};

use super::{DecodeError, Image};

/// Longest side of a picture in pixels.
pub const MAX_IMAGE_SIDE: u32 = 16_384;
/// Most bytes of what is no pixel, unpacked: a colour profile of some hundred bytes can stand for megabytes.
const BESIDE: u64 = 1 << 24;

/// Decodes the bytes of the file called `name`, if that takes at most `limit` bytes.
pub fn decode(name: &str, bytes: &[u8], limit: u64) -> Result<Image, DecodeError> {
    const UNKNOWN: &str = "it is no picture that is known: expected PNG, JPEG, BMP or TGA";
    let is_tga = name.rsplit('.').next().is_some_and(|e| e.eq_ignore_ascii_case("tga"));
    let format = image::guess_format(bytes).ok().or(is_tga.then_some(ImageFormat::Tga));
    let format = format.ok_or_else(|| UNKNOWN.to_string())?;
    let reader = |pixels: u64| {
        let mut limits = Limits::no_limits();
        (limits.max_image_width, limits.max_image_height) = (Some(MAX_IMAGE_SIDE), Some(MAX_IMAGE_SIDE));
        limits.max_alloc = Some(pixels.saturating_add(BESIDE));
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        reader.limits(limits);
        reader
    };
    let failed = |error| match error {
        ImageError::Limits(why) if why.kind() == LimitErrorKind::DimensionError => {
            format!("it is larger than {MAX_IMAGE_SIDE} pixels a side")
        }
        ImageError::Unsupported(_) => UNKNOWN.to_string(),
        error => format!("it is damaged: {error}"),
    };
    // Up to 16 bytes a pixel as it comes, 4 as it is kept, and half of that for its halves.
    let (width, height) = reader(0).into_dimensions().map_err(failed)?;
    let needed = 22 * u64::from(width) * u64::from(height);
    if width.max(height) <= MAX_IMAGE_SIDE && needed > limit {
        return Err(DecodeError::Limit { needed });
    }

    let rgba = reader(needed).decode().map_err(failed)?.into_rgba8();
    let (width, height) = rgba.dimensions();
    let mut pixels = Vec::new();
    let (four, _) = rgba.as_raw().as_chunks::<4>();
    pixels.try_reserve_exact(four.len()).map_err(|_| format!("out of memory: {} bytes", rgba.as_raw().len()))?;
    pixels.extend(four.iter().map(|pixel| u32::from_le_bytes(*pixel)));
    drop(rgba);
    Ok(Image::new(width, height, pixels).map_err(|error| error.to_string())?)
}
