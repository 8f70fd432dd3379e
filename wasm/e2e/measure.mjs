// The figures of docs/browser.md: node measure.mjs BUNNY.obj, after `cargo web build` and a release build of voxdag.

import { execFileSync } from 'node:child_process';
import { readFileSync, statSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { chromium } from 'playwright-core';
import { launchServer, open, rested, serve, target } from './setup.mjs';

const bunny = process.argv[2];
const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];
const line = (name, value, bound) => console.log(`${name.padEnd(58)} ${value.padStart(12)}   ${bound}`);

// Before whatever else the machine does, where Linux and root can say so: a process and all that it started.
function first(pid) {
  try {
    writeFileSync(`/proc/${pid}/autogroup`, '-19');
    const started = readFileSync(`/proc/${pid}/task/${pid}/children`, 'utf8');
    started.split(' ').filter(Boolean).forEach(first);
  } catch {}
}
const [site, server] = await Promise.all([serve('voxdag-web', 'serve', '0'), launchServer()]);
first(process.pid);
const browser = await chromium.connect(server.wsEndpoint());

// A page, before whatever else.
async function visit(url) {
  const visited = await open(browser, url);
  first(server.process().pid);
  return visited;
}

// One thread each, in turn: the same picture, 4 rays per pixel.
async function alone(name, obj) {
  const { page, context } = await visit(`${site.url}pkg/voxdag.js`);
  const words = await page.evaluate(async (obj) => {
    const voxdag = await import('/pkg/voxdag.js');
    await voxdag.default();
    const files = obj ? new voxdag.Files() : voxdag.Files.demo();
    if (obj) files.add('mesh.obj', new Uint8Array(await (await fetch(`data:;base64,${obj}`)).arrayBuffer()));
    const viewer = new voxdag.Viewer(voxdag.build(files, 1024, 'y', () => {}).takeWords());
    const settings = new voxdag.Settings(1280, 720);
    settings.samples = 4;
    globalThis.frame = () => {
      const start = performance.now();
      for (let y = 0; y < 720; y += 8) viewer.renderRows(viewer.camera, settings, y, y + 8);
      return performance.now() - start;
    };
    return [...new Uint32Array(viewer.save().buffer)];
  }, obj);
  const file = join(target, 'measured.vxd');
  writeFileSync(file, new Uint8Array(new Uint32Array(words).buffer));
  const render = ['render', file, '-o', join(target, 'measured.png'), '--threads', '1', '--json'];
  const times = [[], []];
  for (let i = 0; i < 9; i++) {
    const report = execFileSync(join(target, 'release/voxdag'), render, { stdio: ['ignore', 'pipe', 'ignore'] });
    times[0].push(JSON.parse(report).ms.trace);
    times[1].push(await page.evaluate(() => frame()));
  }
  const [native, ours] = times.map(median);
  line(`wasm against native, ${name}`, `${(ours / native).toFixed(2)} x`, `${ours.toFixed(0)} and ${native.toFixed(0)} ms; at most 2.2`);
  await context.close();
}
await alone('demo');
await alone('bunny', readFileSync(bunny).toString('base64'));

// The page.
const view = 'size=1280x720&rest=4';
const last = (page, name) => page.evaluate((name) => performance.getEntriesByName(name).at(-1)?.startTime, name);
const frame = (page) => page.evaluate(() => performance.getEntriesByName('4 rays', 'measure').at(-1).duration);

const pages = [];
for (const n of [1, 2]) {
  pages.push(await visit(`${site.url}?workers=${n}#${view}`));
  await rested(pages.at(-1).page);
}
const frames = [[], []];
for (let i = 0; i < 7; i++) {
  for (const [k, { page }] of pages.entries()) {
    await page.selectOption('[name=rest]', '1');
    await rested(page);
    await page.selectOption('[name=rest]', '4');
    await rested(page);
    frames[k].push(await frame(page));
  }
}
const [one, two] = frames.map(median);
line('two workers against one, demo', `${(one / two).toFixed(2)} x`, `${one.toFixed(0)} and ${two.toFixed(0)} ms; at least 1.6`);
await Promise.all(pages.map(({ context }) => context.close()));

line('wasm module', `${(statSync(join(target, 'www/pkg/voxdag_bg.wasm')).size / 1000).toFixed(0)} kB`, 'at most 900');

const firsts = [];
for (let i = 0; i < 5; i++) {
  const { page, context } = await visit(`${site.url}?workers=2#${view}`);
  await rested(page);
  firsts.push(await last(page, 'picture'));
  await context.close();
}
line('first picture of the demo after the page is asked for', `${(median(firsts) / 1000).toFixed(2)} s`, 'at most 3');

for (const resolution of [512, 1024]) {
  const { page, context } = await visit(`${site.url}?workers=2#resolution=${resolution}&${view}`);
  await rested(page);
  await page.setInputFiles('#files', bunny);
  await page.getByText(basename(bunny), { exact: true }).waitFor();
  await rested(page);
  const ms = (await last(page, 'picture')) - (await last(page, 'open'));
  line(`bunny at ${resolution}^3, from OBJ to first picture`, `${(ms / 1000).toFixed(2)} s`, resolution === 512 ? 'at most 5' : '');
  const memory = await page.evaluate(() => [...document.querySelectorAll('#stats dt')].find((dt) => dt.textContent === 'Memory').nextSibling.textContent);
  line('  memory of the workers', memory, resolution === 1024 ? 'at most 512 MiB' : '');
  await context.close();
}
await server.close();
site.end();
