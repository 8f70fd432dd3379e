// The npm package in node: the same pixels as native, errors that say where, nothing that panics.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { WALLS, demoHash, hash, target } from './setup.mjs';

let voxdag;
const nothing = () => {};

before(async () => {
  voxdag = await import(join(target, 'npm/voxdag.js'));
  voxdag.initSync({ module: readFileSync(join(target, 'npm/voxdag_bg.wasm')) });
});

const filesOf = (entries) => {
  const files = new voxdag.Files();
  for (const [name, content] of Object.entries(entries)) files.add(name, Buffer.from(content));
  return files;
};
const viewerOf = (files, resolution) => new voxdag.Viewer(voxdag.build(files, resolution, 'y', nothing).takeWords());

test("the demo's picture is the native one", () => {
  const progress = [];
  const built = voxdag.build(voxdag.Files.demo(), 1024, 'y', (...step) => progress.push(step));
  assert.equal(built.triangles, 57644);
  assert.deepEqual(progress.at(-1), [progress.length, progress.length]);
  const viewer = new voxdag.Viewer(built.takeWords());
  const settings = new voxdag.Settings(1280, 720);
  settings.samples = 4;
  settings.addDemoLights();
  const picture = Buffer.alloc(1280 * 720 * 4);
  // Backwards, in bands that do not fit the tiles.
  for (let to = 720; to > 0; to -= 50) {
    const from = Math.max(0, to - 50);
    picture.set(viewer.renderRows(voxdag.Camera.demo(), settings, from, to), from * 1280 * 4);
  }
  assert.equal(hash(picture), demoHash());
  assert.ok(viewer.rays >= 4 * 1280 * 720);
});

test('what a renderer sees', () => {
  const viewer = viewerOf(filesOf(WALLS), 64);
  const settings = new voxdag.Settings(40, 30);
  const { camera } = viewer;
  for (const what of ['normals', 'depth', 'level', 'iterations', 'material']) {
    const words = viewer.showRows(camera, settings, what, 0, 30);
    const range = viewer.range(what, words);
    assert.equal(range === undefined, ['normals', 'material'].includes(what), what);
    const pixels = viewer.paint(what, words, ...(range ?? [0, 0]));
    assert.equal(pixels.length, 40 * 30 * 4);
    assert.ok(new Set(new Uint32Array(pixels.buffer)).size > 1, what);
  }
  const hit = viewer.pick(camera, settings, 20, 15);
  assert.deepEqual([hit.material, hit.voxel.length], ['red', 3]);
  assert.equal(viewer.pick(camera, settings, 0.5, 0.5), undefined);
  // Where the ray goes on from the eye by this distance.
  const way = hit.position.map((x, i) => x - camera.eye[i]);
  assert.ok(Math.abs(Math.hypot(...way) - hit.distance) < 1e-9);
});

test('a saved scene is the scene', () => {
  const viewer = viewerOf(filesOf(WALLS), 50);
  const bytes = viewer.save();
  const again = voxdag.build(filesOf({ 'a.vxd': bytes }), 7, 'z', nothing);
  assert.equal(again.triangles, undefined);
  assert.deepEqual(new voxdag.Viewer(again.takeWords()).save(), bytes);
  const { resolution, voxels, dagBytes, fileBytes, materials } = viewer.stats();
  assert.deepEqual([resolution, fileBytes, materials], [50, bytes.length, 2]);
  assert.ok(voxels > 4000 && dagBytes < fileBytes);
});

