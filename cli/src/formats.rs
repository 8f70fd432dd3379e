//! Voxels and depths in the formats of other programs, streamed: memory does not grow with the number of voxels.

use std::io::{Result, Write};

use voxdag::file::Scene;
use voxdag::materials::Materials;
use voxdag::{Geometry, Grid, Morton};

use crate::report::number;

/// Largest side of a binvox grid: readers unpack it to a byte per voxel, 64 GiB here.
pub const MAX_BINVOX: u32 = 4096;

/// binvox, version 1 (Min): `N N N` voxels as runs of empty and filled ones, y fastest, then z, then x.
///
/// Voxel (x, y, z) has its centre at `translate + scale * ((x, y, z) + 0.5) / N` in the world: translate is the grid's
/// origin, scale the side of the cube of N^3 voxels.
pub fn binvox(geometry: impl Geometry, grid: &Grid, out: &mut dyn Write) -> Result<()> {
    let n = grid.resolution;
    let [x, y, z] = grid.origin.map(number);
    let scale = number(f64::from(n) * grid.voxel_size);
    write!(out, "#binvox 1\ndim {n} {n} {n}\ntranslate {x} {y} {z}\nscale {scale}\ndata\n")?;

    // Four layers of x at a time, as bricks have them: rows of y as bits, row by row of z.
    let (rows, words) = (n.next_multiple_of(4) as usize, n.div_ceil(64) as usize);
    let row = |x: u32, z: u32| ((x & 3) as usize * rows + z as usize) * words;
    let mut layers = vec![0u64; 4 * rows * words];
    let mut runs = Runs { out, filled: false, length: 0 };
    for x in (0..n).step_by(4) {
        layers.fill(0);
        for z in (0..n).step_by(4) {
            let mut y = 0;
            while let Some(first) = Morton::encode([x, y, z]).filter(|_| y < n) {
                let mut mask = geometry.brick(first);
                if mask == 0 {
                    let side = 1u32 << geometry.empty_level(first).unwrap_or(0).max(2);
                    y = (y | (side - 1)) + 1;
                    continue;
                }
                while mask != 0 {
                    let [x, y, z] = Morton(first.0 | u64::from(mask.trailing_zeros())).decode();
                    layers[row(x, z) + y as usize / 64] |= 1 << (y % 64);
                    mask &= mask - 1;
                }
                y += 4;
            }
        }
        for x in x..n.min(x + 4) {
            for z in 0..n {
                let mut left = n;
                for &word in &layers[row(x, z)..][..words] {
                    runs.word(word, left.min(64))?;
                    left -= left.min(64);
                }
            }
        }
    }
    runs.end()
}

/// Runs of equal voxels: pairs of a value (0 or 1) and a length up to 255.
struct Runs<'a> {
    out: &'a mut dyn Write,
    filled: bool,
    length: u64,
}

impl Runs<'_> {
    /// The lowest `bits` (1 to 64) of a word, the lowest first.
    fn word(&mut self, mut word: u64, mut bits: u32) -> Result<()> {
        while bits > 0 {
            let filled = word & 1 != 0;
            let length = if filled { word.trailing_ones() } else { word.trailing_zeros() }.min(bits);
            if filled != self.filled {
                self.end()?;
                self.filled = filled;
            }
            self.length += u64::from(length);
            word = word.checked_shr(length).unwrap_or(0);
            bits -= length;
        }
        Ok(())
    }

    /// Writes what is open.
    fn end(&mut self) -> Result<()> {
        while self.length > 0 {
            let length = self.length.min(255);
            self.out.write_all(&[u8::from(self.filled), length as u8])?;
            self.length -= length;
        }
        Ok(())
    }
}

/// A line `x y z material` per voxel, in Morton order.
pub fn xyz(scene: &Scene<'_>, out: &mut dyn Write) -> Result<()> {
    scene.geometry.voxels().try_for_each(|voxel| {
        let [x, y, z] = voxel.decode();
        writeln!(out, "{x} {y} {z} {}", scene.materials.id(voxel))
    })
}

/// NumPy's format 1.0: an array `[voxels, 4]` of little-endian u32 x, y, z, material, in Morton order.
pub fn npy(scene: &Scene<'_>, voxels: u64, out: &mut dyn Write) -> Result<()> {
    // Spaces and a line's end fill the header up to a multiple of 64 bytes.
    let header = format!("{{'descr': '<u4', 'fortran_order': False, 'shape': ({voxels}, 4), }}");
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(length as u16).to_le_bytes())?;
    writeln!(out, "{header:0$}", length - 1)?;
    scene.geometry.voxels().try_for_each(|voxel| {
        let [x, y, z] = voxel.decode();
        let row = [x, y, z, scene.materials.id(voxel).into()];
        out.write_all(row.map(u32::to_le_bytes).as_flattened())
    })
}

/// PFM: a greyscale picture of f32, the bottom row first; the negative scale says little-endian. `rows` has the top row
/// first.
pub fn pfm(width: u32, height: u32, rows: &[f32], out: &mut dyn Write) -> Result<()> {
    write!(out, "Pf\n{width} {height}\n-1.0\n")?;
    rows.chunks_exact(width as usize).rev().flatten().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}
