//! What makes the rays of a picture faster: a tree for many rays at once and a grid over it, derived from a geometry when
//! it is to be drawn, within a limit of memory. Answers do not depend on them, so as much is made as there is room for.

use crate::geometry::Geometry;
use crate::layout::AnyGeometry;
use crate::match_geometry;
use crate::simd::Level;
use crate::trace::{Top, TopBuf, Tracer};
use crate::wide::WideBuf;

/// Cells along an axis of the top grid, as a power of two: 32^3 of them take 1 MiB and are made in some 10 ms.
pub const TOP_BITS: u8 = 5;

/// What is derived from one geometry: of each as much as there is room and use for. Empty by default.
#[derive(Default)]
pub struct Trees {
    /// For many rays at once, where the machine has vectors.
    pub wide: Option<WideBuf>,
    /// Over the wide tree if there is one, else over the geometry.
    pub top: Option<TopBuf>,
}

impl Trees {
    /// Makes them of at most `left` bytes; `None` for no limit.
    pub fn new(geometry: AnyGeometry<'_>, left: Option<u64>) -> Trees {
        match Level::best().and_then(|_| match_geometry!(geometry, g => wide(&g, left))) {
            Some(tree) => {
                let rest = left.map(|left| left.saturating_sub(tree.as_wide().bytes() as u64));
                let top = top_within(&tree.as_wide(), TOP_BITS, rest);
                Trees { wide: Some(tree), top }
            }
            None => Trees { wide: None, top: match_geometry!(geometry, g => top_within(&g, TOP_BITS, left)) },
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> u64 {
        let wide = self.wide.as_ref().map_or(0, |wide| wide.as_wide().bytes());
        (wide + self.top.as_ref().map_or(0, |top| top.as_top().bytes())) as u64
    }
}

/// The tree that makes many rays at once faster, within what is `left`; `None` if there is no room.
pub fn wide(geometry: &impl Geometry, left: Option<u64>) -> Option<WideBuf> {
    // While it is made, it takes up to twice as much.
    let limit = left.map_or(usize::MAX, |left| usize::try_from(left / 2).unwrap_or(usize::MAX));
    WideBuf::new(geometry, limit).ok()
}

/// The largest top grid, of at most `2^bits` cells along an axis, that there is room for in what is `left`; that of a wide
/// tree is one for many rays at once. `None` if there is no room at all.
pub fn top_within(geometry: &impl Geometry, bits: u8, left: Option<u64>) -> Option<TopBuf> {
    let left = left.unwrap_or(u64::MAX);
    let fits = |&bits: &u8| 4 * (Top::words_for(bits) + Top::scratch_for(bits)) as u64 <= left;
    let (bits, step) = match geometry.wide_words() {
        Some(_) => (Top::bits_for_packets(geometry, bits), 2),
        None => (bits.min(Top::most_bits(geometry)), 1),
    };
    (0..=bits).rev().step_by(step).filter(fits).find_map(|bits| TopBuf::new(geometry, bits).ok())
}

/// What answers rays, by way of the geometry's top grid if there is one.
pub fn tracer<'a, G: Geometry>(geometry: G, top: impl Into<Option<&'a TopBuf>>) -> Tracer<'a, G> {
    top.into().and_then(|top| Tracer::with_top(geometry, top.as_top())).unwrap_or(Tracer::new(geometry))
}

/// Runs the same expression with what answers rays of an [`AnyGeometry`](crate::layout::AnyGeometry) and its
/// [`Trees`](crate::trees::Trees): many at once over the wide tree, or where there is none, one by one over what it is, with
/// the vectors for normals. One kernel for wide trees, which are made of any layout, and one for each layout.
///
/// ```
/// # use voxdag::{build::DagBuilder, layout::AnyGeometry, trace::{Arithmetic, Query}, trees::Trees, with_tracer, Morton};
/// # let mut builder = DagBuilder::new(2).unwrap();
/// # builder.push(Morton(0), 1).unwrap();
/// # let built = builder.finish().unwrap();
/// let geometry = AnyGeometry::Dag(built.dag());
/// let trees = Trees::new(geometry, None);
/// let ray = Query::new([0.5, 0.5, -1.0], [0.0, 0.0, 1.0]);
/// let hit = with_tracer!(geometry, &trees, tracer => tracer.trace(Arithmetic::Exact, &ray));
/// assert_eq!(hit.unwrap().voxel, Morton(0));
/// ```
#[macro_export]
macro_rules! with_tracer {
    ($geometry:expr, $trees:expr, $tracer:ident => $body:expr) => {{
        let (trees, level): (&$crate::trees::Trees, _) = ($trees, $crate::simd::Level::best());
        match &trees.wide {
            Some(wide) => {
                let $tracer = $crate::trees::tracer(wide.as_wide(), trees.top.as_ref()).with_level(level);
                $body
            }
            None => $crate::match_geometry!($geometry, g => {
                let $tracer = $crate::trees::tracer(g, trees.top.as_ref()).with_level(level);
                $body
            }),
        }
    }};
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Morton;
    use crate::build::DagBuilder;

    #[test]
    #[cfg_attr(miri, ignore = "too long for an interpreter")]
    fn what_makes_rays_faster_stays_within_the_limit() {
        // Bricks on the diagonal of a cube of 2^9 voxels a side.
        let mut builder = DagBuilder::new(9).unwrap();
        (0..128).for_each(|k| builder.push(Morton::encode([4 * k; 3]).unwrap(), 1).unwrap());
        let dag = builder.finish().unwrap();
        let dag = dag.dag();

        let tree = wide(&dag, None).unwrap();
        let bytes = tree.as_wide().bytes() as u64;
        assert!(wide(&dag, Some(2 * bytes)).is_some());
        assert!(wide(&dag, Some(2 * bytes - 1)).is_none());

        // Smaller grids where there is less room; those of a wide tree all serve many rays at once.
        for bits in 0..=TOP_BITS {
            let left = 4 * (Top::words_for(bits) + Top::scratch_for(bits)) as u64;
            assert!(top_within(&dag, TOP_BITS, Some(left)).is_some());
            assert!(top_within(&dag, TOP_BITS, Some(0)).is_none());
            // At depth 9 the cells of a grid of one are of odd level.
            let top = top_within(&tree.as_wide(), TOP_BITS, Some(left));
            assert_eq!(top.is_some(), bits >= 1);
            let many = tracer(tree.as_wide(), top.as_ref()).with_level(Level::best());
            assert_eq!(many.packet_level().is_some(), bits >= 1 && Level::best().is_some());
        }
    }
}
