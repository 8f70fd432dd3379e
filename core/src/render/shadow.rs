//! Rays from a surface towards a light (Appel 1968): what they meet keeps the light away.
//!
//! Voxels are steps, and where light falls on them at a slant a step shades the next, though the surface that they stand
//! for is smooth. So a ray starts above the steps ([`above`]), if the way up there is free; where it is not, on the step.
//! Either way light has come along an empty path, however thin the walls are. Where a normal is the voxel's own side, the
//! steps are what is drawn and rays start on them. The way up, and a ray without one, start by index: in the empty voxel
//! before the hit, so that no rounding of the point puts them into the hit, and no offset is needed. Differs from the
//! usual offset along the normal in that: its length follows from the voxels, and it cannot pass through what is there.
//!
//! Where the camera's ray came from outside the cube there is no voxel before the hit, and nothing that could be in the
//! way: a ray that turns back into the face meets the hit itself, and any other is out of the cube for good. (The one
//! exception: through an edge of the cube.) A camera's ray that began in a filled voxel shows no surface; nothing shades that.

use crate::math;
use crate::normal::{Confidence, Normal};
use crate::shade::LightKind;
use crate::trace::{Face, Hit, Query};

/// As much higher rays start: over a wall that is square to an axis they would else start on the side between two voxels, and
/// rounding would say in which.
const CLEAR: f64 = 1.0 / 1024.0;

/// The place above `point` from which rays start, free of the steps around it if `lift` is 1; `None` if they are to start
/// at the point.
///
/// A plane with the unit normal n passes only through voxels whose points are less than `|nx| + |ny| + |nz|` above it, and
/// a hit on them is not below it: from that much higher no ray that rises from the plane meets them.
#[inline]
pub(super) fn above(hit: &Hit, point: [f64; 3], normal: &Normal, lift: f32) -> Option<[f64; 3]> {
    if normal.confidence == Confidence::Face || hit.face == Face::Inside || !(lift > 0.0) {
        return None;
    }
    let n = normal.direction.map(f64::from);
    let height = n[0].abs() + n[1].abs() + n[2].abs();
    Some(math::add_scaled(point, n, f64::from(lift) * (height * (1.0 + CLEAR))))
}

/// The ray from `origin` to a light, both in grid coordinates; it ends at the light.
#[inline]
pub(super) fn from(origin: [f64; 3], light: &LightKind) -> Query {
    match *light {
        LightKind::Point(position) => Query { t_max: 1.0, ..Query::new(origin, math::sub(position, origin)) },
        LightKind::Directional(dir) => Query::new(origin, dir),
    }
}

/// The same ray from `point`, where a camera's ray met `hit`; `None` if nothing is in its way.
#[inline]
pub(super) fn from_hit(hit: &Hit, point: [f64; 3], light: &LightKind) -> Option<Query> {
    let ray = from(point, light);
    let turns_back = || math::dot(hit.face.normal().map(f64::from), ray.dir) < 0.0;
    let start = hit.from.or_else(|| turns_back().then_some(hit.voxel))?;
    Some(Query { start: Some(start), ..ray })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::morton::Morton;

    #[test]
    fn rays_start_before_the_hit_or_are_decided() {
        let point = [1.5, 2.0, 1.5];
        let hit = |from: Option<[u32; 3]>, face| Hit {
            voxel: Morton::encode([1, 1, 1]).unwrap(),
            from: from.map(|v| Morton::encode(v).unwrap()),
            t: 1.0,
            level: 0,
            face,
        };
        let start = |from, face, light| from_hit(&hit(from, face), point, &light).map(|q| q.start.unwrap().decode());
        let (rising, falling) = (LightKind::Directional([1.0, 2.0, 0.0]), LightKind::Directional([1.0, -1e-9, 0.0]));
        for light in [rising, falling] {
            assert_eq!(start(Some([1, 2, 1]), Face::PosY, light), Some([1, 2, 1]));
            assert_eq!(start(None, Face::Inside, light), None);
        }
        // From outside the cube.
        assert_eq!(start(None, Face::PosY, rising), None);
        assert_eq!(start(None, Face::PosY, LightKind::Point([5.0, 2.0, 1.0])), None);
        assert_eq!(start(None, Face::PosY, falling), Some([1, 1, 1]));

        // It ends at a lamp, and nowhere on the way to the sun.
        let to_lamp = from(point, &LightKind::Point([4.5, 6.0, 0.5]));
        assert_eq!((to_lamp.origin, to_lamp.dir, to_lamp.t_max), (point, [3.0, 4.0, -1.0], 1.0));
        assert_eq!((from(point, &rising).dir, from(point, &rising).t_max), ([1.0, 2.0, 0.0], f64::INFINITY));

        // As high as a voxel is along the normal, and a thousandth more: in which voxel does not depend on rounding.
        let fitted = Normal { direction: [0.0, 0.75, -0.5], confidence: Confidence::Stored };
        let side = Normal { confidence: Confidence::Face, ..fitted };
        let height = 1.25 * 1025.0 / 1024.0;
        assert_eq!(
            above(&hit(None, Face::PosY), point, &fitted, 1.0),
            Some([1.5, 2.0 + height * 0.75, 1.5 - height * 0.5])
        );
        let up = Normal { direction: [0.0, 1.0, 0.0], ..fitted };
        // The last one would be below 3 without that thousandth.
        for y in [2.0, 2.0_f64.next_down(), 2.0_f64.next_up(), 2.0 - 1e-12] {
            assert_eq!(above(&hit(None, Face::PosY), [1.5, y, 1.5], &up, 1.0).unwrap()[1] as u32, 3);
        }
        assert_eq!(above(&hit(None, Face::PosY), point, &side, 1.0), None);
        assert_eq!(above(&hit(None, Face::Inside), point, &fitted, 1.0), None);
        assert_eq!(above(&hit(None, Face::PosY), point, &fitted, 0.0), None);
    }
}
