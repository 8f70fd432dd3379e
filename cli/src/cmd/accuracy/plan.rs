//! What is measured: settings along one axis at a time from the default, and combinations that a person would try.
//!
//! The default is `render`'s own, at the resolution of the list that is nearest to [`USUAL`].

use clap::ValueEnum;
use serde::Serialize;
use voxdag::render::Samples;

use crate::options::{ArithmeticArg, BuildArgs, CoverArg, MaterialsArg, NormalsArg, SupersampleArg, name_of};
use crate::quality::Quality;

/// The resolution that the other axes are measured at, if it is on the list.
const USUAL: u32 = 1024;

/// What differs from the default.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    Default,
    Resolution,
    Lod,
    Overlap,
    Cover,
    Arithmetic,
    Normals,
    Samples,
    /// More than one of them.
    Combined,
}

/// How triangles are tested against voxels.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Overlap {
    /// 13 separating axes in f32.
    F32,
    /// The same in f64.
    F64,
    /// In integers.
    Exact,
}

/// The voxels of a setting.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Voxels {
    pub resolution: u32,
    pub cover: CoverArg,
    pub overlap: Overlap,
    /// Whether they keep the triangles' normals.
    pub normals: bool,
}

/// What is measured.
#[derive(Clone, Debug)]
pub struct Setting {
    pub axis: Axis,
    /// What differs from the default, for people.
    pub label: String,
    pub voxels: Voxels,
    pub quality: Quality,
}

impl Setting {
    /// The flags of `render MESH` that give it; none where the overlap is a textbook's, which no flag gives.
    pub fn flags(&self) -> String {
        let Voxels { resolution, cover, overlap, normals } = self.voxels;
        if overlap != Overlap::Exact {
            return String::new();
        }
        let build = BuildArgs {
            resolution: Some(resolution),
            cover: Some(cover).filter(|cover| *cover != CoverArg::default()),
            materials: normals.then_some(MaterialsArg::TableNormals),
            ..BuildArgs::default()
        };
        format!("{} {}", build.typed().trim_start(), self.quality.flags())
    }
}

/// All settings, the default first; fewer where it is to be `quick`. `resolutions` ascend, and there is one at least.
pub fn settings(resolutions: &[u32], quick: bool) -> Vec<Setting> {
    let usual = resolutions.iter().copied().min_by_key(|n| n.abs_diff(USUAL)).unwrap_or(USUAL);
    let voxels = Voxels { resolution: usual, cover: CoverArg::Exact, overlap: Overlap::Exact, normals: false };
    let quality = Quality::default();
    let mut plan =
        Plan { usual: Setting { axis: Axis::Default, label: "default".to_owned(), voxels, quality }, all: Vec::new() };
    plan.add(Axis::Default, "default", |_| ());

    for &resolution in resolutions {
        plan.add(Axis::Resolution, format!("{resolution}^3"), |s| s.voxels.resolution = resolution);
    }
    // Not beyond the single voxel that is left in the end.
    let levels = usual.next_power_of_two().ilog2() as u8;
    for lod in 1..=levels.min(if quick { 1 } else { 3 }) {
        plan.add(Axis::Lod, format!("LOD {lod}"), |s| s.quality.lod = lod);
    }
    // The slowest to build, of pictures that hardly differ: what they get wrong is counted anyway.
    if !quick {
        plan.add(Axis::Overlap, "f32 overlap", |s| s.voxels.overlap = Overlap::F32);
        plan.add(Axis::Overlap, "f64 overlap", |s| s.voxels.overlap = Overlap::F64);
    }
    for (cover, label) in [(CoverArg::Thin, "thin cover"), (CoverArg::Inflated, "inflated cover")] {
        plan.add(Axis::Cover, label, |s| s.voxels.cover = cover);
    }
    for (arithmetic, label) in [(ArithmeticArg::F32, "f32 rays"), (ArithmeticArg::F64, "f64 rays")] {
        plan.add(Axis::Arithmetic, label, |s| s.quality.arithmetic = arithmetic);
    }
    for &normals in NormalsArg::value_variants() {
        plan.add(Axis::Normals, format!("{} normals", name_of(normals)), |s| {
            s.quality.normals = normals;
            s.voxels.normals = normals == NormalsArg::Stored;
        });
    }
    for (samples, supersample) in samples(quick) {
        plan.add(Axis::Samples, label(samples, supersample), |s| {
            (s.quality.samples, s.quality.supersample) = (samples, supersample);
        });
    }

    // What is said to be more accurate, for each resolution.
    let better = [
        (NormalsArg::Plane2, CoverArg::Exact, ""),
        (NormalsArg::Plane3, CoverArg::Exact, ", plane3"),
        (NormalsArg::Plane3, CoverArg::Thin, ", thin, plane3"),
    ];
    for &resolution in resolutions {
        for (normals, cover, of) in &better[..if quick { 1 } else { better.len() }] {
            for (samples, supersample) in [
                (Samples::One, SupersampleArg::All),
                (Samples::Sixteen, SupersampleArg::Adaptive(2.0)),
                (Samples::Sixteen, SupersampleArg::All),
            ] {
                plan.add(Axis::Combined, format!("{resolution}^3, {}{of}", label(samples, supersample)), |s| {
                    (s.voxels.resolution, s.voxels.cover) = (resolution, *cover);
                    s.quality = Quality { samples, supersample, normals: *normals, ..s.quality };
                });
            }
        }
    }
    plan.all
}