test('errors say what is wrong and where', () => {
  const { Camera, Files, Settings, Viewer, build } = voxdag;
  const bytes = viewerOf(filesOf(WALLS), 20).save();
  const changed = bytes.slice();
  changed[200] ^= 1;
  const viewer = viewerOf(filesOf(WALLS), 20);
  const { camera } = viewer;
  const settings = (change) => Object.assign(new Settings(8, 8), change);
  for (const [action, text] of [
    [() => build(new Files(), 64, 'y', nothing), /expected a mesh/],
    [() => build(filesOf({ 'a.txt': 'x' }), 64, 'y', nothing), /^a\.txt: expected a mesh \(\.obj\)/],
    [() => build(filesOf({ 'a.obj': 'v 0 0 0\nv 1 0 0\nf 1 2 9\n' }), 64, 'y', nothing), /^a\.obj:3: /],
    [() => build(filesOf({ 'a.obj': 'v 0 0 nan\n' }), 64, 'y', nothing), /^a\.obj:1: /],
    [() => build(filesOf({ 'a.obj': '' }), 64, 'y', nothing), /^a\.obj: .*no triangles/],
    [() => build(filesOf(WALLS), 0, 'y', nothing), /resolution 0/],
    [() => build(filesOf(WALLS), 64, 'x', nothing), /up axis/],
    [() => build(filesOf({ 'a.vxd': 'text' }), 64, 'y', nothing), /^a\.vxd: /],
    [() => build(filesOf({ 'a.vxd': bytes.slice(0, 101) }), 64, 'y', nothing), /^a\.vxd: /],
    [() => build(filesOf({ 'a.vxd': changed }), 64, 'y', nothing), /^a\.vxd: .*checksum/i],
    [() => new Viewer(new Uint32Array(99)), /./],
    [() => new Camera([0, 0], [1, 1, 1], [0, 1, 0], 45), /the eye has 2 numbers/],
    [() => new Camera([0, 0, 0], [0, 0, 0], [0, 1, 0], 45), /same point/],
    [() => new Camera([0, NaN, 0], [1, 0, 0], [0, 1, 0], 45), /finite/],
    [() => settings({ samples: 3 }), /1, 4, 5, 16 or 64/],
    [() => settings({ normals: 'x' }), /plane2/],
    [() => settings({ supersample: '' }), /adaptive/],
    [() => settings({ effects: ['shadow'] }), /shadows/],
    [() => viewer.renderRows(camera, settings(), 4, 9), /rows 4 to 9/],
    [() => viewer.renderRows(camera, settings(), 4, 3), /rows 4 to 3/],
    [() => viewer.renderRows(camera, new Settings(4e9, 4e9), 0, 4e9), /memory|out of range/],
    [() => viewer.showRows(camera, settings(), 'all', 0, 8), /iterations/],
  ]) {
    assert.throws(action, (error) => error instanceof Error && !(error instanceof WebAssembly.RuntimeError) && text.test(error.message), `${action}`);
  }
  // A picture after all that.
  assert.equal(viewer.renderRows(camera, settings(), 0, 8).length, 256);
});

test('textures are given as pixels', () => {
  const build = (files) => {
    const built = voxdag.build(files, 64, 'y', nothing);
    return [new voxdag.Viewer(built.takeWords()), built.warnings.join('\n')];
  };
  const [grey, warned] = build(filesOf(WALLS));
  assert.match(warned, /checks\.png.*not decoded/);
  const files = filesOf(WALLS);
  files.addPicture('checks.png', 2, 2, new Uint8Array([255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255]));
  const [textured, silent] = build(files);
  assert.equal(silent, '');
  const picture = (viewer) => hash(viewer.renderRows(viewer.camera, new voxdag.Settings(40, 30), 0, 30));
  assert.notEqual(picture(textured), picture(grey));
  files.addPicture('checks.png', 2, 2, new Uint8Array(3));
  assert.match(build(files)[1], /0 pixels/);
});

test('a texture that no voxel shows leaves none', () => {
  const files = filesOf({
    'a.obj': 'mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl hole\nf 1/1 2/2 3/3\n',
    'a.mtl': 'newmtl hole\nmap_Kd white.png\nmap_d black.png\n',
  });
  files.addPicture('white.png', 1, 1, new Uint8Array(4).fill(255));
  files.addPicture('black.png', 1, 1, new Uint8Array([0, 0, 0, 255]));
  const viewer = viewerOf(files, 16);
  assert.equal(viewer.stats().voxels, 0);
  assert.equal(viewer.renderRows(viewer.camera, new voxdag.Settings(8, 8), 0, 8).length, 256);
});

test('a missing library is a warning', () => {
  const built = voxdag.build(filesOf({ 'walls.obj': WALLS['walls.obj'] }), 20, 'y', nothing);
  assert.match(built.warnings.join('\n'), /^walls\.obj:1: .*walls\.mtl/m);
});
