//! The report as a page of one file: what to use first, then the plots, pictures side by side, tables, and how all of it
//! was made. Nothing is loaded from elsewhere, and everything that comes from files is escaped.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::crops::{Crop, Whole};
use super::front::{self, Point};
use super::plan::Axis;
use super::plot::{Mark, Plot};
use super::report::{Measured, Report, Voxels};
use crate::error::Result;
use crate::options::name_of;
use crate::report::{grouped, size, time};
use crate::truth::Deviations;

const STYLE: &str = include_str!("page.css");

/// The axes by what the page calls them, in the order of the legend.
const AXES: [(Axis, &str); 9] = [
    (Axis::Default, "default"),
    (Axis::Resolution, "resolution"),
    (Axis::Samples, "samples"),
    (Axis::Normals, "normals"),
    (Axis::Lod, "level of detail"),
    (Axis::Cover, "cover"),
    (Axis::Arithmetic, "traversal arithmetic"),
    (Axis::Overlap, "overlap arithmetic"),
    (Axis::Combined, "combinations"),
];

/// The plot that tells most: the error of all settings over their time.
pub fn front_plot(report: &Report) -> Result<String> {
    let all: Vec<_> = report.settings.iter().collect();
    plot(&all, [TIME, "RMSE against the mesh, linear light"], |s| [s.render_ms.median, s.error.rmse])
}

fn flip_plot(report: &Report) -> Result<String> {
    let all: Vec<_> = report.settings.iter().collect();
    plot(&all, [TIME, "FLIP against the mesh, mean"], |s| [s.render_ms.median, s.error.flip.unwrap_or(0.0)])
}

/// Samples of the same voxels.
fn sampling_plot(report: &Report) -> Result<String> {
    let some: Vec<_> = report.settings.iter().filter(|s| matches!(s.axis, Axis::Default | Axis::Samples)).collect();
    plot(&some, [TIME, "RMSE against 64 samples of the same voxels"], |s| [s.render_ms.median, s.sampling_rmse])
}

/// Voxels with 64 samples.
fn voxels_plot(report: &Report) -> Result<String> {
    use Axis::{Cover, Default, Overlap, Resolution};
    let some: Vec<_> =
        report.settings.iter().filter(|s| matches!(s.axis, Default | Resolution | Cover | Overlap)).collect();
    plot(&some, ["bytes of the scene", "RMSE of 64 samples against the mesh"], |s| {
        [report.voxels[s.voxels].bytes as f64, s.voxels_error.rmse]
    })
}

const TIME: &str = "render time, ms";

/// The page.
pub fn page(report: &Report, crops: &[Crop], whole: &Whole) -> Result<String> {
    let title = format!("What accuracy costs: {}", report.scene);
    let flip = report.settings.iter().all(|s| s.error.flip.is_some());
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                p.lead {
                    (grouped(report.triangles as u64)) " triangles, " (report.size[0]) " x " (report.size[1]) " pixels, "
                    (report.settings.len()) " settings, each drawn " (report.repeat[0]) " times in turn. The truth is "
                    (report.truth) ", 64 samples a pixel, with the same camera, lights and reflection model."
                }
                (picks(report, crops))
                p {
                    "The flags are those of " code { "voxdag render" } ". An RMSE of 0.01 is one step in a hundred of linear light, on average \
                     over the picture; FLIP is 0 where nobody sees a difference and 1 where nobody could miss it."
                }
                section {
                    h2 { "Error over time" }
                    figure {
                        (PreEscaped(front_plot(report)?))
                        figcaption {
                            "Each point is a setting: left is faster, lower is nearer to the mesh. The line is the front: \
                             nothing on it is beaten by something faster. Building and " i { "preparing" } " a scene once is not in \
                             these times; the tables have both."
                        }
                    }
                    @if flip {
                        details {
                            summary { "The same by what people see (FLIP)" }
                            figure {
                                (PreEscaped(flip_plot(report)?))
                                figcaption { "FLIP (Andersson et al. 2020) weighs differences as people see them when two pictures alternate." }
                            }
                        }
                    }
                    figure {
                        (PreEscaped(sampling_plot(report)?))
                        figcaption { "Sampling alone: the same voxels and normals, against 64 samples of them. What is equal to them is not shown." }
                    }
                    figure {
                        (PreEscaped(voxels_plot(report)?))
                        figcaption { "Voxels alone: 64 samples of them against the mesh, by the bytes that they take." }
                    }
                }
                (pictures(crops, whole))
                (tables(report))
                (wrong(report))
                (advice(report))
                section {
                    h2 { "How this was made" }
                    pre { code { (report.command) } }
                    p { (report.machine.text()) ". Times are wall-clock medians of " (report.repeat[0]) " repetitions in which all settings took turns; \
                        building was repeated " (report.repeat[1]) " times in the same manner. The truth took " (time(report.truth_ms)) "." }
                    p { "The view: " code { "render " (report.view) } "." }
                    p {
                        "RMSE and PSNR are over red, green and blue in linear light, SSIM is over sRGB, all from 8 bits a channel. The silhouette \
                         error counts pixels whose middle hits in one and misses in the other; depth (in voxels of the setting, at its level of detail) and normals (in degrees) are \
                         compared where both hit, through the middles of pixels."
                    }
                }
            }
        }
    };
    Ok(page.into_string())
}

