//! What makes the rays of a picture faster: a tree for many rays at once and a grid over it, derived from a geometry when
//! it is to be drawn, within what the memory limit leaves.

use voxdag::geometry::Geometry;
use voxdag::layout::AnyGeometry;
use voxdag::match_geometry;
use voxdag::simd::Level;
use voxdag::trace::{Top, TopBuf};
use voxdag::wide::WideBuf;

use crate::memory::Memory;

/// Cells along an axis of the top grid, as a power of two: 32^3 of them take 1 MiB and are made in some 10 ms.
pub const TOP_BITS: u8 = 5;

/// What is derived from one geometry: of each as much as there is room and use for.
pub struct Trees {
    pub wide: Option<WideBuf>,
    /// Over the wide tree if there is one, else over the geometry.
    pub top: Option<TopBuf>,
}

impl Trees {
    /// Makes them.
    pub fn new(geometry: AnyGeometry<'_>, memory: &Memory) -> Trees {
        match Level::best().and_then(|_| match_geometry!(geometry, g => wide(&g, memory))) {
            Some(tree) => {
                let rest = memory.with(tree.as_wide().bytes() as u64);
                let top = top_within(&tree.as_wide(), TOP_BITS, &rest);
                Trees { wide: Some(tree), top }
            }
            None => Trees { wide: None, top: match_geometry!(geometry, g => top_within(&g, TOP_BITS, memory)) },
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> u64 {
        let wide = self.wide.as_ref().map_or(0, |wide| wide.as_wide().bytes());
        (wide + self.top.as_ref().map_or(0, |top| top.as_top().bytes())) as u64
    }
}

/// The tree that makes many rays at once faster, within what the memory limit leaves; `None` if there is no room.
pub fn wide(geometry: &impl Geometry, memory: &Memory) -> Option<WideBuf> {
    // While it is made, it takes up to twice as much.
    let limit = memory.left().map_or(usize::MAX, |left| usize::try_from(left / 2).unwrap_or(usize::MAX));
    WideBuf::new(geometry, limit).ok()
}

/// The largest top grid, of at most `2^bits` cells along an axis, that the memory limit leaves room for; that of a wide
/// tree is one for many rays at once. `None` if there is no room at all.
pub fn top_within(geometry: &impl Geometry, bits: u8, memory: &Memory) -> Option<TopBuf> {
    let left = memory.left().unwrap_or(u64::MAX);
    let fits = |&bits: &u8| 4 * (Top::words_for(bits) + Top::scratch_for(bits)) as u64 <= left;
    let (bits, step) = match geometry.wide_words() {
        Some(_) => (Top::bits_for_packets(geometry, bits), 2),
        None => (bits.min(Top::most_bits(geometry)), 1),
    };
    (0..=bits).rev().step_by(step).filter(fits).find_map(|bits| TopBuf::new(geometry, bits).ok())
}

/// Runs the same expression with what answers rays of an [`AnyGeometry`] and its [`Trees`]: many at once over the wide
/// tree, or where there is none, one by one over what it is, with the vectors for normals. One kernel for wide trees,
/// which are made of any layout, and one for each layout.
macro_rules! with_tracer {
    ($geometry:expr, $trees:expr, $tracer:ident => $body:expr) => {{
        let (trees, level): (&$crate::trees::Trees, _) = ($trees, voxdag::simd::Level::best());
        match &trees.wide {
            Some(wide) => {
                let $tracer = $crate::scene::tracer(wide.as_wide(), trees.top.as_ref()).with_level(level);
                $body
            }
            None => voxdag::match_geometry!($geometry, g => {
                let $tracer = $crate::scene::tracer(g, trees.top.as_ref()).with_level(level);
                $body
            }),
        }
    }};
}
pub(crate) use with_tracer;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tracer;
    use voxdag::Morton;
    use voxdag::build::DagBuilder;

    #[test]
    fn what_makes_rays_faster_stays_within_the_limit() {
        // Bricks on the diagonal of a cube of 2^9 voxels a side.
        let mut builder = DagBuilder::new(9).unwrap();
        (0..128).for_each(|k| builder.push(Morton::encode([4 * k; 3]).unwrap(), 1).unwrap());
        let dag = builder.finish().unwrap();
        let dag = dag.dag();

        let tree = wide(&dag, &Memory::new(None)).unwrap();
        let bytes = tree.as_wide().bytes() as u64;
        assert!(wide(&dag, &Memory::new(Some(2 * bytes))).is_some());
        assert!(wide(&dag, &Memory::new(Some(2 * bytes + 99)).with(100)).is_none());

        // Smaller grids where there is less room; those of a wide tree all serve many rays at once.
        for bits in 0..=TOP_BITS {
            let left = 4 * (Top::words_for(bits) + Top::scratch_for(bits)) as u64;
            let memory = Memory::new(Some(left));
            assert!(top_within(&dag, TOP_BITS, &memory).is_some());
            assert!(top_within(&dag, TOP_BITS, &memory.with(left)).is_none());
            // At depth 9 the cells of a grid of one are of odd level.
            let top = top_within(&tree.as_wide(), TOP_BITS, &memory);
            assert_eq!(top.is_some(), bits >= 1);
            let many = tracer(tree.as_wide(), top.as_ref()).with_level(Level::best());
            assert_eq!(many.packet_level().is_some(), bits >= 1 && Level::best().is_some());
        }
    }
}
