//! Plots of error over cost, both scales logarithmic, as SVG: points by axis, as many with labels as there is room for, and
//! the front.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::error::{Error, Kind, Result};

/// A point, and what it is called.
pub struct Mark<'a> {
    pub x: f64,
    pub y: f64,
    pub label: &'a str,
    /// The place of its colour.
    pub color: usize,
    /// Points of higher rank get their labels first, and are drawn larger.
    pub rank: u8,
}

/// What is plotted.
pub struct Plot<'a> {
    pub x: &'a str,
    pub y: &'a str,
    /// What colours stand for: a name, and the place of its colour.
    pub legend: Vec<(&'a str, usize)>,
    pub marks: Vec<Mark<'a>>,
    /// A line through points, from left to right.
    pub front: Vec<(f64, f64)>,
}

const WIDTH: u32 = 960;
const HEIGHT: u32 = 540;
/// Colours that also differ for the colour-blind (Okabe and Ito 2008), grey and brown.
const COLORS: [RGBColor; 9] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(128, 128, 128),
    RGBColor(136, 78, 32),
];
const FONT: i32 = 13;
/// Of a letter, on average, as no font is asked.
const LETTER: f64 = 6.6;

impl Plot<'_> {
    /// The picture.
    pub fn svg(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw(&SVGBackend::with_string(&mut svg, (WIDTH, HEIGHT)).into_drawing_area())
            .map_err(|error| Error::new(Kind::Failure, error))?;
        // As wide as there is room.
        Ok(svg.replacen(&format!("width=\"{WIDTH}\" height=\"{HEIGHT}\""), "class=\"plot\" role=\"img\"", 1))
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        area.fill(&WHITE)?;
        let (x, y) = (range(self.marks.iter().map(|m| m.x)), range(self.marks.iter().map(|m| m.y)));
        let mut chart =
            ChartBuilder::on(area).margin(12).x_label_area_size(46).y_label_area_size(70).build_cartesian_2d(
                x.clone().log_scale().with_key_points(ticks(&x)),
                y.clone().log_scale().with_key_points(ticks(&y)),
            )?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .label_style(("sans-serif", FONT))
            .axis_desc_style(("sans-serif", FONT + 1))
            .light_line_style(BLACK.mix(0.04))
            .bold_line_style(BLACK.mix(0.12))
            .x_label_formatter(&|x| short(*x))
            .y_label_formatter(&|y| short(*y))
            .draw()?;
        chart.draw_series(LineSeries::new(self.front.iter().copied(), BLACK.mix(0.55).stroke_width(2)))?;
        for &(name, place) in &self.legend {
            let color = COLORS[place % COLORS.len()];
            let points = self.marks.iter().filter(|m| m.color == place);
            chart
                .draw_series(points.map(|m| Circle::new((m.x, m.y), if m.rank > 0 { 6 } else { 4 }, color.filled())))?
                .label(name)
                .legend(move |(x, y)| Circle::new((x + 8, y), 5, color.filled()));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.2))
            .label_font(("sans-serif", FONT))
            .draw()?;

        // Labels, those of the highest rank first, each in the first place where it covers nothing.
        let at = |m: &Mark<'_>| chart.backend_coord(&(m.x, m.y));
        let mut taken: Vec<[f64; 4]> = self.marks.iter().map(|m| around(at(m), 4.0)).collect();
        let ([left, right], [top, bottom]) = {
            let (x, y) = chart.plotting_area().get_pixel_range();
            ([x.start, x.end].map(f64::from), [y.start, y.end].map(f64::from))
        };
        // The legend's corner.
        let legend = 24.0 + LETTER * self.legend.iter().map(|s| s.0.chars().count()).max().unwrap_or(0) as f64;
        taken.push([right - legend - 20.0, top, right, top + 24.0 + 20.0 * self.legend.len() as f64]);
        let mut order: Vec<_> = self.marks.iter().collect();
        order.sort_by_key(|m| std::cmp::Reverse(m.rank));
        for mark in order {
            let ((x, y), width) = (at(mark), LETTER * mark.label.chars().count() as f64);
            let (x, y) = (f64::from(x), f64::from(y));
            let places = [
                (x + 8.0, y, HPos::Left),
                (x - 8.0, y, HPos::Right),
                (x, y - 14.0, HPos::Center),
                (x, y + 14.0, HPos::Center),
                (x + 8.0, y - 12.0, HPos::Left),
                (x + 8.0, y + 12.0, HPos::Left),
                (x - 8.0, y - 12.0, HPos::Right),
                (x - 8.0, y + 12.0, HPos::Right),
                // Farther away, for what must not go without.
                (x, y + 26.0, HPos::Center),
                (x, y - 26.0, HPos::Center),
                (x, y + 38.0, HPos::Center),
            ];
            let allowed = if mark.rank > 0 { places.len() } else { 8 };
            for (x, y, anchor) in places.into_iter().take(allowed) {
                let from = match anchor {
                    HPos::Left => x,
                    HPos::Right => x - width,
                    HPos::Center => x - width / 2.0,
                };
                let rectangle = [from, y - 7.0, from + width, y + 7.0];
                let inside = from > left && from + width < right && y - 7.0 > top && y + 7.0 < bottom;
                if inside && !taken.iter().any(|other| overlap(&rectangle, other)) {
                    let style = ("sans-serif", FONT)
                        .into_text_style(area)
                        .color(&COLORS[mark.color % COLORS.len()])
                        .pos(Pos::new(anchor, VPos::Center));
                    area.draw(&Text::new(mark.label.to_owned(), (x as i32, y as i32), style))?;
                    taken.push(rectangle);
                    break;
                }
            }
        }
        area.present()
    }
}

