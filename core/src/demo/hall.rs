//! What stands where: three aisles of four bays, an apse behind the middle one, an open front.

use alloc::string::String;
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};

use super::shape::{Point, Writer, arc, sin_cos};
use crate::math::add_scaled;

/// Side of a bay.
const BAY: f64 = 4.0;
/// Height at which arches and vaults spring.
const SPRING: f64 = 3.4;
/// Height of the vaults' crown.
const CROWN: f64 = SPRING + BAY / 2.0;
/// Half the width of the three aisles, and half their length.
const HALF: [f64; 2] = [1.5 * BAY, 2.0 * BAY];
/// Thickness of the walls down to the glass.
const REVEAL: f64 = 0.5;
/// Radius of the apse.
const APSE: f64 = 1.5;

/// Centres of the bays across and along.
const ACROSS: [f64; 3] = [-BAY, 0.0, BAY];
const ALONG: [f64; 4] = [-1.5 * BAY, -0.5 * BAY, 0.5 * BAY, 1.5 * BAY];

/// The whole scene.
pub fn build() -> String {
    let mut w = Writer::new(super::MTL_NAME);
    floor(&mut w);
    vaults(&mut w);
    arches(&mut w);
    columns(&mut w);
    walls(&mut w);
    apse(&mut w);
    shell(&mut w);
    sculpture(&mut w);
    lamp(&mut w);
    banners(&mut w);
    furniture(&mut w);
    w.finish()
}

fn floor(w: &mut Writer) {
    w.object("floor");
    let [x, z] = HALF;
    let paint = |j: usize, i: usize| match (i % 10, (j + 5) % 10) {
        (0 | 9, _) | (_, 0 | 9) if (1..29).contains(&i) => "tile-border",
        _ if (i + j).is_multiple_of(2) => "tile-dark",
        _ => "tile-light",
    };
    w.sheet([40, 30], paint, |s, t| [x * (2.0 * t - 1.0), 0.0, z * (2.0 * s - 1.0)]);
}

/// Groin vaults: of two crossing barrels the higher, in four webs a bay, and ribs along the groins.
fn vaults(w: &mut Writer) {
    w.object("vaults");
    let half = BAY / 2.0;
    for (x, z) in ACROSS.into_iter().flat_map(|x| ALONG.map(|z| (x, z))) {
        for quarter in 0..4 {
            w.sheet(
                [14, 4],
                |_, _| "vault",
                |s, t| {
                    let (sin, cos) = sin_cos((s - 0.5) * PI);
                    let (u, v) = (half * sin, half * (sin.abs() + (1.0 - sin.abs()) * t));
                    let [a, b] = [[u, v], [v, -u], [-u, -v], [-v, u]][quarter];
                    [x + a, SPRING + half * cos, z + b]
                },
            );
        }
        for side in [-1.0, 1.0] {
            w.tube("gold", [16, 6], [x, SPRING, z], 0.08, |s| {
                let (sin, cos) = sin_cos((s - 0.5) * PI);
                [x + half * sin, SPRING + half * cos, z + side * half * sin]
            });
        }
    }
}

/// Round arches between the bays, of wedges in two colours, with chamfered edges.
fn arches(w: &mut Writer) {
    w.object("arches");
    let (inner, outer, wide, bevel) = (BAY / 2.0 - 0.26, BAY / 2.0 + 0.02, 0.22, 0.05);
    let section = [
        [-wide, outer],
        [-wide, inner + bevel],
        [bevel - wide, inner],
        [wide - bevel, inner],
        [wide, inner + bevel],
        [wide, outer],
    ];
    let wedge = |i: usize, _| if (i / 2).is_multiple_of(2) { "brick" } else { "limestone" };
    let mut arch = |place: &dyn Fn(f64, f64, f64) -> Point| {
        w.sheet([26, 5], wedge, |s, t| {
            let [across, r] = section[libm::rint(t * 5.0) as usize];
            let (sin, cos) = sin_cos((s - 0.5) * PI);
            place(r * sin, r * cos, across)
        });
    };
    for x in ACROSS {
        for k in 0..5 {
            let z = BAY * (f64::from(k) - 2.0);
            arch(&|a, b, c| [x + a, SPRING + b, z + c]);
        }
    }
    for z in ALONG {
        for k in 0..4 {
            let x = BAY * (f64::from(k) - 1.5);
            arch(&|a, b, c| [x + c, SPRING + b, z - a]);
        }
    }
}

