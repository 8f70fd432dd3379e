//! About how long the pieces of the work take, in a common unit, for the estimate of what is left.

use voxdag::render::Samples;

use crate::options::SupersampleArg;
use crate::quality::Quality;

/// Everything but a picture with one sample, which is the unit, as measured on the bunny at 640x360.
pub const TRUTH: u64 = 300;
pub const REFERENCE: u64 = 80;
pub const ERRORS: u64 = 20;
pub const WRONG: u64 = 400;

/// Building a scene: voxels grow with the square of the resolution.
pub fn build(resolution: u32) -> u64 {
    1 + (u64::from(resolution).pow(2) >> 17)
}

/// A picture.
pub fn draw(quality: &Quality) -> u64 {
    let all = u64::from(quality.samples.count());
    match quality.supersample {
        SupersampleArg::All => all,
        SupersampleArg::Near(share) => 1 + (all as f64 * share) as u64,
        SupersampleArg::Region(_) => all,
        SupersampleArg::Adaptive(_) => u64::from(Samples::Four.count()) + all / 4,
    }
}
