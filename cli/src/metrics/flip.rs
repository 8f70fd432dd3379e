//! FLIP: how different two pictures look that alternate in one place, per pixel from 0 (equal) to 1.
//!
//! Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom and Fairchild, "FLIP: A Difference Evaluator for Alternating
//! Images", HPG 2020; by `nv-flip`, which is its authors' C++. Seen as their tool has it by default: a screen of 3840 pixels
//! that is 0.7 m wide, from 0.7 m, which is 67 pixels per degree.

use nv_flip::{FlipImageFloat, FlipImageRgb8};

use super::{MOST_PIXELS, View, rgb};

/// The mean over the pixels.
pub fn mean(reference: View<'_>, picture: View<'_>) -> Option<f64> {
    let errors = map(reference, picture)?.to_vec();
    Some(errors.iter().copied().map(f64::from).sum::<f64>() / errors.len() as f64)
}

/// Per pixel, in colours.
pub fn colours(reference: View<'_>, picture: View<'_>) -> Option<Vec<u32>> {
    let colours = map(reference, picture)?.apply_color_lut(&nv_flip::magma_lut()).to_vec();
    Some(colours.chunks_exact(3).map(|p| u32::from_le_bytes([p[0], p[1], p[2], 255])).collect())
}

/// Pictures of the same size; none if they are too large.
fn map(reference: View<'_>, picture: View<'_>) -> Option<FlipImageFloat> {
    let image = |view: View<'_>| {
        let bytes: Vec<u8> = view.pixels.iter().flat_map(|&pixel| rgb(pixel)).collect();
        FlipImageRgb8::with_data(view.width, view.height, &bytes)
    };
    // Not the crate's constant, which is 67 without the digits after it.
    let per_degree = nv_flip::pixels_per_degree(0.7, 3840.0, 0.7);
    (reference.pixels.len() <= MOST_PIXELS).then(|| nv_flip::flip(image(reference), image(picture), per_degree))
}