/// Three settings to choose from.
fn picks(report: &Report, crops: &[Crop]) -> Markup {
    let front = &report.recommendation.front;
    let ends = [front.first(), Some(&report.recommendation.knee), front.last()].map(|i| i.copied().unwrap_or(0));
    let names = ["The fastest", "Worth its time", "The most accurate"];
    html! {
        section.picks {
            @for (i, (&setting, name)) in ends.iter().zip(names).enumerate() {
                @let s = &report.settings[setting];
                article.best[i == 1] {
                    h2 { (name) }
                    @if let Some(crop) = crops.iter().find(|crop| crop.setting == Some(setting)) {
                        img src=(crop.picture) alt=(s.label);
                    }
                    p.number { (time(s.render_ms.median)) " " small { "RMSE " (error(s.error.rmse)) @if let Some(flip) = s.error.flip { ", FLIP " (format!("{flip:.3}")) } } }
                    p { code { (unbroken(&s.flags)) } }
                }
            }
        }
    }
}

/// Flags, of which none is broken across lines.
fn unbroken(flags: &str) -> Markup {
    html! {
        @for (i, flag) in flags.split(" --").enumerate() {
            @if i > 0 { " " span { "--" (flag) } } @else { span { (flag) } }
        }
    }
}

/// Details of pictures beside each other.
fn pictures(crops: &[Crop], whole: &Whole) -> Markup {
    let [left, top, width, height] = whole.frame.map(|part| format!("{:.2}%", 100.0 * part));
    html! {
        section {
            h2 { "Side by side" }
            p { "The part of the picture where the default errs most, enlarged; below each what FLIP says of it, the brighter the more visible." }
            div.whole {
                img src=(whole.picture) alt="The whole picture of the truth";
                span style=(format!("left:{left};top:{top};width:{width};height:{height}")) {}
            }
            div.crops {
                @for crop in crops {
                    figure {
                        img src=(crop.picture) alt=(crop.label);
                        @if let Some(map) = &crop.map { img src=(map) alt=(format!("Error map of {}", crop.label)); }
                        figcaption { b { (crop.label) } br; (crop.note) }
                    }
                }
            }
        }
    }
}

/// A table for each axis, and one of the voxels.
fn tables(report: &Report) -> Markup {
    html! {
        section {
            h2 { "Tables" }
            @for (axis, name) in AXES {
                @let rows: Vec<_> = report.settings.iter().filter(|s| s.axis == axis).collect();
                @if !rows.is_empty() {
                    details open[axis != Axis::Combined] {
                        summary { (name) }
                        div.scroll { table {
                            thead { tr {
                                th { "setting" } th { "render ms" } th { "fastest to slowest" } th { "rays" }
                                th { "RMSE" } th { "PSNR dB" } th { "SSIM" } th { "FLIP" }
                                th { "RMSE of voxels alone" } th { "RMSE of sampling alone" }
                                th { "silhouette px" } th { "depth, its own voxels: median, mean, 95 %, max" } th { "normal, degrees: median, mean, 95 %, max" }
                            } }
                            tbody {
                                @for s in std::iter::once(report.usual()).filter(|_| axis != Axis::Default).chain(rows) { (row(s)) }
                            }
                        } }
                    }
                }
            }
            h3 { "Voxels" }
            div.scroll { table {
                thead { tr {
                    th { "voxels along the longest axis" } th { "cover" } th { "overlap" } th { "normals kept" } th { "voxels" } th { "bytes" }
                    th { "bits a voxel" } th { "build ms" } th { "memory to build" }
                } }
                tbody { @for v in &report.voxels { (voxels(v)) } }
            } }
        }
    }
}