/// The patterns of samples, and which pixels take them.
fn samples(quick: bool) -> Vec<(Samples, SupersampleArg)> {
    use SupersampleArg::{Adaptive, All, Near};
    let mut list = vec![(Samples::One, All), (Samples::Sixteen, All)];
    let (near, sixteen, sixty_four): (&[f64], &[f32], &[f32]) = if quick {
        (&[0.5], &[10.0, 2.0], &[2.0])
    } else {
        (&[0.25, 0.5, 0.75], &[20.0, 5.0, 2.0, 0.5], &[20.0, 5.0, 2.0])
    };
    list.extend(near.iter().map(|&share| (Samples::Sixteen, Near(share))));
    list.extend(sixteen.iter().map(|&degrees| (Samples::Sixteen, Adaptive(degrees))));
    list.extend(sixty_four.iter().map(|&degrees| (Samples::SixtyFour, Adaptive(degrees))));
    list
}

fn label(samples: Samples, supersample: SupersampleArg) -> String {
    match (samples, supersample) {
        (Samples::One, _) => "1 sample".to_owned(),
        (samples, SupersampleArg::All) => format!("{} samples", samples.count()),
        (samples, which) => format!("{} {which}", samples.count()),
    }
}

/// Settings as they come, each once.
struct Plan {
    usual: Setting,
    all: Vec<Setting>,
}

impl Plan {
    fn add(&mut self, axis: Axis, label: impl Into<String>, change: impl FnOnce(&mut Setting)) {
        let mut setting = Setting { axis, label: label.into(), ..self.usual.clone() };
        change(&mut setting);
        if self.all.iter().all(|other| (other.voxels, other.quality) != (setting.voxels, setting.quality)) {
            self.all.push(setting);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_begin_with_the_default_and_differ() {
        for quick in [false, true] {
            let all = settings(&[256, 512, 1024, 2048], quick);
            assert_eq!((all[0].axis, all[0].voxels.resolution), (Axis::Default, 1024));
            assert_eq!(all[0].quality, Quality::default());
            for (i, a) in all.iter().enumerate() {
                assert!(all[..i].iter().all(|b| (a.voxels, a.quality) != (b.voxels, b.quality)), "{}", a.label);
                assert!(all[..i].iter().all(|b| a.label != b.label), "{}", a.label);
            }
            for axis in Axis::value_variants().iter().filter(|axis| !quick || **axis != Axis::Overlap) {
                assert!(all.iter().any(|s| s.axis == *axis), "{axis:?}");
            }
        }
        assert_eq!(settings(&[300], true)[0].voxels.resolution, 300);
        // As many levels of detail as there are.
        for (resolution, most) in [(1, 0), (2, 1), (3, 2), (4, 2), (5, 3), (1 << 20, 3)] {
            let lods = settings(&[resolution], false).into_iter().map(|s| s.quality.lod);
            assert_eq!(lods.max(), Some(most), "{resolution}");
        }
    }
}
