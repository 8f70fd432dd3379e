//! The demo's scenes. Here: a columned hall with groin vaults, an apse and a bronze knot, as the text of an OBJ and its MTL; the
//! other is the [`studio`].
//!
//! In: nothing. Out: two texts, read by the same importer as a user's files, and a view that suits the picture. Every
//! number is printed from an integer and every curve comes from `libm`, so the texts are the same on every target.
//! Units are metres, y is up, and the viewer looks along -z.

mod hall;
mod shape;
pub mod studio;

use alloc::string::String;
use core::fmt::Write as _;

/// The name under which [`obj`] asks for [`mtl`].
pub const MTL_NAME: &str = "voxdag-demo.mtl";

/// Voxels along the longest axis for the demo's pictures: of the hall 1.8 cm each, of the studio 0.8 cm.
pub const RESOLUTION: u32 = 1024;

/// From where, and in which light, the demo's picture is drawn. World units, colours in linear light.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct DemoView {
    /// Position of the camera.
    pub eye: [f64; 3],
    /// What the camera looks at.
    pub target: [f64; 3],
    /// The direction that is up in the picture.
    pub up: [f64; 3],
    /// Vertical field of view in degrees.
    pub fov_y: f64,
    /// Point lights: position, and colour times strength.
    pub lights: &'static [([f64; 3], [f32; 3])],
    /// Whether they cast shadows.
    pub shadows: bool,
    /// Ambient light.
    pub ambient: [f32; 3],
}

/// The view for the demo's picture: from the open front, down the nave to the apse.
pub const fn view() -> DemoView {
    DemoView {
        eye: [0.75, 1.75, 9.5],
        target: [-0.1, 2.42, -1.0],
        up: [0.0, 1.0, 0.0],
        fov_y: 46.0,
        lights: &[
            // The lamp over the nave.
            ([0.0, 3.2, 2.0], [0.52, 0.36, 0.19]),
            // Low sun through the open front, from the left, and the sky from the right.
            ([-9.0, 4.5, 8.0], [0.27, 0.21, 0.14]),
            ([9.0, 5.0, 11.0], [0.04, 0.07, 0.13]),
            // The windows of the apse, from behind.
            ([0.4, 2.8, -8.8], [0.16, 0.26, 0.46]),
            // The windows of the right aisle.
            ([5.8, 2.2, -1.0], [0.06, 0.12, 0.22]),
            // Late sun in the left aisle.
            ([-5.8, 2.0, -3.0], [0.26, 0.14, 0.05]),
        ],
        shadows: false,
        ambient: [0.033, 0.034, 0.042],
    }
}

/// The scene as Wavefront OBJ: objects, quads and polygons, one `usemtl` per change of material.
pub fn obj() -> String {
    hall::build()
}

/// The materials of [`obj`], colours encoded as sRGB like those of any authoring tool.
pub fn mtl() -> String {
    let mut text = String::from("# voxdag demo scene\n");
    for &(name, ka, kd, ks, ns) in MATERIALS {
        let _ = write!(text, "\nnewmtl {name}\nKa {ka}\nKd {kd}\nKs {ks}\nNs {ns}\nillum 2\n");
    }
    text
}

/// One row of [`MATERIALS`]: name, Ka, Kd, Ks, Ns.
type Row = (&'static str, &'static str, &'static str, &'static str, u32);