fn columns(w: &mut Writer) {
    w.object("columns");
    // From the base's lower roll over the swelling shaft to the bell of the capital.
    let mut profile: Vec<[f64; 2]> = arc([0.29, 0.25], 0.09, -90.0, 90.0, 5).collect();
    profile.extend(arc([0.30, 0.40], 0.06, 270.0, 150.0, 2).skip(1));
    profile.extend(arc([0.245, 0.47], 0.05, -60.0, 90.0, 3));
    profile.extend((0..=4).map(|i| {
        let t = f64::from(i) / 4.0;
        [0.235 - 0.035 * t * t, 0.53 + 2.2 * t]
    }));
    profile.extend(arc([0.20, 2.77], 0.045, -90.0, 90.0, 4));
    profile.extend(arc([0.36, 2.85], 0.15, 180.0, 100.0, 4).map(|[r, y]| [r, 2.85 + (y - 2.85) * 2.0]));
    profile.extend([[0.37, 3.16], [0.37, 3.2]]);
    for k in 0..5 {
        let z = BAY * (f64::from(k) - 2.0);
        for side in [-1.0, 1.0] {
            let x = side * BAY / 2.0;
            let shaft = if k % 2 == 0 { "porphyry" } else { "marble" };
            w.block("sandstone", [x - 0.4, 0.0, z - 0.4], [x + 0.4, 0.16, z + 0.4]);
            w.lathe(shaft, [x, 0.0, z], 18, &profile);
            w.block("sandstone", [x - 0.4, 3.2, z - 0.4], [x + 0.4, SPRING, z + 0.4]);

            // Against the side wall a flat pilaster answers the column.
            let (near, far) = (side * (HALF[0] - 0.25), side * HALF[0]);
            let (left, right) = (near.min(far), near.max(far));
            w.block("sandstone", [left, 0.0, z - 0.25], [right, 3.2, z + 0.25]);
            w.block("sandstone", [left - 0.08, 3.2, z - 0.33], [right + 0.08, SPRING, z + 0.33]);
        }
    }
}

/// Where a wall stands: a point at its foot, the direction to its right seen from inside, and the way out.
#[derive(Clone, Copy)]
struct Wall {
    foot: Point,
    right: Point,
    out: Point,
}

impl Wall {
    /// The point `a` to the right, `b` up and `d` into the wall.
    fn at(&self, a: f64, b: f64, d: f64) -> Point {
        let [x, y, z] = add_scaled(add_scaled(self.foot, self.right, a), self.out, d);
        [x, y + b, z]
    }
}

/// A round-headed opening in a wall, from `sill` up.
#[derive(Clone, Copy)]
struct Opening {
    radius: f64,
    sill: f64,
    spring: f64,
}

