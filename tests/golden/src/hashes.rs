//! The scenes, and the hashes that they have on every target. This is the only place that knows them: whoever changes what
//! is built or drawn on purpose copies the lines that `./ci.sh targets` prints.

use voxdag::normal::NormalKind;
use voxdag::render::Samples;

/// What is hashed: the words of the scene's file; voxel, time, face, normal and colour of rays, in all their bits; the
/// words of the picture, RGBA8.
pub const STAGES: [&str; 3] = ["build", "rays", "image"];

/// A scene and how it is drawn.
pub struct Case {
    /// Its name.
    pub name: &'static str,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub samples: Samples,
    /// Where the picture's normals come from.
    pub normals: NormalKind,
    /// Eye and target in the world; the default view where there are none.
    pub view: Option<[[f64; 3]; 2]>,
    /// One hash per stage.
    pub hashes: [u64; 3],
}

/// All scenes, the small ones first.
pub const CASES: [Case; 5] = [
    Case {
        name: "ball",
        size: [40, 30],
        samples: Samples::SixtyFour,
        normals: NormalKind::Plane1,
        view: None,
        hashes: [0xfae4_0983_8744_ce6f, 0x8edb_e323_bfd8_202b, 0x43b8_07d1_c0fc_315f],
    },
    Case {
        name: "ring",
        size: [80, 60],
        samples: Samples::Five,
        normals: NormalKind::Stored,
        view: None,
        hashes: [0x4221_c67d_5f90_8026, 0x464c_5f75_b6d1_af61, 0xb9ef_296c_eebf_73f4],
    },
    Case {
        name: "waves",
        size: [80, 60],
        samples: Samples::One,
        normals: NormalKind::Gradient,
        view: None,
        hashes: [0x412f_43ee_54d8_c5b7, 0xd764_f5d7_5dac_43dd, 0x6dc8_0c04_7878_e3dd],
    },
    Case {
        name: "soup",
        size: [40, 30],
        samples: Samples::Sixteen,
        normals: NormalKind::Plane3,
        view: None,
        hashes: [0x4d87_b35a_7624_356e, 0x926a_cee1_cb9c_d70b, 0xdba0_0450_bf64_16bc],
    },
    Case {
        name: "hall",
        size: [128, 72],
        samples: Samples::Four,
        normals: NormalKind::Plane2,
        view: Some([[0.75, 1.75, 9.5], [-0.1, 2.42, -1.0]]),
        hashes: [0x42ed_6482_30bb_c0ca, 0xe442_a8a6_f80d_653b, 0x7c17_9335_5c72_5e07],
    },
];
