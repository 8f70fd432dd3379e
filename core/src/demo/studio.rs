//! A studio with what takes rays to draw: a mirror, a ball of glass, gold, panes of coloured glass, a polished floor.
//!
//! In: nothing. Out: as of the hall. Every effect is called for; lights cast shadows, coloured ones through the panes.

use alloc::string::String;
use core::f64::consts::TAU;

use super::DemoView;
use super::shape::{Point, Writer, arc, sin_cos};

/// The name under which [`obj`] asks for [`mtl`].
pub const MTL_NAME: &str = "voxdag-studio.mtl";

/// From the front, a little above the table's height.
pub const fn view() -> DemoView {
    DemoView {
        eye: [0.5, 2.0, 7.4],
        target: [0.22, 1.02, -0.6],
        up: [0.0, 1.0, 0.0],
        fov_y: 30.0,
        lights: &[
            // A spot from the left, before the things.
            ([-3.2, 5.2, 4.6], [0.52, 0.48, 0.42]),
            // Low sun from behind the panes, whose colours it throws on the floor.
            ([5.0, 3.6, -3.0], [0.5, 0.46, 0.38]),
            // The sky from the right.
            ([6.0, 6.5, 7.0], [0.12, 0.15, 0.2]),
        ],
        shadows: true,
        ambient: [0.13, 0.135, 0.15],
    }
}

/// The scene as Wavefront OBJ.
pub fn obj() -> String {
    let mut w = Writer::new(MTL_NAME);
    w.object("room");
    let tile = |i: usize, j: usize| if (i + j).is_multiple_of(2) { "tile-light" } else { "tile-dark" };
    w.sheet([12, 18], tile, |s, t| [9.0 * t - 3.8, 0.0, 6.0 * s - 3.2]);
    w.polygon("wall", &[[-3.8, 0.0, -3.2], [5.2, 0.0, -3.2], [5.2, 4.2, -3.2], [-3.8, 4.2, -3.2]]);
    w.polygon("terracotta", &[[-3.8, 0.0, 2.8], [-3.8, 0.0, -3.2], [-3.8, 4.2, -3.2], [-3.8, 4.2, 2.8]]);
    things(&mut w);
    screen(&mut w);
    w.finish()
}

fn things(w: &mut Writer) {
    w.object("mirror");
    w.ball("mirror", [-1.75, 1.2, -1.3], 1.2, 128);
    w.object("glass");
    plinth(w, [0.95, 0.0, 0.35], 0.62, 0.42);
    w.ball("glass", [0.95, 1.2, 0.35], 0.78, 128);
    w.object("gold");
    // A trefoil on a plinth.
    let centre = [-0.55, 0.62, 1.15];
    plinth(w, [-0.55, 0.0, 1.15], 0.36, 0.16);
    w.tube("gold", [240, 24], centre, 0.085, |s| {
        let ((s2, c2), (s3, c3)) = (sin_cos(2.0 * TAU * s), sin_cos(3.0 * TAU * s));
        let r = 0.26 + 0.12 * c3;
        [centre[0] + r * c2, centre[1] + r * s2, centre[2] + 0.12 * s3]
    });
    w.object("pearls");
    for (i, colour) in ["pearl-red", "pearl-white", "pearl-blue", "lamp"].into_iter().enumerate() {
        let (sin, cos) = sin_cos(0.42 + 0.34 * i as f64);
        w.ball(colour, [-0.5 + 2.5 * cos, 0.17, 0.2 + 2.1 * sin], 0.17, 48);
    }
}

/// A round plinth with a moulded edge.
fn plinth(w: &mut Writer, foot: Point, radius: f64, height: f64) {
    let edge = arc([radius - 0.05, height - 0.05], 0.05, 0.0, 90.0, 6);
    let profile: alloc::vec::Vec<_> = [[radius, 0.0]].into_iter().chain(edge).chain([[0.0, height]]).collect();
    w.lathe("marble", foot, 64, &profile);
}

