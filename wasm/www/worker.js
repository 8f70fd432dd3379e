// One wasm instance. Jobs come as messages and are answered in order: {id, result} or {id, error}.

import { Camera, Files, Settings, Viewer, build, initSync, rmse } from './pkg/voxdag.js';

let wasm, viewer;

const jobs = {
  init({ module }) {
    wasm = initSync({ module });
  },

  // Files become the words of a scene. Progress is told as {progress: [done, total]}.
  async build({ files, resolution, up }) {
    const start = performance.now();
    const all = files ? new Files() : Files.demo();
    for (const { name, bytes } of files ?? []) all.add(name, bytes);
    for (const { name, bytes } of named(files ?? [])) await addPicture(all, name, bytes);
    files = undefined;
    const name = all.main.split('/').pop();
    const built = build(all, resolution, up, (done, total) => postMessage({ progress: [done, total] }));
    all.free();
    const { triangles, warnings } = built;
    const words = built.takeWords();
    built.free();
    const memory = wasm.memory.buffer.byteLength;
    return [{ name, words, triangles, warnings, memory, ms: performance.now() - start }, [words.buffer]];
  },

  load({ words }) {
    const next = new Viewer(words);
    viewer?.free();
    viewer = next;
    const { effects, hasNormals } = viewer;
    return [{ effects, hasNormals, camera: plain(viewer.camera) }];
  },

  demoCamera: () => [plain(Camera.demo())],

  stats() {
    const { resolution, voxels, dagBytes, fileBytes, materials, radius } = viewer.stats();
    return [{ resolution, voxels, dagBytes, fileBytes, materials, radius }];
  },

  rows({ camera, settings, from, to }) {
    const before = viewer.rays;
    const pixels = withView(camera, settings, (c, s) => viewer.renderRows(c, s, from, to));
    return [{ pixels, rays: viewer.rays - before }, [pixels.buffer]];
  },

  // What a renderer sees: numbers first, whose range the page collects, then colours.
  look({ camera, settings, from, to }) {
    const words = withView(camera, settings, (c, s) => viewer.showRows(c, s, settings.show, from, to));
    const range = viewer.range(settings.show, words);
    return [{ words, range, rays: (to - from) * settings.width }, [words.buffer]];
  },

  paint({ settings, words, range }) {
    const pixels = viewer.paint(settings.show, words, ...range);
    return [{ pixels, rays: 0 }, [pixels.buffer]];
  },

  pick({ camera, settings, x, y }) {
    const hit = withView(camera, settings, (c, s) => viewer.pick(c, s, x, y));
    if (!hit) return [null];
    const { voxel, position, normal, material, distance } = hit;
    hit.free();
    return [{ voxel: [...voxel], position: [...position], normal: [...normal], material, distance }];
  },

  rmse: ({ reference, picture }) => [rmse(reference, picture)],

  save() {
    const bytes = viewer.save();
    return [bytes, [bytes.buffer]];
  },

  memory: () => [wasm.memory.buffer.byteLength],
};

onmessage = async ({ data: { id, job, ...input } }) => {
  try {
    const [result, transfer] = (await jobs[job](input)) ?? [];
    postMessage({ id, result }, transfer ?? []);
  } catch (error) {
    postMessage({ id, error: error.message, fatal: error instanceof WebAssembly.RuntimeError });
  }
};

const plain = ({ eye, target, up, fov }) => ({ eye: [...eye], target: [...target], up: [...up], fov });

// The pictures that materials may name.
function named(files) {
  const isLibrary = ({ name }) => /\.mtl$/i.test(name);
  const text = files.filter(isLibrary).map(({ bytes }) => new TextDecoder().decode(bytes)).join('\n').toLowerCase();
  const isNamed = ({ name }) => text.includes(name.split('/').pop().toLowerCase());
  return files.filter((file) => /\.(png|jpe?g|bmp|gif|webp|avif)$/i.test(file.name) && isNamed(file));
}

// Lets the browser decode a picture; one that it cannot decode, perhaps for its size, stays as it is and becomes a warning.
async function addPicture(files, name, bytes) {
  const options = { premultiplyAlpha: 'none', colorSpaceConversion: 'none' };
  let decoded;
  try {
    const bitmap = await createImageBitmap(new Blob([bytes]), options);
    const { width, height } = bitmap;
    const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
    context.drawImage(bitmap, 0, 0);
    bitmap.close();
    decoded = context.getImageData(0, 0, width, height);
  } catch {
    return;
  }
  files.addPicture(name, decoded.width, decoded.height, new Uint8Array(decoded.data.buffer));
}

// Lends the camera and the settings of a message to `use`.
function withView({ eye, target, up, fov }, wanted, use) {
  const camera = new Camera(eye, target, up, fov);
  const settings = new Settings(wanted.width, wanted.height);
  try {
    settings.samples = wanted.samples;
    settings.supersample = wanted.supersample;
    settings.markSupersampled = wanted.show === 'samples';
    settings.normals = wanted.normals;
    settings.effects = wanted.effects;
    settings.shadows = wanted.effects.includes('shadows');
    if (wanted.sun) {
      settings.addSun(wanted.sun, [1, 1, 1]);
      settings.ambient = [wanted.ambient, wanted.ambient, wanted.ambient];
    } else if (wanted.demo) {
      settings.addDemoLights();
    }
    return use(camera, settings);
  } finally {
    camera.free();
    settings.free();
  }
}