impl Opening {
    /// One bay of wall around the opening, with the opening's sides `deep` into the wall.
    fn cut(self, w: &mut Writer, wall: Wall, deep: f64) {
        let Opening { radius, sill, spring } = self;
        let half = BAY / 2.0;
        let mut rectangle = |material, a: [f64; 2], b: [f64; 2]| {
            w.polygon(material, &[(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| wall.at(a[i], b[j], 0.0)));
        };
        rectangle("plaster", [-half, -radius], [sill, CROWN]);
        rectangle("plaster", [radius, half], [sill, CROWN]);
        if sill > 0.0 {
            rectangle("serpentine", [-half, half], [0.0, sill]);
        }
        w.sheet(
            [24, 1],
            |_, _| "plaster",
            |s, t| {
                let (sin, cos) = sin_cos((s - 0.5) * PI);
                let low = spring + radius * cos;
                wall.at(radius * sin, low + (CROWN - low) * t, 0.0)
            },
        );
        let outline: Vec<[f64; 2]> = [[-radius, sill]]
            .into_iter()
            .chain(arc([0.0, spring], radius, 180.0, 0.0, 24))
            .chain([[radius, sill], [-radius, sill]])
            .collect();
        let last = outline.len() - 1;
        w.sheet(
            [last, 1],
            |_, _| "limestone",
            |s, t| {
                let [a, b] = outline[libm::rint(s * last as f64) as usize];
                wall.at(a, b, deep * (1.0 - t))
            },
        );
    }

    /// Coloured panes between leads, `deep` into the wall.
    fn glaze(self, w: &mut Writer, wall: Wall, deep: f64) {
        let Opening { radius, sill, spring } = self;
        // Along each direction a lead, a pane, a lead, ...: odd cells are panes.
        let along = |s: f64, cells: usize| {
            let (k, panes) = (libm::rint(s * cells as f64) as usize, (cells / 2) as f64);
            let lead = 0.16 / panes;
            ((k / 2) as f64 / panes) * (1.0 - lead) + if k % 2 == 1 { lead } else { 0.0 }
        };
        let pane = |i: usize, j: usize| match (i / 2, j / 2) {
            _ if i.is_multiple_of(2) || j.is_multiple_of(2) => "lead",
            (2 | 3, 3 | 4) => "glass-red",
            (a, b) if (a + b) % 3 == 0 => "glass-amber",
            _ => "glass-blue",
        };
        w.sheet([13, 17], pane, |s, t| {
            let a = radius * (2.0 * along(s, 13) - 1.0);
            let top = spring + crate::math::sqrt((radius * radius - a * a).max(0.0));
            wall.at(a, sill + (top - sill) * along(t, 17), deep)
        });
    }
}

fn walls(w: &mut Writer) {
    w.object("walls");
    let window = Opening { radius: 0.75, sill: 1.2, spring: 2.9 };
    for z in ALONG {
        for side in [-1.0, 1.0] {
            let wall = Wall { foot: [side * HALF[0], 0.0, z], right: [0.0, 0.0, side], out: [side, 0.0, 0.0] };
            window.cut(w, wall, REVEAL);
            window.glaze(w, wall, REVEAL);
        }
    }
    for x in [ACROSS[0], ACROSS[2]] {
        let wall = Wall { foot: [x, 0.0, -HALF[1]], right: [1.0, 0.0, 0.0], out: [0.0, 0.0, -1.0] };
        window.cut(w, wall, REVEAL);
        window.glaze(w, wall, REVEAL);
    }
}

/// A half cylinder with three windows under a gilded half dome.
fn apse(w: &mut Writer) {
    w.object("apse");
    let wall = Wall { foot: [0.0, 0.0, -HALF[1]], right: [1.0, 0.0, 0.0], out: [0.0, 0.0, -1.0] };
    Opening { radius: APSE, sill: 0.0, spring: SPRING - 0.2 }.cut(w, wall, REVEAL);
    let height = SPRING - 0.2;
    let on_circle = |s: f64, r: f64| {
        let (sin, cos) = sin_cos((s - 0.5) * PI);
        [r * sin, REVEAL + r * cos]
    };

    // Three windows of 20 columns of cells each, with a lead along their outline and a gilded frame.
    let [columns, rows] = [60, 32];
    let paint = |i: usize, j: usize| {
        let (a, b) = (0.8 * ((i as f64 + 0.5) % 20.0 - 10.0), j as f64 + 0.5);
        let within = |r: f64| a.abs() < r && b > 14.5 - r && (b < 24.0 || a * a + (b - 24.0) * (b - 24.0) < r * r);
        match () {
            () if within(4.0) && j % 4 == 2 => "lead",
            () if within(4.0) => ["glass-blue", "glass-amber", "glass-blue", "glass-red"][(j / 4 + i / 10) % 4],
            () if within(4.8) => "lead",
            () if within(5.8) => "gold",
            () if j < 6 || j == 31 => "brick",
            () => "plaster",
        }
    };
    w.sheet([columns, rows], paint, |s, t| {
        let [a, d] = on_circle(s, APSE);
        wall.at(a, height * t, d)
    });
    w.sheet(
        [28, 12],
        |_, _| "gold",
        |s, t| {
            let (sin, cos) = sin_cos(t * PI / 2.0);
            let [a, d] = on_circle(s, APSE * cos);
            wall.at(a, height + APSE * sin, d)
        },
    );
    let ground: Vec<Point> =
        (0..=32).map(|i| on_circle(f64::from(i) / 32.0, APSE)).map(|[a, d]| wall.at(a, 0.0, d)).collect();
    w.polygon("tile-border", &ground);
}

/// The building's outside: walls, roof, and the cut at the front.
fn shell(w: &mut Writer) {
    w.object("shell");
    let (side, back, roof) = (HALF[0] + REVEAL + 0.4, -HALF[1] - REVEAL - APSE - 0.4, CROWN + 0.4);
    let front = HALF[1];
    let (a, b) = ([-side, 0.0, back], [side, roof, front]);
    w.polygon("limestone", &[[a[0], 0.0, a[2]], [a[0], 0.0, b[2]], [a[0], roof, b[2]], [a[0], roof, a[2]]]);
    w.polygon("limestone", &[[b[0], 0.0, b[2]], [b[0], 0.0, a[2]], [b[0], roof, a[2]], [b[0], roof, b[2]]]);
    w.polygon("limestone", &[[b[0], 0.0, a[2]], [a[0], 0.0, a[2]], [a[0], roof, a[2]], [b[0], roof, a[2]]]);
    w.polygon("brick", &[[a[0], roof, b[2]], [b[0], roof, b[2]], [b[0], roof, a[2]], [a[0], roof, a[2]]]);
    // The cut: one polygon with three arched bays taken out of it.
    let mut cut: Vec<Point> = [[b[0], 0.0, front], [b[0], roof, front], [a[0], roof, front], [a[0], 0.0, front]].into();
    cut.push([-HALF[0], 0.0, front]);
    for x in ACROSS {
        cut.extend(arc([x, SPRING], BAY / 2.0, 180.0, 0.0, 24).map(|[x, y]| [x, y, front]));
    }
    cut.push([HALF[0], 0.0, front]);
    cut.dedup();
    w.polygon("sandstone", &cut);
}

/// A knot of bronze on a stepped pedestal: five times through a ring that is passed twice.
fn sculpture(w: &mut Writer) {
    w.object("sculpture");
    let foot = [0.0, 0.0, -1.0];
    w.lathe("sandstone", foot, 32, &[[1.25, 0.0], [1.25, 0.16], [0.95, 0.16], [0.95, 0.32], [0.0, 0.32]]);
    let mut profile: Vec<[f64; 2]> = [[0.62, 0.32], [0.62, 0.42]].into();
    profile.extend(arc([0.60, 0.50], 0.10, 180.0, 90.0, 4).map(|[r, y]| [r - 0.02, y - 0.08]));
    profile.extend([[0.48, 1.0], [0.58, 1.06], [0.58, 1.16], [0.0, 1.16]]);
    w.lathe("marble", foot, 8, &profile);
    let centre = [foot[0], 2.29, foot[2]];
    w.tube("bronze", [180, 12], centre, 0.13, |s| {
        let (sin2, cos2) = sin_cos((2.0 * s + 0.25) * TAU);
        let (sin5, cos5) = sin_cos(5.0 * s * TAU);
        let (r, deep) = (0.70 + 0.30 * cos5, 0.34 * sin5);
        // Turned by 30 degrees around the vertical, so that it is not seen flat.
        let x = r * cos2;
        [centre[0] + 0.866 * x + 0.5 * deep, centre[1] + r * sin2, centre[2] + 0.866 * deep - 0.5 * x]
    });
}

/// A ring of lights over the nave.
fn lamp(w: &mut Writer) {
    w.object("lamp");
    let centre = [0.0, 3.55, 2.0];
    w.tube("gold", [48, 10], centre, 0.07, |s| {
        let (sin, cos) = sin_cos(s * TAU);
        [centre[0] + 0.75 * cos, centre[1], centre[2] + 0.75 * sin]
    });
    w.lathe("gold", centre, 10, &[[0.05, 0.9], [0.05, CROWN - centre[1]]]);
    w.ball("gold", [centre[0], centre[1] + 0.9, centre[2]], 0.12, 14);
    for k in 0..8 {
        let (sin, cos) = sin_cos((f64::from(k) + 0.5) * TAU / 8.0);
        let (x, z) = (centre[0] + 0.75 * cos, centre[2] + 0.75 * sin);
        w.ball("lamp", [x, centre[1] + 0.17, z], 0.12, 12);
        if k % 2 == 0 {
            w.tube("gold", [4, 8], [x, 9.0, z + 9.0], 0.04, |s| {
                let height = centre[1] + 0.9 * (1.0 - s);
                [centre[0] + 0.75 * cos * s, height, centre[2] + 0.75 * sin * s]
            });
        }
    }
}

/// Cloth with a ring in its middle, hanging from rods across the side aisles.
fn banners(w: &mut Writer) {
    w.object("banners");
    for (k, z) in [4.0, 0.0, -4.0].into_iter().enumerate() {
        for side in [-1.0, 1.0] {
            let (x, top, half) = (side * BAY, 4.55, 0.62);
            let colour = if (k % 2 == 0) == (side < 0.0) { "crimson" } else { "indigo" };
            let cloth = |a: f64, t: f64| {
                let tail = 0.3 * (1.0 - a.abs());
                let wave = 0.06 * (0.25 + 0.75 * t) * libm::sin(4.5 * a + 1.5 * t + x);
                [x + half * a, top - t * (1.75 - tail), z + wave]
            };
            // Rings around the middle: a disc, a gap, a ring, and squares out to the hem and the edge.
            let rings = [0.0, 0.13, 0.27, 0.41, 0.76, 0.86, 1.0];
            let paint = |_, j: usize| if [0, 2, 4].contains(&j) { "gold" } else { colour };
            w.sheet([32, 6], paint, |s, t| {
                let (sin, cos) = sin_cos(s * TAU);
                let j = libm::rint(t * 6.0) as usize;
                let r = if j < 4 { rings[j] } else { rings[j] / sin.abs().max(cos.abs()) };
                cloth(r * cos, 0.5 - 0.5 * r * sin)
            });
            w.tube("bronze", [1, 10], [x, top + 9.0, z], 0.05, |s| [x + 1.5 * s - 0.75, top + 0.03, z]);
            w.ball("gold", [x - 0.75, top + 0.03, z], 0.09, 12);
            w.ball("gold", [x + 0.75, top + 0.03, z], 0.09, 12);
        }
    }
}

/// Glazed balls on plinths, and benches with cushions along the walls.
fn furniture(w: &mut Writer) {
    w.object("furniture");
    for (x, z, ball) in [(-3.7, 2.0, "glaze"), (3.7, 2.2, "marble"), (-3.7, -2.2, "gold")] {
        w.block("sandstone", [x - 0.42, 0.0, z - 0.42], [x + 0.42, 0.14, z + 0.42]);
        w.block("limestone", [x - 0.32, 0.14, z - 0.32], [x + 0.32, 0.8, z + 0.32]);
        w.block("sandstone", [x - 0.38, 0.8, z - 0.38], [x + 0.38, 0.92, z + 0.38]);
        w.ball(ball, [x, 1.36, z], 0.46, 30);
    }
    for z in ALONG {
        for side in [-1.0, 1.0] {
            let x = side * (HALF[0] - 0.4);
            w.block("sandstone", [x - 0.4, 0.0, z - 1.4], [x + 0.4, 0.45, z + 1.4]);
            for (k, dz) in [-0.9, 0.0, 0.9].into_iter().enumerate() {
                let cloth = ["crimson", "gold", "indigo"][k];
                cushion(w, cloth, [x, 0.58, z + dz]);
            }
        }
    }
}

/// A pillow: a sphere with its sides pressed towards a box.
fn cushion(w: &mut Writer, material: &'static str, centre: Point) {
    let root = |x: f64| if x < 0.0 { -crate::math::sqrt(-x) } else { crate::math::sqrt(x) };
    w.sheet(
        [6, 14],
        |_, _| material,
        |s, t| {
            let (rise, level) = sin_cos((s - 0.5) * PI);
            let (sin, cos) = sin_cos(t * TAU);
            [centre[0] + 0.34 * level * root(cos), centre[1] + 0.15 * rise, centre[2] + 0.34 * level * root(sin)]
        },
    );
}