fn row(s: &Measured) -> Markup {
    let shape = &s.shape;
    html! {
        tr.front[s.on_front] {
            th title=(s.flags) { (s.label) }
            td { (decimals(s.render_ms.median)) } td { (decimals(s.render_ms.min)) " to " (decimals(s.render_ms.max)) } td { (grouped(s.rays.total())) }
            td { (error(s.error.rmse)) } td { (s.error.psnr.map_or("equal".to_owned(), |x| format!("{x:.2}"))) }
            td { (format!("{:.4}", s.error.ssim)) } td { (s.error.flip.map_or("-".to_owned(), |x| format!("{x:.4}"))) }
            td { (error(s.voxels_error.rmse)) } td { (error(s.sampling_rmse)) }
            td { (grouped(shape.silhouette)) }
            td { (deviations(shape.depth)) }
            td { (deviations(shape.normal)) }
        }
    }
}

fn deviations(of: Option<Deviations>) -> String {
    let text = |Deviations { median, mean, p95, max }| format!("{median:.2}, {mean:.2}, {p95:.2}, {max:.1}");
    of.map_or("-".to_owned(), text)
}

fn voxels(v: &Voxels) -> Markup {
    html! {
        tr {
            th { (v.resolution) } td { (v.cover) } td { (name_of(v.overlap)) }
            td { @if v.stored_normals { "yes" } @else { "no" } }
            td { (grouped(v.voxels)) } td { (grouped(v.bytes)) } td { (format!("{:.2}", v.bits_per_voxel)) }
            td { (decimals(v.build_ms.median)) } td { (v.build_peak_bytes.map_or("-".to_owned(), size)) }
        }
    }
}

/// What rounding gets wrong.
fn wrong(report: &Report) -> Markup {
    html! {
        section {
            h2 { "Wrong voxels" }
            p { "At the default's resolution: triangles to voxels without materials, and four rays a pixel without shading. Exact methods are judged \
                 by integer arithmetic of any length on a part of the work, the others by the exact ones on all of it." }
            div.scroll { table {
                thead { tr { th { "method" } th { "ms" } th { "missing" } th { "wrong or too many" } th { "compared" } th { "judged by" } } }
                tbody {
                    @for w in &report.wrong {
                        tr {
                            th { (w.method) } td { (decimals(w.ms)) }
                            td.bad[w.missing > 0] { (grouped(w.missing)) } td.bad[w.extra > 0] { (grouped(w.extra)) }
                            td { (grouped(w.compared)) } td { (w.against) }
                        }
                    }
                }
            } }
        }
    }
}

/// The front as sentences.
fn advice(report: &Report) -> Markup {
    html! {
        section {
            h2 { "What to use" }
            ol.advice {
                @for step in report.advice() {
                    li.best[std::ptr::eq(step.setting, report.knee())] {
                        "For an error below " b { (error(step.below)) } " use " code { (step.setting.flags) } ": " (time(step.setting.render_ms.median)) ". "
                        @match step.next {
                            Some((more, less)) => { "The next step costs " (time(more)) " more and takes " (format!("{:.0} %", 100.0 * less)) " of the error away." }
                            None => { "Nothing that was measured is more accurate." }
                        }
                    }
                }
            }
        }
    }
}

/// A plot of an error over what settings cost, and its front.
fn plot(settings: &[&Measured], [x, y]: [&str; 2], value: impl Fn(&Measured) -> [f64; 2]) -> Result<String> {
    // Logarithms have no place for 0.
    let settings: Vec<_> = settings.iter().copied().filter(|s| value(s).iter().all(|x| *x > 0.0)).collect();
    let used: Vec<_> = AXES.iter().filter(|(axis, _)| settings.iter().any(|s| s.axis == *axis)).collect();
    let point = |s: &&Measured| {
        let [cost, error] = value(s);
        Point { cost, error }
    };
    let points: Vec<_> = settings.iter().map(point).collect();
    let front = front::front(&points);
    let marks = settings.iter().zip(&points).enumerate().map(|(i, (s, point))| Mark {
        x: point.cost,
        y: point.error,
        label: &s.label,
        color: AXES.iter().position(|(axis, _)| s.axis == *axis).unwrap_or(0),
        rank: if s.axis == Axis::Default { 2 } else { u8::from(front.contains(&i)) },
    });
    let legend = used.iter().map(|&&(axis, name)| (name, AXES.iter().position(|a| a.0 == axis).unwrap_or(0)));
    let line = front.iter().map(|&i| (points[i].cost, points[i].error)).collect();
    Plot { x, y, legend: legend.collect(), marks: marks.collect(), front: line }.svg()
}

fn error(x: f64) -> String {
    format!("{x:.5}")
}

fn decimals(x: f64) -> String {
    if x < 100.0 { format!("{x:.1}") } else { format!("{x:.0}") }
}
