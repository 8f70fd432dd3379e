//! The numbers of the report: what `accuracy.json` holds, what `accuracy.csv` does row by row, and what the page shows.

use serde::Serialize;

use super::front::{self, Point};
use super::measure::Found;
use super::plan::{Axis, Overlap, Setting};
use super::wrong::Wrong;
use crate::error::{Error, Kind, Result};
use crate::machine::Machine;
use crate::measure::Spread;
use crate::metrics::Errors;
use crate::options::name_of;
use crate::picture::Rays;
use crate::report::visible;
use crate::stats::ms;
use crate::truth::ShapeErrors;

/// Everything that was measured.
#[derive(Serialize)]
pub struct Report {
    /// As it was typed.
    pub command: String,
    pub machine: Machine,
    pub scene: String,
    pub triangles: usize,
    /// What the truth is drawn from.
    pub truth: &'static str,
    pub truth_ms: f64,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// The camera and the lights, as flags of `render`.
    pub view: String,
    /// How often settings were drawn, and how often voxels were built.
    pub repeat: [u32; 2],
    pub voxels: Vec<Voxels>,
    pub settings: Vec<Measured>,
    pub wrong: Vec<Wrong>,
    pub recommendation: Recommendation,
}

/// A voxel scene.
#[derive(Serialize)]
pub struct Voxels {
    pub resolution: u32,
    pub cover: String,
    pub overlap: Overlap,
    pub stored_normals: bool,
    pub voxels: u64,
    pub bytes: u64,
    pub bits_per_voxel: f64,
    pub build_ms: Times,
    /// The most memory that a `voxdag build` of its own holds; `None` where that is not known.
    pub build_peak_bytes: Option<u64>,
}

/// Milliseconds over the repetitions.
#[derive(Clone, Copy, Serialize)]
pub struct Times {
    pub median: f64,
    pub min: f64,
    pub max: f64,
}

impl Times {
    fn of(seconds: &[f64]) -> Times {
        let Spread { median, min, max } = Spread::of(seconds.iter().map(|s| 1e3 * s));
        Times { median, min, max }
    }
}

/// A setting.
#[derive(Serialize)]
pub struct Measured {
    pub axis: Axis,
    pub label: String,
    /// The place of its voxels in `voxels`.
    pub voxels: usize,
    /// As flags of `render`, those of building first; empty where no flag gives it.
    pub flags: String,
    pub render_ms: Times,
    /// Making what makes rays faster, once.
    pub prepare_ms: f64,
    pub rays: Rays,
    /// Against the truth.
    pub error: Errors,
    /// Of 64 samples of the same voxels with the same normals, against the truth.
    pub voxels_error: Errors,
    /// RMSE against these 64 samples.
    pub sampling_rmse: f64,
    pub shape: ShapeErrors,
    /// Whether nothing faster is as accurate, as [`front`] rounds that.
    pub on_front: bool,
}

/// What to use.
#[derive(Serialize)]
pub struct Recommendation {
    /// The front, the fastest first: places in `settings`.
    pub front: Vec<usize>,
    /// The place in `settings` of what to use where nothing is known of the purpose.
    pub knee: usize,
}

impl Report {
    /// Of all that was found; the rest is filled in by the caller.
    pub fn new(head: Head, settings: &[Setting], found: &Found) -> Result<Report> {
        let Head { scene, triangles, truth, size, view, repeat, threads } = head;
        let voxels: Result<Vec<_>> = found
            .scenes
            .iter()
            .map(|scene| {
                let [voxels, bytes] = scene.size()?;
                Ok(Voxels {
                    resolution: scene.voxels.resolution,
                    cover: name_of(scene.voxels.cover),
                    overlap: scene.voxels.overlap,
                    stored_normals: scene.voxels.normals,
                    voxels,
                    bytes,
                    bits_per_voxel: 8.0 * bytes as f64 / voxels.max(1) as f64,
                    build_ms: Times::of(&scene.seconds),
                    build_peak_bytes: scene.peak,
                })
            })
            .collect();
        let mut measured: Vec<_> = settings
            .iter()
            .zip(&found.rows)
            .map(|(setting, row)| Measured {
                axis: setting.axis,
                label: setting.label.clone(),
                voxels: row.scene,
                flags: setting.flags(),
                render_ms: Times::of(&row.seconds),
                prepare_ms: 1e3 * row.prepare,
                rays: row.rays,
                error: row.errors,
                voxels_error: found.references[row.reference].errors,
                sampling_rmse: row.sampling,
                shape: row.shape,
                on_front: false,
            })
            .collect();

        // What cannot be typed is no recommendation.
        let typed: Vec<_> = (0..measured.len()).filter(|&i| !measured[i].flags.is_empty()).collect();
        let points: Vec<_> = typed
            .iter()
            .map(|&i| Point { cost: measured[i].render_ms.median, error: measured[i].error.rmse })
            .collect();
        let front = front::front(&points);
        let knee = typed[front[front::knee(&points, &front)]];
        let front: Vec<_> = front.into_iter().map(|i| typed[i]).collect();
        front.iter().for_each(|&i| measured[i].on_front = true);
        Ok(Report {
            command: format!("voxdag {}", visible(&crate::report::typed())),
            machine: Machine::with(threads),
            scene,
            triangles,
            truth,
            truth_ms: ms(found.truth_time),
            size,
            view,
            repeat,
            voxels: voxels?,
            settings: measured,
            wrong: found.wrong.clone(),
            recommendation: Recommendation { front, knee },
        })
    }

