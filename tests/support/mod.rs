//! What the laws of normals and shading share: a naive DAG from a set of voxels, seeded numbers, vectors.

use std::collections::{BTreeMap, HashMap};
use voxdag::Morton;

/// The words of the DAG of depth `depth` that holds `voxels`: bricks and nodes by plain maps, level by level.
pub fn dag_words(depth: u8, voxels: impl IntoIterator<Item = [u32; 3]>) -> Vec<u32> {
    let mut bricks = BTreeMap::<u64, u64>::new();
    for voxel in voxels {
        assert!(voxel.iter().all(|&c| c < 1 << depth), "voxel {voxel:?} lies outside depth {depth}");
        let code = Morton::encode(voxel).unwrap().0;
        *bricks.entry(code >> 6).or_default() |= 1 << (code & 63);
    }
    let mut words = vec![0; 24];
    words[0] = depth.into();

    // Bricks, then every level as a map from code to word offset.
    let mut seen = HashMap::new();
    let mut level: BTreeMap<u64, u32> = BTreeMap::new();
    for (code, mask) in bricks {
        let offset = *seen.entry(mask).or_insert_with(|| {
            words.extend([mask as u32, (mask >> 32) as u32]);
            words.len() as u32 - 2
        });
        level.insert(code, offset);
    }
    words[1] = seen.len() as u32;
    words[2] = words.len() as u32;
    for h in 3..=21u8 {
        if h <= depth {
            let mut nodes = BTreeMap::<u64, [u32; 8]>::new();
            for (code, offset) in level {
                nodes.entry(code >> 3).or_default()[(code & 7) as usize] = offset;
            }
            let mut seen = HashMap::new();
            level = BTreeMap::new();
            for (code, children) in nodes {
                let offset = *seen.entry(children).or_insert_with(|| {
                    let start = words.len() as u32;
                    let mask: u32 = (0..8).filter(|&i| children[i] != 0).map(|i| 1 << i).sum();
                    words.push(1 << 31 | mask);
                    words.extend(children.iter().filter(|&&c| c != 0));
                    start
                });
                level.insert(code, offset);
            }
        }
        words[h as usize] = words.len() as u32;
    }
    // Word h holds the end of level h; the last of them is word 21.
    words[22] = 0;
    words
}

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Below `n`.
    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// -1 to 1.
    pub fn signed(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A unit vector.
    pub fn unit(&mut self) -> [f64; 3] {
        loop {
            let v = [self.signed(), self.signed(), self.signed()];
            let length2 = voxdag::math::dot(v, v);
            if length2 > 1e-3 && length2 <= 1.0 {
                return voxdag::math::normalize(v).unwrap();
            }
        }
    }
}

/// Angle between two vectors in degrees, accurate near 0 too.
pub fn degrees(a: [f64; 3], b: [f64; 3]) -> f64 {
    use voxdag::math::{cross, dot};
    let c = cross(a, b);
    libm::atan2(dot(c, c).sqrt(), dot(a, b)).to_degrees()
}
