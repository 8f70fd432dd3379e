// The page in a real browser.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { WALLS, demoHash, drop, hashOfPng, launch, open, rested, serve, shots, shown, target } from './setup.mjs';

let site, browser;
const complaints = [];
// Small pictures of few rays: the browser has the machine's cores only.
const QUICK = 'resolution=128&rest=1&size=320x240';

before(async () => {
  [site, browser] = await Promise.all([serve('voxdag-web', 'serve', '0'), launch()]);
});

after(async () => {
  await browser?.close();
  site?.end();
});

async function visit(hash, options) {
  const visited = await open(browser, `${site.url}${hash ? `#${hash}` : ''}`, options);
  complaints.push(visited.complaints);
  return visited;
}

const text = (page, id) => page.locator(`#${id}`).innerText();
const canvas = (page) => page.locator('#picture');

// Does something that changes the picture, and waits for the next one at rest.
async function change(page, action) {
  await rested(page);
  const before = await canvas(page).getAttribute('data-frames');
  await action();
  await page.waitForFunction((before) => {
    const { state, frames } = document.getElementById('picture').dataset;
    return state === 'rested' && frames !== before;
  }, before);
}

async function drag(page, way, options = {}) {
  const { x, y, width, height } = await canvas(page).boundingBox();
  const [cx, cy] = [x + width / 2, y + height / 2];
  await page.mouse.move(cx, cy);
  await page.mouse.down(options);
  for (let i = 1; i <= 4; i++) await page.mouse.move(cx + (way[0] * i) / 4, cy + (way[1] * i) / 4);
  await page.mouse.up(options);
}

test('the first picture is the native one, and comes soon', async () => {
  const { page, context } = await visit('size=1280x720&rest=4');
  await page.waitForFunction(() => performance.getEntriesByName('picture').length);
  const ms = await page.evaluate(() => performance.getEntriesByName('picture')[0].startTime);
  await rested(page);
  assert.equal(await shown(page), demoHash());
  assert.match(await text(page, 'stats'), /57.644[\s\S]*Bits per voxel/);
  await page.screenshot({ path: join(shots, 'demo.png') });
  console.log(`first picture after ${Math.round(ms)} ms`);
  await context.close();
});

test('dragging, wheel and keys move the camera', async () => {
  const { page, context } = await visit(QUICK);
  await rested(page);
  const pictures = [await shown(page)];
  const eye = () => page.evaluate(() => new URLSearchParams(location.hash.slice(1)).get('eye'));
  const target = () => page.evaluate(() => new URLSearchParams(location.hash.slice(1)).get('target'));
  assert.equal(await eye(), null);
  for (const action of [
    () => drag(page, [60, 20]),
    () => drag(page, [30, 30], { button: 'right' }),
    () => page.mouse.wheel(0, 200),
    () => page.keyboard.press('ArrowLeft'),
    () => page.keyboard.press('Shift+ArrowUp'),
    () => page.keyboard.press('+'),
  ]) {
    await change(page, action);
    pictures.push(await shown(page));
  }
  assert.equal(new Set(pictures).size, pictures.length, 'each changes the picture');
  assert.ok(await eye());
  // A double click looks there.
  const before = await target();
  await change(page, () => canvas(page).dblclick({ position: { x: 100, y: 150 } }));
  assert.notEqual(await target(), before);
  await change(page, () => page.keyboard.press('Home'));
  assert.equal(await shown(page), pictures[0]);
  assert.equal(await eye(), null);
  await context.close();
});

test('the menu takes keys alone', async () => {
  const { page, context } = await visit(QUICK);
  await rested(page);
  const menu = page.getByText('Save', { exact: true });
  await menu.press('Enter');
  await page.keyboard.press('Tab');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'save-png');
  await page.keyboard.press('Escape');
  assert.ok(await page.locator('#save-png').isHidden());
  assert.ok(await menu.evaluate((summary) => summary === document.activeElement));
  await context.close();
});

