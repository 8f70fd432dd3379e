//! Rays through self-similar DAGs of any depth against the exact ray oracle.

use core::cell::Cell;

use voxdag::trace::{Arithmetic, Hit, Query, TopBuf, Tracer};
use voxdag::{Dag, Morton};

use super::Bytes;
use crate::octree::{Recursive, words_of};
use crate::ray::{self, Ray, Truth};

/// The tracer says what is true: nearest hit, any hit, the hits along the ray, and the voxels that it passes; with and
/// without a top grid, at full resolution and coarser.
///
/// Byte 0 is the depth (0 to 21, modulo 22), byte 1 the number of rules less one (1 to 8), byte 2 the top grid's size
/// (0 to 3 bits). Each rule takes five bytes: which octants of a cube hold something (at least one does), and a u32 with
/// four bits per octant for the rule that holds there. The cube obeys rule 0. Every ray that follows takes a byte of
/// flags, origin, direction, and as flagged `t_min`, `t_max` and a start (see `Bytes::float` for numbers):
/// 1 `t_min` is given, else 0; 2 `t_max` is given, else infinite; 4 the direction is a point to aim at; 8 a `start` is
/// given: u64; the upper four bits are the level that counts as filled. At most four rays are read.
pub fn traversal(data: &[u8]) {
    let mut bytes = Bytes(data);
    let depth = bytes.u8() % 22;
    let rules = 1 + bytes.u8() % 8;
    let bits = bytes.u8() % 4;
    let rules: Vec<Rule> = (0..rules).map(|_| Rule { mask: bytes.u8().max(1), octants: bytes.u32() }).collect();
    let shape = SelfSimilar { rules, depth };
    let words = shape.words();
    let dag = Dag::new(&words).expect("the twin's words are a DAG");
    let top = TopBuf::new(&dag, bits).unwrap();
    let tracers = [Tracer::new(dag), Tracer::with_top(dag, top.as_top()).expect("the grid is this DAG's")];
    for _ in 0..4 {
        if bytes.is_empty() {
            break;
        }
        let query = take_query(&mut bytes, depth);
        check(&shape, &tracers, &query);
    }
}

fn take_query(bytes: &mut Bytes<'_>, depth: u8) -> Query {
    let size = f64::from(1u32 << depth);
    let flags = bytes.u8();
    let (origin, mut dir) = (bytes.floats(size), bytes.floats(size));
    if flags & 4 != 0 {
        dir = core::array::from_fn(|i| dir[i] - origin[i]);
    }
    Query {
        origin,
        dir,
        t_min: if flags & 1 != 0 { bytes.float(size) } else { 0.0 },
        t_max: if flags & 2 != 0 { bytes.float(size) } else { f64::INFINITY },
        start: (flags & 8 != 0).then(|| Morton(bytes.u64())),
        min_level: flags >> 4,
    }
}

/// What a cube holds: some octants, each of which obeys a rule in turn (four bits name it).
pub(super) struct Rule {
    pub(super) mask: u8,
    pub(super) octants: u32,
}

/// A shape that obeys its first rule.
pub(super) struct SelfSimilar {
    pub(super) rules: Vec<Rule>,
    pub(super) depth: u8,
}

impl SelfSimilar {
    /// The DAG's words.
    pub(super) fn words(&self) -> Vec<u32> {
        words_of(self, self.depth, Some(&0))
    }

    /// The rule of an octant of a cube that obeys `rule`; `None` if it is empty.
    pub(super) fn octant(&self, rule: u8, octant: u32) -> Option<u8> {
        let Rule { mask, octants } = &self.rules[usize::from(rule)];
        (mask >> octant & 1 != 0).then_some((octants >> (4 * octant) & 15) as u8 % self.rules.len() as u8)
    }

