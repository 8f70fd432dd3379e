//! The same detail of several pictures, as images that are part of a page, each with the map of its error.

use std::collections::BTreeSet;

use super::measure::Found;
use super::plan::{Axis, Setting};
use super::report::Report;
use crate::error::{Error, Kind, Result};
use crate::metrics;
use crate::options::NormalsArg;
use crate::picture;
use crate::report::time;

/// A detail of a picture.
pub struct Crop {
    /// The place of the setting; `None` for the truth.
    pub setting: Option<usize>,
    pub label: String,
    pub note: String,
    /// A `data:` address of a PNG.
    pub picture: String,
    /// The same of its error; `None` for the truth.
    pub map: Option<String>,
}

/// The truth's picture, and where in it the details are.
pub struct Whole {
    /// A `data:` address of a PNG.
    pub picture: String,
    /// Left, top, width and height of the details, in parts of the picture's.
    pub frame: [f64; 4],
}

/// Side of a detail, in parts of the picture's.
const PART: u32 = 4;

/// Details of the truth and of settings that show what differs, where the default errs most.
pub fn crops(report: &Report, settings: &[Setting], found: &Found) -> Result<(Vec<Crop>, Whole)> {
    let [width, height] = report.size;
    let size = [width, height].map(|n| n.div_ceil(PART));
    let corner = worst(report.size, size, &found.truth, &found.rows[0].pixels);
    let cut = |pixels: &[u32]| data_url(size, &part(pixels, width, corner, size));
    let truth = metrics::View { width, height, pixels: &found.truth };

    let mut crops = vec![Crop {
        setting: None,
        label: "the truth".to_owned(),
        note: report.truth.to_owned(),
        picture: cut(&found.truth)?,
        map: None,
    }];
    for i in chosen(report, settings) {
        let (measured, pixels) = (&report.settings[i], &found.rows[i].pixels);
        let map = metrics::flip_map(truth, metrics::View { pixels, ..truth });
        crops.push(Crop {
            setting: Some(i),
            label: measured.label.clone(),
            note: format!("{}, RMSE {:.5}", time(measured.render_ms.median), measured.error.rmse),
            picture: cut(pixels)?,
            map: map.map(|map| cut(&map)).transpose()?,
        });
    }
    let parts = |i: usize, n: [u32; 2]| f64::from(n[i]) / f64::from(report.size[i]);
    let frame = [parts(0, corner), parts(1, corner), parts(0, size), parts(1, size)];
    Ok((crops, Whole { picture: data_url(report.size, &found.truth)?, frame }))
}

/// Settings worth seeing: those to choose from, and the ends of the axes.
fn chosen(report: &Report, settings: &[Setting]) -> Vec<usize> {
    let front = &report.recommendation.front;
    let ends = [front.first(), Some(&report.recommendation.knee), front.last()];
    let mut chosen: BTreeSet<usize> = ends.into_iter().flatten().copied().collect();
    chosen.insert(0);
    let mut add = |wanted: &dyn Fn(&Setting) -> bool| {
        chosen.extend(settings.iter().position(wanted));
    };
    add(&|s| s.axis == Axis::Resolution);
    add(&|s| s.axis == Axis::Lod);
    add(&|s| s.axis == Axis::Cover);
    add(&|s| s.axis == Axis::Samples);
    add(&|s| s.axis == Axis::Normals && s.quality.normals == NormalsArg::Face);
    add(&|s| s.axis == Axis::Normals && s.quality.normals == NormalsArg::Stored);
    // The fastest first.
    let mut chosen: Vec<_> = chosen.into_iter().collect();
    chosen.sort_by(|&a, &b| report.settings[a].render_ms.median.total_cmp(&report.settings[b].render_ms.median));
    chosen
}

/// The corner of the part whose colours differ most, among parts at a few places along each side.
fn worst([width, height]: [u32; 2], size: [u32; 2], truth: &[u32], pixels: &[u32]) -> [u32; 2] {
    const STEPS: u32 = 16;
    let place = |i: u32, side: u32, part: u32| (u64::from(i) * u64::from(side - part) / u64::from(STEPS)) as u32;
    let corners = (0..=STEPS).flat_map(|y| (0..=STEPS).map(move |x| [x, y]));
    let corners = corners.map(|[x, y]| [place(x, width, size[0]), place(y, height, size[1])]);
    let error = |corner: &[u32; 2]| {
        let [a, b] = [truth, pixels].map(|pixels| part(pixels, width, *corner, size));
        let view = |pixels| metrics::View { width: size[0], height: size[1], pixels };
        metrics::rmse(view(&a), view(&b))
    };
    corners.map(|corner| (error(&corner), corner)).fold((-1.0, [0; 2]), |a, b| if b.0 > a.0 { b } else { a }).1
}

/// The pixels of a part of a picture.
fn part(pixels: &[u32], width: u32, [x, y]: [u32; 2], size: [u32; 2]) -> Vec<u32> {
    (y..y + size[1]).flat_map(|y| &pixels[(y * width + x) as usize..][..size[0] as usize]).copied().collect()
}

fn data_url(size: [u32; 2], pixels: &[u32]) -> Result<String> {
    let mut png = Vec::new();
    picture::png(size, pixels.iter(), &mut png).map_err(|cause| Error::new(Kind::Failure, cause))?;
    Ok(crate::report::data_url(&png))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_part_is_found() {
        let truth = vec![0xff00_0000; 64 * 32];
        let mut pixels = truth.clone();
        (20..24).for_each(|y| (48..60).for_each(|x| pixels[y * 64 + x] = 0xffff_ffff));
        let [x, y] = worst([64, 32], [16, 8], &truth, &pixels);
        assert!(x <= 48 && x + 16 >= 60 && y <= 20 && y + 8 >= 24, "{x}, {y}");
        assert_eq!(part(&pixels, 64, [46, 20], [4, 2]).iter().filter(|p| **p == 0xffff_ffff).count(), 4);
    }
}
