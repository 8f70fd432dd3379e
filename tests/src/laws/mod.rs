//! Laws as functions of bytes: whatever the bytes, the function returns, or panics with the law that broke.
//!
//! In: bytes that a fuzzer, a corpus file or a generator made up. Each law is called by a target of `fuzz/` and, on
//! stable, by `tests/replay.rs`. One law a file; its head says how bytes are read, so that seeds can be written by hand.

mod dag_builder;
mod file;
mod materials;
mod mtl;
mod normals;
mod obj;
mod pictures;
mod ranks;
mod ssvdag;
mod table;
mod textures;
mod traversal;
mod tree;
mod triangulation;

pub use dag_builder::dag_builder;
pub use file::file;
pub use materials::materials;
pub use mtl::mtl;
pub use normals::normals;
pub use obj::obj;
pub use pictures::pictures;
pub use ranks::ranks;
pub use ssvdag::{says_the_same, ssvdag};
pub use table::table;
pub use textures::textures;
pub use traversal::traversal;
pub use tree::tree;
pub use triangulation::triangulation;

use std::collections::BTreeMap;

use voxdag::Morton;

/// A law: returns, or panics.
pub type Law = fn(&[u8]);

/// Every law by the name of its fuzz target.
pub const ALL: [(&str, Law); 14] = [
    ("dag_builder", dag_builder),
    ("file", file),
    ("materials", materials),
    ("mtl", mtl),
    ("normals", normals),
    ("obj", obj),
    ("pictures", pictures),
    ("ranks", ranks),
    ("ssvdag", ssvdag),
    ("table", table),
    ("textures", textures),
    ("traversal", traversal),
    ("tree", tree),
    ("triangulation", triangulation),
];

/// Bytes taken one after the other, little-endian; zeros once they are used up.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn array<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        let (taken, rest) = self.0.split_at(self.0.len().min(N));
        bytes[..taken.len()].copy_from_slice(taken);
        self.0 = rest;
        bytes
    }

    fn u8(&mut self) -> u8 {
        self.array::<1>()[0]
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.array())
    }

    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A float near a cube of `size` voxels, or any at all. A byte chooses (modulo 8), then come: 0 the 64 bits; 1 an i16
    /// of quarters; 2 a u32 as an integer within the cube; 3 a u32 as a fraction of the cube; 4 a byte for one of
    /// [`SPECIAL`]; 5 an i8; 6 an i8 and an i16 for its exponent; 7 an i16 of quarters and an i8 of units in the last
    /// place that are added.
    fn float(&mut self, size: f64) -> f64 {
        match self.u8() % 8 {
            0 => f64::from_bits(self.u64()),
            1 => f64::from(self.u16() as i16) / 4.0,
            2 => f64::from(self.u32()) % size,
            3 => f64::from(self.u32()) / f64::from(u32::MAX) * size,
            4 => SPECIAL[usize::from(self.u8()) % SPECIAL.len()],
            5 => f64::from(self.u8() as i8),
            6 => {
                let (mantissa, exponent) = (f64::from(self.u8() as i8), i32::from(self.u16() as i16) % 1100);
                libm::scalbn(mantissa, exponent)
            }
            _ => {
                let (quarters, units) = (f64::from(self.u16() as i16) / 4.0, i64::from(self.u8() as i8));
                f64::from_bits(quarters.to_bits().wrapping_add_signed(units))
            }
        }
    }

    fn floats(&mut self, size: f64) -> [f64; 3] {
        core::array::from_fn(|_| self.float(size))
    }
}

/// The bricks of some voxels in Morton order: code, mask, and the voxels' materials.
fn bricks(map: &BTreeMap<u64, u16>) -> impl Iterator<Item = (Morton, u64, Vec<u16>)> {
    let mut codes: Vec<u64> = map.keys().map(|code| code & !63).collect();
    codes.dedup();
    codes.into_iter().map(|code| {
        let voxels = || map.range(code..code + 64);
        (Morton(code), voxels().map(|(voxel, _)| 1 << (voxel & 63)).sum(), voxels().map(|(_, id)| *id).collect())
    })
}

/// Where floats are at their worst, and the largest cube's border.
const SPECIAL: [f64; 16] = [
    0.0,
    -0.0,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -5e-324,
    2_097_152.0,
    2_097_151.999_999_999_8,
    1e300,
    -1e-300,
    0.5,
    f64::EPSILON,
];
