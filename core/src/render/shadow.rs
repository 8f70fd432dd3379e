//! Rays from a surface towards a light (Appel 1968): what they meet keeps the light away.
//!
//! A ray starts where the camera's came from, by index: in the empty voxel before the hit. No offset is added and none is
//! needed, as the walk goes on from that voxel whatever rounding did to the point; a surface cannot shade itself by a wrong
//! start. It can by its shape: voxels are steps, and where the light falls on them at a slant a step shades the next. That
//! much is true of the voxels, though not of what they stand for; `tests/shadows.rs` measures it.
//!
//! Where the camera's ray came from outside the cube there is no such voxel, but none that could be in the way, either:
//! a ray that turns back into the face meets the hit itself, and any other is out of the cube for good. (The one exception:
//! through an edge of the cube.) A camera's ray that began in a filled voxel shows no surface; nothing shades that.

use crate::math;
use crate::shade::LightKind;
use crate::trace::{Hit, Query};

/// The ray from `point`, where a camera's ray met `hit`, to a light, all in grid coordinates; it ends at the light. `None`:
/// nothing is in the way.
#[inline]
pub(super) fn towards(light: &LightKind, hit: &Hit, point: [f64; 3]) -> Option<Query> {
    let (dir, t_max) = match *light {
        LightKind::Point(position) => (math::sub(position, point), 1.0),
        LightKind::Directional(dir) => (dir, f64::INFINITY),
    };
    let turns_back = || math::dot(hit.face.normal().map(f64::from), dir) < 0.0;
    let start = hit.from.or_else(|| turns_back().then_some(hit.voxel))?;
    Some(Query { t_max, start: Some(start), ..Query::new(point, dir) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::morton::Morton;
    use crate::trace::Face;

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
        let start = |from, face, light| towards(&light, &hit(from, face), point).map(|q| q.start.unwrap().decode());
        let (above, below) = (LightKind::Directional([1.0, 2.0, 0.0]), LightKind::Directional([1.0, -1e-9, 0.0]));
        for light in [above, below] {
            assert_eq!(start(Some([1, 2, 1]), Face::PosY, light), Some([1, 2, 1]));
            assert_eq!(start(None, Face::Inside, light), None);
        }
        // From outside the cube.
        assert_eq!(start(None, Face::PosY, above), None);
        assert_eq!(start(None, Face::PosY, LightKind::Point([5.0, 2.0, 1.0])), None);
        assert_eq!(start(None, Face::PosY, below), Some([1, 1, 1]));

        // It ends at a lamp, and nowhere on the way to the sun.
        let ray = |light| towards(&light, &hit(Some([1, 2, 1]), Face::PosY), point).unwrap();
        let to_lamp = ray(LightKind::Point([4.5, 6.0, 0.5]));
        assert_eq!((to_lamp.origin, to_lamp.dir, to_lamp.t_max), (point, [3.0, 4.0, -1.0], 1.0));
        assert_eq!((ray(above).dir, ray(above).t_max), ([1.0, 2.0, 0.0], f64::INFINITY));
    }
}
