// Cameras as values: {eye, target, up, fov}. Every function gives a new one.

const add = (a, b, s = 1) => a.map((x, i) => x + b[i] * s);
const sub = (a, b) => add(a, b, -1);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const unit = (a) => a.map((x) => x / (length(a) || 1));
// Of `v` about a unit axis (Rodrigues).
const turned = (v, axis, angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return add(add(v.map((x) => x * c), cross(axis, v), s), axis, dot(axis, v) * (1 - c));
};

export const distance = ({ eye, target }) => length(sub(eye, target));

const right = ({ eye, target, up }) => {
  const across = cross(sub(target, eye), up);
  // Seen from straight above, any direction does.
  return unit(length(across) > 0 ? across : cross(up, [up[1], up[2], up[0]]));
};

// Turns about the target by fractions of half a turn; never over the pole.
export function orbit(camera, x, y) {
  const up = unit(camera.up);
  const side = right(camera);
  let arm = sub(camera.eye, camera.target);
  const height = Math.asin(Math.min(1, Math.max(-1, dot(unit(arm), up))));
  const most = Math.PI / 2 - 0.01;
  const next = Math.min(most, Math.max(-most, height + y * Math.PI));
  arm = turned(arm, side, height - next);
  arm = turned(arm, up, -x * Math.PI);
  return { ...camera, up, eye: add(camera.target, arm) };
}

// Moves eye and target by fractions of the picture's height at the target.
export function pan(camera, x, y) {
  const side = right(camera);
  const above = cross(side, unit(sub(camera.target, camera.eye)));
  const height = 2 * distance(camera) * Math.tan((camera.fov * Math.PI) / 360);
  const way = add(side.map((a) => -a * x * height), above, y * height);
  return { ...camera, eye: add(camera.eye, way), target: add(camera.target, way) };
}

// Changes the distance from the target, within what a scene of this radius makes sense of.
export function zoom(camera, factor, radius) {
  const far = Math.min(radius * 50, Math.max(radius * 1e-3, distance(camera) * factor));
  return { ...camera, eye: add(camera.target, unit(sub(camera.eye, camera.target)), far) };
}

// A camera between two, `t` from 0 to 1.
export const between = (a, b, t) => ({
  ...b,
  eye: add(a.eye.map((x) => x * (1 - t)), b.eye, t),
  target: add(a.target.map((x) => x * (1 - t)), b.target, t),
});

// The direction of a light from its angles in degrees.
export function sunDirection(up, azimuth, elevation) {
  const [a, e] = [azimuth, elevation].map((x) => (x * Math.PI) / 180);
  const flat = [Math.cos(e) * Math.sin(a), Math.cos(e) * Math.cos(a)];
  return up === 'z' ? [flat[0], -flat[1], Math.sin(e)] : [flat[0], Math.sin(e), flat[1]];
}