test('every control changes the picture', async () => {
  const { page, context } = await visit(QUICK);
  await rested(page);
  const pictures = new Set([await shown(page)]);
  for (const [name, value] of [
    ['normals', 'face'], ['rest', '4'], ['rest', '16-adaptive'], ['show', 'samples'], ['show', 'normals'], ['show', 'depth'],
    ['show', 'level'], ['show', 'iterations'], ['show', 'material'], ['show', 'shaded'], ['resolution', '64'],
  ]) {
    if (value === 'shaded') await change(page, () => page.selectOption('[name=normals]', 'gradient'));
    await change(page, () => page.selectOption(`[name=${name}]`, value));
    const picture = await shown(page);
    assert.ok(!pictures.has(picture), `${name}=${value}`);
    pictures.add(picture);
  }
  for (const action of [
    () => page.getByLabel('Highlights').uncheck(),
    () => page.getByRole('radio', { name: 'Sun' }).check(),
    () => page.getByLabel('Shadows').check(),
    () => page.locator('[name=azimuth]').fill('-60'),
    () => page.locator('[name=ambient]').fill('0.8'),
  ]) {
    await change(page, action);
    const picture = await shown(page);
    assert.ok(!pictures.has(picture), `${action}`);
    pictures.add(picture);
  }
  assert.ok(await page.getByLabel('Mirrors').isHidden(), 'the demo has no mirrors');
  await context.close();
});

test('what accuracy costs', async () => {
  const { page, context } = await visit('resolution=128&rest=16&size=320x240');
  await page.locator('#accuracy .reference').waitFor();
  // Coarse, 1, 4, 16.
  await page.waitForFunction(() => document.querySelectorAll('#accuracy tbody tr').length === 4);
  const rows = await page.locator('#accuracy tbody tr').allInnerTexts();
  const errors = rows.filter((row) => !row.includes('reference')).map((row) => +row.split('\t').at(-1));
  assert.ok(errors.every((error) => error > 0 && error < 0.5), `${rows}`);
  assert.equal(await page.locator('#accuracy circle').count(), 4);
  assert.equal(await page.locator('#accuracy .front').count(), 1);
  // Other normals: more points, against the same reference.
  await change(page, () => page.selectOption('[name=normals]', 'face'));
  await page.waitForFunction(() => document.querySelectorAll('#accuracy tbody tr').length >= 7);
  assert.equal(await page.locator('#accuracy .reference').count(), 1);
  await page.locator('#more').click();
  await page.waitForFunction(() => document.querySelectorAll('#accuracy tbody tr').length >= 12);
  await page.getByText('Try more').waitFor();
  await page.locator('#accuracy').scrollIntoViewIfNeeded();
  await page.screenshot({ path: join(shots, 'accuracy.png') });
  await context.close();
});

test('a mesh with its materials and a texture is dropped', async () => {
  const { page, context } = await visit(QUICK);
  await change(page, () => drop(page, WALLS));
  assert.equal(await text(page, 'scene-name'), 'walls.obj');
  assert.match(await text(page, 'stats'), /Triangles\s+4/);
  await canvas(page).click({ position: { x: 160, y: 120 } });
  await page.getByText('Material', { exact: true }).waitFor();
  assert.match(await text(page, 'pick'), /Voxel\s+\d+, \d+, \d+[\s\S]*Position[\s\S]*Normal\s+1\.000, 0\.000, 0\.000\s+Material\s+green/);
  await page.screenshot({ path: join(shots, 'walls.png') });
  // The texture is there, and the same as native.
  await page.keyboard.press('Escape');
  assert.ok(await page.getByRole('checkbox', { name: 'Textures' }).isChecked());
  const folder = mkdtempSync(join(tmpdir(), 'voxdag-e2e-'));
  for (const [name, content] of Object.entries(WALLS)) writeFileSync(join(folder, name), content);
  const native = join(folder, 'native.png');
  execFileSync(join(target, 'release/voxdag'), ['render', join(folder, 'walls.obj'), '-o', native, '-r', '128', '--size', '320x240', '--samples', '1'], { stdio: 'pipe' });
  assert.equal(await shown(page), hashOfPng(readFileSync(native)));
  const textured = await shown(page);
  await change(page, () => page.getByRole('checkbox', { name: 'Textures' }).uncheck());
  assert.notEqual(await shown(page), textured);
  await change(page, () => page.getByRole('checkbox', { name: 'Textures' }).check());
  // Without its library it is grey, and the page says so.
  await change(page, () => drop(page, { 'walls.obj': WALLS['walls.obj'] }));
  assert.match(await text(page, 'warnings'), /warning/);
  await context.close();
});

