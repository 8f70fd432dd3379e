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

const numbers = (text) => text.split(',').map(Number);
const isCamera = ({ eye, target, up, fov }) =>
  [eye, target, up].every((v) => v.length === 3 && v.every(Number.isFinite)) && fov > 0 && fov < 180;

// What a link says; what makes no sense is as in the beginning.
export function fromHash(hash) {
  const state = beginning();
  const said = new URLSearchParams(hash.replace(/^#/, ''));
  for (const name of Object.keys(BEGINNING)) {
    const value = said.get(name);
    if (value === null) continue;
    if (typeof BEGINNING[name] !== 'number') state[name] = value;
    else if (Number.isFinite(+value) && value !== '') state[name] = +value;
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