    /// Whether the cube of side 2^`level` at `corner` holds a voxel: every rule fills something.
    fn any(&self, level: u8, corner: [u32; 3]) -> bool {
        (level..self.depth)
            .rev()
            .try_fold(0, |rule, level| {
                let bit = |axis: usize| corner[axis] >> level & 1;
                self.octant(rule, bit(0) | bit(1) << 1 | bit(2) << 2)
            })
            .is_some()
    }
}

impl Recursive for SelfSimilar {
    type State = u8;

    fn split(&self, _: u8, state: &u8) -> [Option<u8>; 8] {
        core::array::from_fn(|octant| self.octant(*state, octant as u32))
    }
}

/// Cubes that the oracle may look at for one ray: it descends into every one that the ray meets until there is a hit.
const MOST_CUBES: u32 = 1000;
/// Voxels along a ray that are compared.
const MOST_VOXELS: usize = 50;

fn check(shape: &SelfSimilar, tracers: &[Tracer<'_>; 2], query: &Query) {
    let depth = shape.depth;
    let ray = Ray { origin: query.origin, dir: query.dir, t_min: query.t_min, t_max: query.t_max };
    let looked_at = Cell::new(0);
    let any = |level: u8, corner: [u32; 3]| {
        looked_at.set(looked_at.get() + 1);
        looked_at.get() < MOST_CUBES && shape.any(level, corner)
    };
    let truth = ray::first(&ray, depth, query.min_level, &any);
    let known = looked_at.get() < MOST_CUBES;
    if !known && depth > 12 {
        return;
    }
    for tracer in tracers {
        for arithmetic in [Arithmetic::Exact, Arithmetic::F64] {
            let (hit, steps) = tracer.trace_counted(arithmetic, query);
            assert!(steps.rounds <= 3 << depth, "{steps:?}: {query:?}");
            if arithmetic == Arithmetic::Exact && known && query.start.is_none() {
                same(hit, truth.as_ref(), query);
            }
            assert_eq!(tracer.occluded(arithmetic, query), hit.is_some(), "occluded, {arithmetic:?}: {query:?}");
            if let Some(hit) = hit {
                assert_eq!(hit.level, query.min_level.min(depth), "level: {query:?}");
            }
        }
    }
    if query.start.is_some() {
        return;
    }

    // The voxels along the ray, the filled ones among them, and the hits.
    let passed = ray::walk(&ray, depth, MOST_VOXELS);
    let found: Vec<_> = query.voxels(depth).take(MOST_VOXELS).map(Morton::decode).collect();
    assert_eq!(found, passed, "voxels: {query:?}");
    let filled: Vec<_> = passed.iter().copied().filter(|&voxel| shape.any(0, voxel)).collect();
    let fine = Query { min_level: 0, ..*query };
    for tracer in tracers {
        // Behind the voxels that were compared there may be more.
        let most = if passed.len() < MOST_VOXELS { filled.len() + 1 } else { filled.len() };
        let hits: Vec<_> = tracer.hits(&fine).take(most).collect();
        assert_eq!(hits.iter().map(|hit| hit.voxel.decode()).collect::<Vec<_>>(), filled, "hits: {query:?}");
        if known && depth <= 12 {
            assert_eq!(tracer.hits(query).next(), tracer.trace(Arithmetic::Exact, query), "first of hits: {query:?}");
        }
    }
}

/// The tracer found the truth: voxel, side, the voxel before, and the time to one unit in the last place.
fn same(found: Option<Hit>, truth: Option<&Truth>, query: &Query) {
    let (Some(hit), Some(truth)) = (&found, truth) else {
        assert!(found.is_none() && truth.is_none(), "{query:?}\nfound {found:?}\ntruth {truth:?}");
        return;
    };
    let agree = hit.voxel.decode() == truth.voxel
        && hit.face == truth.face
        && hit.from.map(Morton::decode) == truth.from
        && (hit.t == truth.t || hit.t.to_bits().abs_diff(truth.t.to_bits()) <= 1);
    assert!(agree, "{query:?}\nfound {hit:?}\ntruth {truth:?}");
}