test('a broken mesh says where, and the page lives on', async () => {
  const { page, context } = await visit(QUICK);
  await rested(page);
  const picture = await shown(page);
  await drop(page, { 'broken.obj': 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n' });
  await page.locator('#error').waitFor();
  assert.match(await text(page, 'error-text'), /^broken\.obj:4: /);
  await page.screenshot({ path: join(shots, 'error.png') });
  assert.equal(await shown(page), picture);
  await drop(page, { 'notes.txt': 'x' });
  await page.getByText('notes.txt: expected a mesh').waitFor();
  await page.getByLabel('Close').click();
  assert.ok(await page.locator('#error').isHidden());
  await change(page, () => drag(page, [40, 0]));
  assert.notEqual(await shown(page), picture);
  await change(page, () => drop(page, WALLS));
  assert.equal(await text(page, 'scene-name'), 'walls.obj');
  await context.close();
});

test('a link to a scene that is not there says so, over the demo', async () => {
  const { page, context } = await open(browser, `${site.url}#scene=nothing.vxd&${QUICK}`);
  await rested(page);
  assert.match(await text(page, 'error-text'), /nothing\.vxd: 404/);
  assert.equal(await text(page, 'scene-name'), 'Demo scene');
  await context.close();
});

test('building can be cancelled', async () => {
  const { page, context } = await visit(QUICK);
  await rested(page);
  await page.selectOption('[name=resolution]', '4096');
  await page.locator('#cancel').click();
  await page.locator('#progress').waitFor({ state: 'hidden' });
  assert.equal(await page.inputValue('[name=resolution]'), '128');
  await change(page, () => drag(page, [40, 0]));
  await context.close();
});

test('cancelling leaves the settings of the scene that is shown', async () => {
  const { page, context } = await visit(QUICK);
  await rested(page);
  await page.selectOption('[name=resolution]', '4096');
  await page.selectOption('[name=up]', 'z');
  await page.locator('#cancel').click();
  await page.locator('#progress').waitFor({ state: 'hidden' });
  assert.deepEqual([await page.inputValue('[name=resolution]'), await page.inputValue('[name=up]')], ['128', 'y']);
  await context.close();
});

test('of files opened one upon the other the last is shown', async () => {
  const { page, context } = await visit(QUICK);
  await change(page, () => drop(page, WALLS));
  const picture = await shown(page);
  for (let i = 0; i < 3; i++) await drop(page, i === 1 ? { 'other.obj': 'v 0 0 0\nv 3 0 0\nv 0 1 2\nf 1 2 3\n' } : WALLS);
  await page.locator('#progress').waitFor({ state: 'hidden' });
  await rested(page);
  assert.equal(await text(page, 'scene-name'), 'walls.obj');
  assert.match(await text(page, 'stats'), /Triangles\s+4/);
  assert.equal(await shown(page), picture);
  await context.close();
});

test('the name is that of the mesh that was built', async () => {
  const { page, context } = await visit(QUICK);
  await change(page, () => drop(page, { 'a.obj': 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n', ...WALLS }));
  assert.match(await text(page, 'stats'), /Triangles\s+4/);
  assert.equal(await text(page, 'scene-name'), 'walls.obj');
  await context.close();
});

test('what makes no sense in a link is left out', async () => {
  const here = 'eye=0,0,0&target=0,0,0&view-up=0,1,0&fov=60';
  const nonsense = [
    'up=x', 'light=x', 'effects=x', 'show=x', 'normals=plane9', 'azimuth=1e999', 'elevation=', 'ambient=-1', 'rest=x', 'rest=7',
    'rest=16-x', 'size=0x0', 'size=99999x99999', 'resolution=0', 'resolution=-5', 'resolution=1.5', 'resolution=1e9', '=', '%',
    here, here.replace('eye=0', 'eye=1e300'), here.replace('eye=0', 'eye=x'), here.replace('eye=0', 'eye=5').replace('fov=60', 'fov=180'),
  ];
  const { page, context, complaints: said } = await open(browser, `${site.url}?workers=-1#${nonsense.join('&')}`);
  complaints.push(said);
  const states = await page.evaluate(async (hashes) => {
    const { fromHash } = await import('./state.js');
    return hashes.map(fromHash);
  }, ['', ...nonsense]);
  for (const [i, state] of states.slice(1).entries()) assert.deepEqual(state, states[0], nonsense[i]);
  await page.waitForSelector('#picture[data-pass]');
  assert.ok(await page.locator('#error').isHidden());
  assert.equal(await page.inputValue('[name=resolution]'), '1024');
  await context.close();
});

test('a resolution that is chosen while a file is opened is meant for it', async () => {
  const { page, context } = await visit(QUICK);
  await change(page, async () => {
    await page.evaluate(() => new MutationObserver((_, observer) => {
      observer.disconnect();
      const { resolution } = document.forms.settings.elements;
      resolution.value = '64';
      resolution.dispatchEvent(new Event('input', { bubbles: true }));
    }).observe(document.getElementById('progress'), { attributes: true }));
    await drop(page, WALLS);
  });
  assert.equal(await text(page, 'scene-name'), 'walls.obj');
  assert.match(await text(page, 'stats'), /Resolution\s+64/);
  await context.close();
});

test('a file has a resolution and an up axis, which the next mesh does not take over', async () => {
  const [mesh, file] = ['walls.obj', 'walls.vxd'].map((name) => join(mkdtempSync(join(tmpdir(), 'voxdag-e2e-')), name));
  writeFileSync(mesh, WALLS['walls.obj']);
  execFileSync(join(target, 'release/voxdag'), ['build', mesh, '-o', file, '-r', '64', '--up-axis', 'z'], { stdio: 'pipe' });
  const { page, context } = await visit(QUICK);
  const chosen = async () => [await page.inputValue('[name=resolution]'), await page.inputValue('[name=up]')];
  await change(page, () => drop(page, { 'walls.vxd': readFileSync(file) }));
  assert.deepEqual(await chosen(), ['64', 'z']);
  await change(page, () => drop(page, WALLS));
  assert.deepEqual(await chosen(), ['128', 'y']);
  await context.close();
});

test('a scene that does not come can be cancelled', async () => {
  const { page, context } = await visit(QUICK);
  await rested(page);
  await page.route('**/slow.obj', () => {});
  await page.goto(`${site.url}?slow#scene=slow.obj&${QUICK}`);
  await page.locator('#cancel').click();
  await rested(page);
  assert.equal(await text(page, 'scene-name'), 'Demo scene');
  await context.close();
});

test('fingers orbit, pan and pinch', async () => {
  const { page, context } = await visit(QUICK.replace('320x240', 'fit'), {
    hasTouch: true, isMobile: true, viewport: { width: 390, height: 844 }, deviceScaleFactor: 1,
  });
  await rested(page);
  const wire = await context.newCDPSession(page);
  const touch = (type, ...points) => wire.send('Input.dispatchTouchEvent', {
    type, touchPoints: points.map(([x, y], id) => ({ x, y, id })),
  });
  const pictures = [await shown(page)];
  await change(page, async () => {
    await touch('touchStart', [200, 200]);
    for (let i = 1; i <= 4; i++) await touch('touchMove', [200 + 15 * i, 200]);
    await touch('touchEnd');
  });
  pictures.push(await shown(page));
  await change(page, async () => {
    await touch('touchStart', [150, 250], [250, 250]);
    for (let i = 1; i <= 4; i++) await touch('touchMove', [150 - 10 * i, 250 + 5 * i], [250 + 10 * i, 250 + 5 * i]);
    await touch('touchEnd');
  });
  pictures.push(await shown(page));
  assert.equal(new Set(pictures).size, 3);
  await page.touchscreen.tap(200, 250);
  await page.locator('#pick').waitFor();
  await page.screenshot({ path: join(shots, 'phone.png') });
  // The page itself has not moved, and nothing sticks out to the side.
  const overflow = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
  assert.deepEqual(overflow, [390, 844]);
  for (const name of ['resolution', 'effects', 'light']) await page.locator(`[name=${name}]`).first().scrollIntoViewIfNeeded();
  await page.locator('#accuracy').scrollIntoViewIfNeeded();
  await page.screenshot({ path: join(shots, 'phone-settings.png') });
  await context.close();
});

test('narrow, dark, large: nothing overlaps the picture or leaves the window', async () => {
  for (const [width, height, colorScheme] of [[320, 568, 'light'], [844, 390, 'dark'], [1600, 1000, 'dark']]) {
    const { page, context } = await visit(QUICK.replace('320x240', 'fit'), { viewport: { width, height }, colorScheme });
    await rested(page);
    const wide = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
    assert.deepEqual(wide, [width, height]);
    const box = await canvas(page).boundingBox();
    assert.ok(box.width >= 300 && box.height >= 200, `${width}x${height}: ${JSON.stringify(box)}`);
    await page.screenshot({ path: join(shots, `${width}x${height}.png`) });
    await context.close();
  }
});

test('picture, scene and link can be taken along', async () => {
  const { page, context } = await visit(QUICK);
  await change(page, () => drag(page, [50, 10]));
  const picture = await shown(page);
  const save = async (name) => {
    await page.getByText('Save', { exact: true }).click();
    const [download] = await Promise.all([page.waitForEvent('download'), page.getByText(name).click()]);
    return [download.suggestedFilename(), readFileSync(await download.path())];
  };
  const [pngName, png] = await save('Picture (.png)');
  assert.deepEqual([pngName, hashOfPng(png)], ['demo-scene.png', picture]);
  const [vxdName, vxd] = await save('Scene (.vxd)');
  assert.equal(vxdName, 'demo-scene.vxd');

  // The link shows the same picture to someone else.
  await page.getByText('Save', { exact: true }).click();
  await page.getByText('Copy link').click();
  await page.getByText('Link copied').waitFor();
  const link = await page.evaluate(() => navigator.clipboard.readText());
  const other = await open(browser, link);
  complaints.push(other.complaints);
  await rested(other.page);
  assert.equal(await shown(other.page), picture);
  await other.context.close();

  // The scene again, here, in the command line's page, and drawn by the command line.
  await change(page, () => drop(page, { 'saved.vxd': vxd }));
  assert.ok(await page.locator('[name=resolution]').isDisabled());
  await change(page, () => drag(page, [20, 5]));
  const again = await shown(page);
  const file = join(target, 'e2e-saved.vxd');
  writeFileSync(file, vxd);
  const view = await serve('voxdag', 'view', file, '--no-open');
  const hashOf = (url) => new URL(url).hash.slice(1);
  const elsewhere = await open(browser, `${view.url}&${hashOf(page.url())}`);
  complaints.push(elsewhere.complaints);
  await rested(elsewhere.page);
  assert.equal(await text(elsewhere.page, 'scene-name'), 'e2e-saved.vxd');
  assert.equal(await shown(elsewhere.page), again);
  await elsewhere.context.close();
  view.end();

  const said = new URLSearchParams(hashOf(page.url()));
  const camera = ['eye', 'target', 'view-up', 'fov'].map((name) => `--${name}=${said.get(name)}`);
  const native = (...flags) => {
    const picture = join(target, 'e2e-native.png');
    const args = ['render', file, '-o', picture, '--size', '320x240', ...camera, ...flags];
    execFileSync(join(target, 'release/voxdag'), args, { stdio: 'pipe' });
    return hashOfPng(readFileSync(picture));
  };
  assert.equal(again, native('--samples', '1'));
  for (const what of ['normals', 'depth', 'level', 'material']) {
    await change(page, () => page.selectOption('[name=show]', what));
    assert.equal(await shown(page), native('--show', what), what);
  }
  await context.close();
});

test('no page complained', () => {
  assert.deepEqual(complaints.flat(), []);
});
