//! What of a picture's settings trades accuracy for time, as one value: what `accuracy` sweeps and `render --budget`
//! chooses from. It is applied to the flags of a picture, and told as the flags that give it.

use voxdag::render::Samples;

use crate::options::{ArithmeticArg, NormalsArg, PictureArgs, SupersampleArg, name_of};

/// How well a picture is drawn.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Quality {
    pub samples: Samples,
    pub supersample: SupersampleArg,
    pub normals: NormalsArg,
    pub arithmetic: ArithmeticArg,
    pub lod: u8,
}

impl Default for Quality {
    /// That of `render` where nothing is said.
    fn default() -> Quality {
        Quality {
            samples: Samples::Four,
            supersample: SupersampleArg::All,
            normals: NormalsArg::default(),
            arithmetic: ArithmeticArg::default(),
            lod: 0,
        }
    }
}

impl Quality {
    /// The picture of `args` in this quality.
    pub fn apply(self, args: &PictureArgs) -> PictureArgs {
        let Quality { samples, supersample, normals, arithmetic, lod } = self;
        let (samples, supersample) = (Some(samples), Some(supersample));
        PictureArgs { samples, supersample, normals, arithmetic, lod, ..args.clone() }
    }

    /// The flags that give it; those of the default are left out but for the samples.
    pub fn flags(self) -> String {
        let usual = Quality::default();
        let mut flags = format!("--samples {}", self.samples.count());
        if self.supersample != usual.supersample {
            flags += &format!(" --supersample {}", self.supersample);
        }
        if self.normals != usual.normals {
            flags += &format!(" --normals {}", name_of(self.normals));
        }
        if self.arithmetic != usual.arithmetic {
            flags += &format!(" --arithmetic {}", name_of(self.arithmetic));
        }
        if self.lod != usual.lod {
            flags += &format!(" --lod {}", self.lod);
        }
        flags
    }
}
