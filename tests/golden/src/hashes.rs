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

/// The picture by [`crate::plain`] of the scene [`PLAIN_SCENE`].
pub const PLAIN: u64 = 0x3718_60f7_3a0b_7bb0;
/// Its name: a file of 6 KB.
pub const PLAIN_SCENE: &str = "little";

/// All scenes. The first is small enough for an interpreter.
pub const CASES: [Case; 6] = [
    Case {
        name: "tiny",
        size: [8, 6],
        samples: Samples::One,
        normals: NormalKind::Plane2,
        view: None,
        hashes: [0x862a_f4bd_dc08_a96a, 0xbf67_f4f5_f09a_74ca, 0x912e_f9d8_56a3_2edb],
    },
    Case {
        name: "ball",
        size: [40, 30],
        samples: Samples::SixtyFour,
        normals: NormalKind::Plane1,
        view: None,
        hashes: [0xfae4_0983_8744_ce6f, 0xf32a_9941_9a59_9a0c, 0x43b8_07d1_c0fc_315f],
    },
    Case {
        name: "ring",
        size: [80, 60],
        samples: Samples::Five,
        normals: NormalKind::Stored,
        view: None,
        hashes: [0x3dcd_32ae_9584_0306, 0xbec8_98fb_80c4_c2ad, 0x0923_7474_5ef7_39ae],
    },
    Case {
        name: "waves",
        size: [80, 60],
        samples: Samples::One,
        normals: NormalKind::Gradient,
        view: None,
        hashes: [0x2827_52e7_da89_138c, 0xaf59_9423_a699_280f, 0x0f90_026f_f9b9_a7d4],
    },
    Case {
        name: "soup",
        size: [40, 30],
        samples: Samples::Sixteen,
        normals: NormalKind::Plane3,
        view: None,
        hashes: [0x5216_ab67_d7fd_67cf, 0xdab6_f070_7a82_6cc8, 0xe90c_d647_a23e_0ee9],
    },
    Case {
        name: "hall",
        size: [128, 72],
        samples: Samples::Four,
        normals: NormalKind::Plane2,
        view: Some([[0.75, 1.75, 9.5], [-0.1, 2.42, -1.0]]),
        hashes: [0xca64_bf83_eafb_9c9e, 0x9c89_feab_b52e_b7e0, 0x7c17_9335_5c72_5e07],
    },
];
