//! Editing: a scene is kept as the DAGs of its chunks; an edit rebuilds the chunks that it touches, and joins all of them.
//!
//! A materials' table or tree is keyed by Morton codes, not by the DAG: voxels that stay keep theirs.
//!
//! `cargo run --release -p voxdag --features obj --example edit`

use std::error::Error;
use std::time::Instant;

use voxdag::Morton;
use voxdag::build::{BuildError, DagBuf, DagBuilder};

/// Voxels along a scene's side: 2^9; along a chunk's: 2^6.
const DEPTH: u8 = 9;
const CHUNK: u8 = 6;
/// Voxels of a chunk.
const VOLUME: u64 = 1 << (3 * CHUNK);

/// The chunks of a scene, in Morton order.
struct Chunks(Vec<DagBuf>);

impl Chunks {
    /// A scene filled where `inside` says so.
    fn new(inside: impl Fn([u32; 3]) -> bool) -> Result<Chunks, BuildError> {
        (0..1u64 << (3 * (DEPTH - CHUNK)))
            .map(|i| chunk(i, |voxel| inside(voxel.decode())))
            .collect::<Result<_, _>>()
            .map(Chunks)
    }

    /// Takes all voxels of a ball away; says how many chunks were rebuilt.
    fn dig(&mut self, center: [i32; 3], radius: i32) -> Result<usize, BuildError> {
        let is_dug = |p: [u32; 3]| {
            let off = [0, 1, 2].map(|i| i64::from(p[i] as i32 - center[i]));
            off.iter().map(|x| x * x).sum::<i64>() <= i64::from(radius).pow(2)
        };
        let mut rebuilt = 0;
        for (i, old) in (0..).zip(&mut self.0) {
            let (low, side) = (Morton(i * VOLUME).decode().map(|x| x as i32), 1 << CHUNK);
            let is_near = (0..3).all(|k| (low[k] - radius..=low[k] + side + radius).contains(&center[k]));
            if is_near {
                let was = old.dag();
                *old = chunk(i, |voxel| was.contains(Morton(voxel.0 % VOLUME)) && !is_dug(voxel.decode()))?;
                rebuilt += 1;
            }
        }
        Ok(rebuilt)
    }

    /// The DAG of the whole scene. Work by the chunks' words, not by their voxels.
    fn join(&self) -> Result<DagBuf, BuildError> {
        let mut builder = DagBuilder::new(DEPTH)?;
        for (i, chunk) in (0..).zip(&self.0) {
            builder.append(Morton(i * VOLUME), &chunk.dag())?;
        }
        builder.finish()
    }
}

/// Chunk `i` of a scene, in its own coordinates: filled where `inside` says so of a voxel of the scene.
fn chunk(i: u64, inside: impl Fn(Morton) -> bool) -> Result<DagBuf, BuildError> {
    let mut builder = DagBuilder::new(CHUNK)?;
    for brick in (0..VOLUME).step_by(64) {
        let filled = (0..64).filter(|bit| inside(Morton(i * VOLUME + brick + bit)));
        let mask = filled.fold(0, |mask, bit| mask | 1 << bit);
        if mask != 0 {
            builder.push(Morton(brick), mask)?;
        }
    }
    builder.finish()
}

/// Ground with waves.
fn ground([x, y, z]: [u32; 3]) -> bool {
    let wave = (x * x / 97 + z * z / 61) % 40;
    y < 200 + wave.min(40 - wave)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut chunks = Chunks::new(ground)?;
    let before = chunks.join()?;
    let start = Instant::now();
    let rebuilt = chunks.dig([250, 210, 250], 30)?;
    let dug = start.elapsed();
    let after = chunks.join()?;
    let joined = start.elapsed() - dug;
    println!("{rebuilt} of {} chunks rebuilt in {dug:.1?}, joined in {joined:.1?}", chunks.0.len());
    println!("{} words before, {} after", before.words().len(), after.words().len());
    Ok(())
}

#[test]
fn an_edited_scene_is_the_scene_built_like_that() {
    let ([x, y, z], radius) = ([250i32, 210, 250], 30);
    let mut chunks = Chunks::new(ground).unwrap();
    let rebuilt = chunks.dig([x, y, z], radius).unwrap();
    assert!((1..=27).contains(&rebuilt), "{rebuilt}");
    let dug = |p: [u32; 3]| {
        let [a, b, c] = p.map(|x| x as i32);
        (a - x).pow(2) + (b - y).pow(2) + (c - z).pow(2) <= radius * radius
    };
    let expected = Chunks::new(|p| ground(p) && !dug(p)).unwrap().join().unwrap();
    let found = chunks.join().unwrap();
    assert_eq!(found.words(), expected.words());
    assert!(!found.dag().contains(Morton::encode([250, 210, 250]).unwrap()));
}