/// What glows does so by a Ka far above 1: the faint ambient light is enough for it.
const MATERIALS: &[Row] = &[
    ("limestone", "0.80 0.75 0.66", "0.80 0.75 0.66", "0.10 0.10 0.10", 12),
    ("plaster", "0.68 0.58 0.45", "0.68 0.58 0.45", "0.05 0.05 0.05", 6),
    ("serpentine", "0.20 0.30 0.26", "0.20 0.30 0.26", "0.40 0.40 0.40", 40),
    ("vault", "0.22 0.33 0.55", "0.22 0.33 0.55", "0.10 0.10 0.10", 8),
    ("sandstone", "0.70 0.58 0.44", "0.70 0.58 0.44", "0.10 0.10 0.10", 10),
    ("brick", "0.66 0.25 0.17", "0.66 0.25 0.17", "0.12 0.12 0.12", 14),
    ("tile-light", "0.80 0.76 0.68", "0.80 0.76 0.68", "0.45 0.45 0.45", 60),
    ("tile-dark", "0.20 0.27 0.31", "0.20 0.27 0.31", "0.50 0.50 0.50", 60),
    ("tile-border", "0.50 0.20 0.15", "0.50 0.20 0.15", "0.45 0.45 0.45", 60),
    ("porphyry", "0.40 0.16 0.19", "0.40 0.16 0.19", "0.50 0.50 0.50", 50),
    ("marble", "0.90 0.89 0.87", "0.90 0.89 0.87", "0.70 0.70 0.70", 80),
    ("bronze", "0.50 0.31 0.17", "0.50 0.31 0.17", "1.00 0.80 0.52", 32),
    ("gold", "0.85 0.64 0.22", "0.85 0.64 0.22", "0.95 0.80 0.45", 24),
    ("glaze", "0.08 0.40 0.42", "0.08 0.40 0.42", "0.95 0.95 0.95", 90),
    ("crimson", "0.66 0.08 0.12", "0.66 0.08 0.12", "0.15 0.15 0.15", 8),
    ("indigo", "0.14 0.20 0.55", "0.14 0.20 0.55", "0.15 0.15 0.15", 8),
    ("glass-blue", "1.10 2.01 3.38", "0.17 0.35 0.66", "0.30 0.30 0.30", 40),
    ("glass-red", "3.55 0.97 0.82", "0.63 0.15 0.14", "0.30 0.30 0.30", 40),
    ("glass-amber", "3.93 3.06 1.33", "0.70 0.55 0.24", "0.30 0.30 0.30", 40),
    ("lead", "0.14 0.14 0.16", "0.14 0.14 0.16", "0.30 0.30 0.30", 20),
    ("lamp", "4.32 3.93 2.85", "0.70 0.64 0.50", "0.20 0.20 0.20", 20),
];

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::collections::BTreeSet;

    /// OBJ, MTL, its name, and about how many triangles there are.
    fn scenes() -> [(String, String, &'static str, core::ops::Range<usize>); 2] {
        [(obj(), mtl(), MTL_NAME, 20_000..60_000), (studio::obj(), studio::mtl(), studio::MTL_NAME, 40_000..100_000)]
    }

    #[test]
    #[cfg_attr(miri, ignore = "too long for an interpreter")]
    fn every_material_is_defined_once_and_used() {
        for (obj, mtl, name, _) in scenes() {
            let named = |text: &str, key: &str| -> alloc::vec::Vec<String> {
                text.lines().filter_map(|l| l.strip_prefix(key)).map(String::from).collect()
            };
            let defined = named(&mtl, "newmtl ");
            let unique: BTreeSet<_> = defined.iter().cloned().collect();
            assert_eq!(unique.len(), defined.len());
            assert_eq!(unique, named(&obj, "usemtl ").into_iter().collect());
            assert_eq!(named(&obj, "mtllib "), [name]);
        }
    }

    #[test]
    #[cfg_attr(miri, ignore = "too long for an interpreter")]
    fn faces_name_vertices_that_exist() {
        for (obj, _, _, expected) in scenes() {
            let (mut vertices, mut triangles) = (0, 0);
            for line in obj.lines() {
                if line.starts_with("v ") {
                    vertices += 1;
                } else if let Some(face) = line.strip_prefix("f ") {
                    let corners: BTreeSet<usize> = face.split(' ').map(|i| i.parse().unwrap()).collect();
                    assert!(corners.len() >= 3 && corners.len() == face.split(' ').count(), "{line}");
                    assert!(*corners.first().unwrap() >= 1 && *corners.last().unwrap() <= vertices, "{line}");
                    triangles += corners.len() - 2;
                }
            }
            assert!(expected.contains(&triangles), "{triangles} triangles");
        }
    }

    /// Checksums taken on x86-64; a target whose `libm` or number printing differs changes them.
    #[test]
    #[cfg_attr(miri, ignore = "too long for an interpreter")]
    fn the_text_is_the_same_on_every_target() {
        let found = scenes().map(|(obj, mtl, ..)| [obj, mtl].map(|text| crc32fast::hash(text.as_bytes())));
        assert_eq!(found, [[2895281419, 2589448281], [1732460935, 4098836146]]);
    }
}
