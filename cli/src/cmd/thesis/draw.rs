//! The configurations that the thesis draws, and this program's own: drawn in turns, timed, and kept as pictures.

use voxdag::render::Samples;

use super::measure::{DAG, MOXEL_DAG, MOXELS_NORMALS, SSVDAG, Subject, TABLE, TABLE_NORMALS, TREE};
use super::published::Published;
use super::report::Report;
use super::table::Cell;
use crate::error::Result;
use crate::measure::Spread;
use crate::memory::Memory;
use crate::options::{NormalsArg, PictureArgs, SupersampleArg, supersample};
use crate::picture::{self, Extras, Picture, Shown};
use crate::stats::ms;

/// A way to draw the scene.
struct Configuration {
    /// In file names.
    name: &'static str,
    layout: usize,
    materials: usize,
    normals: NormalsArg,
    samples: Samples,
    supersample: Option<SupersampleArg>,
    /// What the picture is called that has red on the pixels with all samples, if it is drawn.
    in_red: Option<&'static str>,
    /// Whether its picture is kept: not where it is the same as another one's.
    shown: bool,
    /// Where its time is put and what it is called there; `None`: it is only looked at.
    timed: Option<(&'static str, &'static str)>,
    /// The thesis's times.
    published: Option<fn(&Published) -> &[u32; 3]>,
}

/// Draws every configuration in turns, puts the times into the tables, and gives the pictures by name.
pub fn run<'a>(
    subject: &Subject<'_>,
    report: &mut Report,
    shown: &dyn Fn(usize, usize) -> Result<Shown<'a>>,
    args: &PictureArgs,
    progress: &dyn Fn(f64),
    memory: &Memory,
) -> Result<Vec<(&'static str, Picture)>> {
    let plain = Configuration {
        name: "",
        layout: DAG,
        materials: TABLE,
        normals: NormalsArg::Ernerfeldt2,
        samples: Samples::Five,
        supersample: None,
        in_red: None,
        shown: true,
        timed: None,
        published: None,
    };
    let near = supersample("near").ok();
    let adaptive = supersample("adaptive").ok();
    let configurations = [
        Configuration {
            name: "stored-normals",
            materials: TABLE_NORMALS,
            normals: NormalsArg::Stored,
            timed: Some(("5.5", "sparse voxel DAG, hash table")),
            published: Some(|p| &p.render_dag),
            ..plain
        },
        Configuration {
            name: "moxel",
            shown: false,
            layout: MOXEL_DAG,
            materials: MOXELS_NORMALS,
            normals: NormalsArg::Stored,
            timed: Some(("5.5", "moxel DAG, moxel table")),
            published: Some(|p| &p.render_moxel),
            ..plain
        },
        Configuration {
            name: "calculated-normals",
            timed: Some(("5.7", "calculated normals, as the thesis has them")),
            published: Some(|p| &p.render_calculated),
            ..plain
        },
        Configuration {
            name: "plane2",
            normals: NormalsArg::Plane2,
            timed: Some(("5.7", "calculated normals, guarded (plane2)")),
            ..plain
        },
        Configuration {
            name: "default",
            shown: false,
            materials: TREE,
            normals: NormalsArg::Plane2,
            timed: Some(("5.7", "the same with the material tree")),
            ..plain
        },
        Configuration {
            name: "ssvdag",
            shown: false,
            layout: SSVDAG,
            materials: TREE,
            normals: NormalsArg::Plane2,
            timed: Some(("5.7", "the same on the SSVDAG")),
            ..plain
        },
        Configuration {
            name: "1-sample",
            samples: Samples::One,
            timed: Some(("5.8", "1 sample")),
            published: Some(|p| &p.samples_1),
            ..plain
        },
        Configuration {
            name: "16-samples",
            samples: Samples::Sixteen,
            timed: Some(("5.8", "16 samples")),
            published: Some(|p| &p.samples_16),
            ..plain
        },
        Configuration {
            name: "near",
            samples: Samples::Sixteen,
            supersample: near,
            in_red: Some("near-in-red"),
            timed: Some(("5.8", "16 samples on the nearer half")),
            published: Some(|p| &p.samples_near),
            ..plain
        },
        Configuration {
            name: "adaptive",
            samples: Samples::Sixteen,
            supersample: adaptive,
            in_red: Some("adaptive-in-red"),
            timed: Some(("5.8", "16 samples, adaptive")),
            ..plain
        },
        Configuration { name: "radius-1", normals: NormalsArg::Ernerfeldt1, samples: Samples::One, ..plain },
        Configuration {
            name: "triangle-normals",
            materials: TABLE_NORMALS,
            normals: NormalsArg::Stored,
            samples: Samples::One,
            ..plain
        },
    ];
    let one = |configuration: &Configuration, mark| {
        let Configuration { layout, materials, normals, samples, supersample, .. } = *configuration;
        let args = PictureArgs { normals, samples: Some(samples), supersample, ..args.clone() };
        picture::draw(
            &shown(layout, materials)?,
            &args,
            Extras { mark_supersampled: mark, ..Extras::default() },
            memory,
        )
    };

    let mut times = vec![Vec::new(); configurations.len()];
    let mut pictures = Vec::new();
    for run in 0..subject.runs as usize {
        for i in 0..configurations.len() {
            let i = (run + i) % configurations.len();
            let configuration = &configurations[i];
            if configuration.timed.is_none() && run > 0 {
                continue;
            }
            let picture = one(configuration, false)?;
            times[i].push(ms(picture.derive + picture.trace));
            if run == 0 && configuration.shown {
                pictures.push((configuration.name, picture));
            }
        }
        progress(0.5 / f64::from(subject.runs));
    }
    for configuration in &configurations {
        if let Some(name) = configuration.in_red {
            pictures.push((name, one(configuration, true)?));
        }
    }

    let all = pictures.iter().find(|(name, _)| *name == "16-samples").map_or(1, |(_, all)| all.rays.primary);
    for (configuration, runs) in configurations.iter().zip(&times) {
        let Some((number, label)) = configuration.timed else { continue };
        let published = configuration.published.filter(|_| subject.usual_view).and_then(|row| subject.published(row));
        let cell = Cell::spread(subject.resolution, Spread::of(runs.iter().copied()), published);
        report.put(number, subject.name, label, cell);
        if let (Some(_), Some((_, picture))) =
            (configuration.supersample, pictures.iter().find(|(name, _)| *name == configuration.name))
        {
            let share = 100.0 * picture.rays.primary as f64 / all as f64;
            report.put("A.1", subject.name, label, Cell::exact(subject.resolution, share, None));
        }
    }
    Ok(pictures)
}