    /// For programs: a line per setting.
    pub fn csv(&self) -> Result<Vec<u8>> {
        let failed = |error: csv::Error| Error::new(Kind::Failure, error);
        let mut out = csv::Writer::from_writer(Vec::new());
        let head = "axis,label,flags,resolution,cover,overlap,voxels,bytes,build_ms,build_peak_bytes,prepare_ms,render_ms,\
                    render_ms_min,render_ms_max,primary_rays,shadow_rays,rmse,psnr,ssim,flip,differing_pixels,voxels_rmse,\
                    sampling_rmse,silhouette_pixels,depth_median,depth_mean,depth_p95,depth_max,normal_median,normal_mean,normal_p95,normal_max,on_front";
        out.write_record(head.split(',')).map_err(failed)?;
        for s in &self.settings {
            let v = &self.voxels[s.voxels];
            let optional = |x: Option<f64>| x.map(|x| x.to_string()).unwrap_or_default();
            let overlap = name_of(v.overlap);
            let mut record = vec![name_of(s.axis), s.label.clone(), s.flags.clone()];
            record.extend([v.resolution.to_string(), v.cover.clone(), overlap, v.voxels.to_string()]);
            record.extend([v.bytes.to_string(), v.build_ms.median.to_string()]);
            record.extend([v.build_peak_bytes.map(|b| b.to_string()).unwrap_or_default(), s.prepare_ms.to_string()]);
            record.extend([s.render_ms.median, s.render_ms.min, s.render_ms.max].map(|x| x.to_string()));
            record.extend([s.rays.primary.to_string(), s.rays.shadow.to_string()]);
            let Errors { rmse, psnr, ssim, flip, differing } = s.error;
            record.extend([rmse.to_string(), optional(psnr), ssim.to_string(), optional(flip), differing.to_string()]);
            record.extend([s.voxels_error.rmse.to_string(), s.sampling_rmse.to_string()]);
            let ShapeErrors { silhouette, depth, normal, .. } = s.shape;
            record.push(silhouette.to_string());
            for of in [depth, normal] {
                record.extend(
                    [of.map(|d| d.median), of.map(|d| d.mean), of.map(|d| d.p95), of.map(|d| d.max)].map(optional),
                );
            }
            record.push(s.on_front.to_string());
            out.write_record(record).map_err(failed)?;
        }
        out.into_inner().map_err(|error| Error::new(Kind::Failure, error))
    }

    /// For programs: everything.
    pub fn json(&self) -> Result<Vec<u8>> {
        let mut json = serde_json::to_vec_pretty(self).map_err(|error| Error::new(Kind::Failure, error))?;
        json.push(b'\n');
        Ok(json)
    }

    /// What the default is.
    pub fn usual(&self) -> &Measured {
        &self.settings[0]
    }

    /// What to use where nothing is known of the purpose.
    pub fn knee(&self) -> &Measured {
        &self.settings[self.recommendation.knee]
    }

    /// The recommendation in sentences, the fastest setting first: below which error it stays, and what the next one
    /// costs and brings.
    pub fn advice(&self) -> Vec<Advice<'_>> {
        let front: Vec<_> = self.recommendation.front.iter().map(|&i| &self.settings[i]).collect();
        let next = |i: usize| {
            let (this, next) = (front[i], front.get(i + 1)?);
            let more = next.render_ms.median - this.render_ms.median;
            Some((more, 1.0 - next.error.rmse / this.error.rmse))
        };
        (0..front.len())
            .map(|i| Advice { setting: front[i], below: round_up(front[i].error.rmse), next: next(i) })
            .collect()
    }
}

/// A step of the front.
pub struct Advice<'a> {
    pub setting: &'a Measured,
    /// An error that it stays below.
    pub below: f64,
    /// Milliseconds that the next step costs, and the part of the error that it takes away.
    pub next: Option<(f64, f64)>,
}

/// What the caller knows.
pub struct Head {
    pub scene: String,
    pub triangles: usize,
    pub truth: &'static str,
    pub size: [u32; 2],
    pub view: String,
    pub repeat: [u32; 2],
    pub threads: usize,
}

/// The next number of two digits.
fn round_up(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let scale = libm::exp10(1.0 - libm::floor(libm::log10(x)));
    ((x * scale).floor() + 1.0) / scale
}

#[cfg(test)]
mod tests {
    use super::round_up;

    #[test]
    fn errors_stay_below_what_is_said() {
        for (x, above) in [(0.0123, 0.013), (0.012, 0.013), (0.099, 0.1), (1.0, 1.1), (0.0, 0.0)] {
            assert!((round_up(x) - above).abs() < 1e-12, "{x}: {}", round_up(x));
        }
    }
}