/// A folding screen: panes of coloured glass in frames of wood.
fn screen(w: &mut Writer) {
    w.object("screen");
    let corners = [[1.3, -2.3], [2.05, -1.7], [2.8, -2.3], [3.55, -1.7]];
    for (i, glass) in ["glass-red", "glass-amber", "glass-blue"].into_iter().enumerate() {
        let ([x0, z0], [x1, z1]) = (corners[i], corners[i + 1]);
        let at = |s: f64, y: f64| [x0 + (x1 - x0) * s, y, z0 + (z1 - z0) * s];
        for (low, high) in [(0.12, 1.2), (1.26, 2.34)] {
            w.polygon(glass, &[at(0.06, low), at(0.94, low), at(0.94, high), at(0.06, high)]);
        }
        for y in [0.09, 1.23, 2.37] {
            bar(w, at(0.0, y), at(1.0, y));
        }
    }
    for [x, z] in corners {
        bar(w, [x, 0.0, z], [x, 2.42, z]);
    }
}

/// A bar of wood.
fn bar(w: &mut Writer, from: Point, to: Point) {
    // Beside the bar, so that it never runs towards it.
    let aside = [from[0], from[1] + 7.0, from[2] + 9.0];
    w.tube("wood", [1, 12], aside, 0.04, |s| core::array::from_fn(|i| from[i] + (to[i] - from[i]) * s));
}

/// The materials of [`obj`], colours encoded as sRGB like those of any authoring tool.
pub fn mtl() -> String {
    String::from(MATERIALS)
}

const MATERIALS: &str = "\
# voxdag studio

newmtl tile-light
Kd 0.80 0.78 0.73
Ks 0.20 0.20 0.20
Ns 200
illum 5

newmtl tile-dark
Kd 0.30 0.31 0.36
Ks 0.20 0.20 0.20
Ns 200
illum 5

newmtl wall
Kd 0.74 0.77 0.80
illum 1

newmtl terracotta
Kd 0.78 0.42 0.30
illum 1

newmtl wood
Kd 0.34 0.22 0.15
Ks 0.25 0.25 0.25
Ns 30
illum 2

newmtl marble
Kd 0.88 0.87 0.84
Ks 0.30 0.30 0.30
Ns 60
illum 2

newmtl mirror
Ka 0 0 0
Kd 0.03 0.03 0.03
Ks 0.95 0.95 0.95
Ns 400
illum 3

newmtl glass
Ka 0 0 0
Kd 0 0 0
Ks 0.22 0.22 0.22
Ns 400
d 0.02
Tf 0.97 1.00 0.99
Ni 1.5
illum 7

newmtl gold
Kd 0.55 0.38 0.14
Ks 0.92 0.76 0.42
Ns 80
illum 3

newmtl glass-red
Kd 0.27 0.04 0.03
Ks 0.30 0.30 0.30
Ns 200
d 0.20
Tf 1.00 0.22 0.18
illum 9

newmtl glass-amber
Kd 0.30 0.20 0.04
Ks 0.30 0.30 0.30
Ns 200
d 0.20
Tf 1.00 0.80 0.25
illum 9

newmtl glass-blue
Kd 0.04 0.10 0.29
Ks 0.30 0.30 0.30
Ns 200
d 0.20
Tf 0.25 0.55 1.00
illum 9

newmtl pearl-red
Kd 0.75 0.16 0.14
Ks 0.30 0.30 0.30
Ns 60
illum 5

newmtl pearl-white
Kd 0.92 0.90 0.86
Ks 0.30 0.30 0.30
Ns 60
illum 5

newmtl pearl-blue
Kd 0.18 0.30 0.68
Ks 0.30 0.30 0.30
Ns 60
illum 5

newmtl lamp
Kd 0.60 0.50 0.30
Ke 1.00 0.85 0.50
illum 1
";
