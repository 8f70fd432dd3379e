//! A camera that moves: keys at frames, and the cameras between them.
//!
//! Eye, target, up and field of view each run through the keys that give them on a curve of Catmull and Rom (1974): a
//! cubic between two keys whose speed at a key is that from the key before to the key after, or, at the first and last,
//! that to its one neighbour. Differs from theirs in that keys may lie unevenly: speeds are per frame. So a key is met
//! exactly, two keys make a straight line at constant speed, and keys on a line, evenly passed, change nothing. Before
//! the first key that gives a value and after the last one it stands still.

use std::ops::RangeInclusive;

use crate::options::CameraArgs;

/// What the camera is at one frame; what it leaves out is up to its neighbours.
#[derive(Clone, PartialEq, Debug)]
pub struct Key {
    /// From 1.
    pub frame: u32,
    pub camera: CameraArgs,
}

/// Keys in the order of their frames, none twice.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CameraPath(pub Vec<Key>);

impl CameraPath {
    /// The frames from the first key to the last; `None` without keys.
    pub fn frames(&self) -> Option<RangeInclusive<u32>> {
        Some(self.0.first()?.frame..=self.0.last()?.frame)
    }

    /// The camera at a frame; what no key gives is left out.
    pub fn camera(&self, frame: u32) -> CameraArgs {
        CameraArgs {
            eye: self.at(frame, |camera| camera.eye),
            target: self.at(frame, |camera| camera.target),
            view_up: self.at(frame, |camera| camera.view_up),
            fov: self.at(frame, |camera| camera.fov.map(|fov| [fov])).map(|[fov]| fov),
        }
    }

    /// A value of the camera at a frame.
    fn at<const N: usize>(&self, frame: u32, of: impl Fn(&CameraArgs) -> Option<[f64; N]>) -> Option<[f64; N]> {
        let keys: Vec<_> = self.0.iter().filter_map(|key| Some((f64::from(key.frame), of(&key.camera)?))).collect();
        let now = f64::from(frame);
        let next = keys.partition_point(|key| key.0 <= now);
        if next == 0 || next == keys.len() {
            return keys.get(next.saturating_sub(1)).map(|key| key.1);
        }

        // The speed at a key, from its neighbours.
        let speed = |i: usize, axis: usize| {
            let (before, after) = (keys[i.saturating_sub(1)], keys[(i + 1).min(keys.len() - 1)]);
            (after.1[axis] - before.1[axis]) / (after.0 - before.0)
        };
        // Hermite's cubic from one key to the next.
        let ((start, from), (end, to)) = (keys[next - 1], keys[next]);
        let (frames, s) = (end - start, (now - start) / (end - start));
        Some(std::array::from_fn(|axis| {
            let rest = 1.0 - s;
            let places = rest * rest * (1.0 + 2.0 * s) * from[axis] + s * s * (3.0 - 2.0 * s) * to[axis];
            let speeds = s * rest * (rest * speed(next - 1, axis) - s * speed(next, axis));
            places + frames * speeds
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(keys: &[(u32, Option<f64>, Option<f64>)]) -> CameraPath {
        let camera = |x: Option<f64>, fov| CameraArgs { eye: x.map(|x| [x, 0.0, 1.0]), fov, ..CameraArgs::default() };
        CameraPath(keys.iter().map(|&(frame, x, fov)| Key { frame, camera: camera(x, fov) }).collect())
    }

    #[test]
    fn keys_are_met_exactly_and_hold_beyond_their_ends() {
        let path =
            path(&[(3, Some(0.1), None), (5, Some(-7.3), Some(40.0)), (12, Some(1e9), Some(50.0)), (13, None, None)]);
        assert_eq!(path.frames(), Some(3..=13));
        for key in &path.0[..3] {
            assert_eq!(path.camera(key.frame).eye, key.camera.eye);
        }
        assert_eq!(path.camera(3).fov, Some(40.0));
        assert_eq!((path.camera(13).eye, path.camera(13).fov), (path.camera(12).eye, Some(50.0)));
        assert_eq!((path.camera(5).target, CameraPath::default().frames()), (None, None));
    }

    /// Catmull and Rom's own formula for even keys; and a line, evenly passed, stays one over uneven keys.
    #[test]
    fn between_keys_it_is_the_known_curve() {
        let [a, b, c, d] = [1.0, 4.0, 2.0, 9.0];
        let curve = path(&[(10, Some(a), None), (20, Some(b), None), (30, Some(c), None), (40, Some(d), None)]);
        for frame in 20..30 {
            let t = f64::from(frame - 20) / 10.0;
            let squares = (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t;
            let expected = 0.5 * (2.0 * b + (c - a) * t + squares + (3.0 * b - a - 3.0 * c + d) * t * t * t);
            assert!((curve.camera(frame).eye.unwrap()[0] - expected).abs() < 1e-12, "{frame}");
        }
        let line = path(&[(1, Some(2.0), None), (4, Some(8.0), None), (20, Some(40.0), None)]);
        for frame in 1..=20 {
            assert!((line.camera(frame).eye.unwrap()[0] - 2.0 * f64::from(frame)).abs() < 1e-12, "{frame}");
        }
    }
}
