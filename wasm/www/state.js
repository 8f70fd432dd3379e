// What the visitor chose, and how a link carries it: `#name=value&...`, only what differs from the beginning.

export const EFFECTS = ['specular', 'shadows', 'mirror', 'transparency', 'refraction', 'emission', 'textures'];

const BEGINNING = {
  scene: '', // a URL; none for the scene that comes along
  title: '', // what it is called, if not by the URL
  resolution: 1024,
  up: 'y',
  show: 'shaded',
  normals: 'plane2',
  rest: '16',
  size: 'fit',
  light: 'scene',
  azimuth: 40,
  elevation: 50,
  ambient: 0.3,
  effects: EFFECTS.filter((name) => name !== 'shadows').join(','),
};

export const beginning = () => ({ ...BEGINNING, camera: null });

// What makes sense; a resolution or a size need not be one that the form offers.
const within = (low, high) => (value) => value >= low && value <= high;
const one = (...names) => (value) => names.includes(value);
const SENSE = {
  resolution: (value) => Number.isInteger(value) && value >= 1 && value <= 2 ** 21,
  up: one('y', 'z'),
  show: one('shaded', 'normals', 'depth', 'level', 'iterations', 'material', 'samples'),
  normals: one('face', 'stored', 'gradient', 'plane1', 'plane2', 'plane3', 'ernerfeldt1', 'ernerfeldt2'),
  rest: one('1', '4', '16-near', '16-adaptive', '16', '64'),
  size: (value) => value === 'fit' || sides(value) !== null,
  light: one('scene', 'sun'),
  azimuth: within(-180, 180),
  elevation: within(-90, 90),
  ambient: within(0, 1),
  effects: (value) => value.split(',').filter(Boolean).every((name) => EFFECTS.includes(name)),
};

// Width and height of a size, null if it is none.
export function sides(size) {
  const found = /^(\d+)x(\d+)$/.exec(size)?.slice(1).map(Number);
  return found?.every((side) => side > 0 && side <= 8192) ? found : null;
}

const numbers = (text) => text.split(',').map(Number);
// Between 1e-100 and 1e100 all products are numbers, too.
const isCamera = ({ eye, target, up, fov }) =>
  [eye, target, up].every((v) => v.length === 3 && v.every((x) => Math.abs(x) <= 1e100)) &&
  Math.hypot(...eye.map((x, i) => x - target[i])) > 1e-100 && Math.hypot(...up) > 1e-100 && fov >= 1e-3 && fov < 180;

// What a link says; what makes no sense is as in the beginning.
export function fromHash(hash) {
  const state = beginning();
  const said = new URLSearchParams(hash.replace(/^#/, ''));
  for (const name of Object.keys(BEGINNING)) {
    const value = said.get(name);
    if (value === null) continue;
    const meant = typeof BEGINNING[name] === 'number' ? Number(value || NaN) : value;
    if (SENSE[name]?.(meant) ?? true) state[name] = meant;
  }
  const [eye, target, up, fov] = ['eye', 'target', 'view-up', 'fov'].map((name) => numbers(said.get(name) ?? ''));
  const camera = { eye, target, up, fov: fov[0] };
  if (isCamera(camera)) state.camera = camera;
  return state;
}

export function toHash(state) {
  const parts = Object.keys(BEGINNING)
    .filter((name) => state[name] !== BEGINNING[name])
    .map((name) => `${name}=${encodeURIComponent(state[name]).replaceAll('%2C', ',')}`);
  if (state.camera) {
    // All digits: the same picture, bit by bit.
    const { eye, target, up, fov } = state.camera;
    parts.push(`eye=${eye}`, `target=${target}`, `view-up=${up}`, `fov=${fov}`);
  }
  return parts.length ? `#${parts.join('&')}` : '';
}