/// A rectangle around a point: left, top, right, bottom.
fn around((x, y): (i32, i32), radius: f64) -> [f64; 4] {
    let (x, y) = (f64::from(x), f64::from(y));
    [x - radius, y - radius, x + radius, y + radius]
}

fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    (0..2).all(|i| a[i] < b[i + 2] && b[i] < a[i + 2])
}

/// From below the smallest to above the largest of some numbers above 0.
fn range(numbers: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (min, max) = numbers.fold((f64::INFINITY, 0.0), |(min, max), x| (x.min(min), x.max(max)));
    if min.is_finite() && max > 0.0 { 0.8 * min..1.25 * max } else { 0.1..1.0 }
}

/// Round numbers in a range, some ten of them at most: 1, 2, 5, 10 and so on, or more where that would be few.
fn ticks(range: &std::ops::Range<f64>) -> Vec<f64> {
    let decades = |steps: &[f64]| -> Vec<f64> {
        let powers = (-9..=12).map(|power| libm::exp10(f64::from(power)));
        powers.flat_map(|power| steps.iter().map(move |step| step * power)).filter(|x| range.contains(x)).collect()
    };
    let finer = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];
    let choices = [decades(&[1.0]), decades(&[1.0, 2.0, 5.0]), decades(&finer)];
    choices.into_iter().find(|ticks| ticks.len() >= 5).unwrap_or_else(|| decades(&finer))
}

/// A number with the digits that it needs.
fn short(x: f64) -> String {
    match x {
        ..0.001 => format!("{x:.5}"),
        ..0.01 => format!("{x:.4}"),
        ..0.1 => format!("{x:.3}"),
        ..1.0 => format!("{x:.2}"),
        ..10.0 => format!("{x:.1}"),
        ..1e4 => format!("{x:.0}"),
        ..1e6 => format!("{:.0} k", x / 1e3),
        _ => format!("{:.1} M", x / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_cover_each_other() {
        let mark = |x, y, label, rank| Mark { x, y, label, color: 0, rank };
        let (legend, front) = (vec![("one", 0)], vec![(1.0, 1.0), (9.0, 0.1)]);
        let plot = |marks| Plot { x: "ms", y: "RMSE", legend: legend.clone(), marks, front: front.clone() };
        let svg = plot(vec![mark(1.0, 1.0, "first", 1), mark(9.0, 0.1, "<last>", 0)]).svg().unwrap();
        assert!(svg.contains("first") && svg.contains("&lt;last&gt;") && !svg.contains("<last>"));
        // At one point there is room for as many labels as there are places.
        let svg = plot((0..20).map(|_| mark(1.0, 1.0, "crowd", 0)).collect()).svg().unwrap();
        assert!((1..=8).contains(&svg.matches("crowd").count()));
    }
}
