// What the tests share: where things are, a server for the page, a browser whose pages may not complain.

import { spawn } from 'node:child_process';
import { createHash } from 'node:crypto';
import { mkdirSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import { PNG } from 'pngjs';

export const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
export const target = process.env.CARGO_TARGET_DIR ?? join(root, 'target');
export const shots = join(target, 'screenshots');
mkdirSync(shots, { recursive: true });

// The hash of RGBA pixels.
export const hash = (pixels) => createHash('sha256').update(pixels).digest('hex');
export const hashOfPng = (bytes) => hash(PNG.sync.read(bytes).data);
export const demoHash = () => hashOfPng(readFileSync(join(root, 'docs/demo.png')));

// Starts a program that prints an address and serves it.
export async function serve(program, ...args) {
  const child = spawn(join(target, 'release', program), args, { stdio: ['ignore', 'pipe', 'inherit'] });
  const url = await new Promise((resolve, reject) => {
    let text = '';
    child.stdout.on('data', (data) => {
      text += data;
      if (text.includes('\n')) resolve(text.trim());
    });
    child.on('exit', (code) => reject(new Error(`${program} ended with ${code}`)));
  });
  return { url, end: () => child.kill() };
}

const program = { executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox'] };

export const launch = () => chromium.launch(program);

// A browser whose process is known.
export const launchServer = () => chromium.launchServer(program);

// A page, and what it complained about.
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 900, height: 560 }, acceptDownloads: true, ...options });
  await context.grantPermissions(['clipboard-read', 'clipboard-write']);
  const page = await context.newPage();
  const complaints = [];
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && complaints.push(message.text()));
  page.on('pageerror', (error) => complaints.push(error.stack));
  page.setDefaultTimeout(60_000);
  await page.goto(url);
  return { page, context, complaints };
}

// Waits until the picture is as good as it gets.
export const rested = (page) => page.waitForSelector('#picture[data-state=rested]');

// The hash of what the canvas shows.
export const shown = (page) => page.evaluate(async () => {
  const canvas = document.getElementById('picture');
  // From a copy: reading the canvas itself would slow it down, and the browser says so.
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  const digest = await crypto.subtle.digest('SHA-256', data);
  return [...new Uint8Array(digest)].map((byte) => byte.toString(16).padStart(2, '0')).join('');
});

// Drops files, {name: text or bytes}, on the page.
export const drop = (page, files) => page.evaluate((files) => {
  const dataTransfer = new DataTransfer();
  for (const [name, content] of files) dataTransfer.items.add(new File([new Uint8Array(content)], name));
  for (const kind of ['dragenter', 'dragover', 'drop']) {
    document.body.dispatchEvent(new DragEvent(kind, { dataTransfer, bubbles: true, cancelable: true }));
  }
}, Object.entries(files).map(([name, content]) => [name, [...Buffer.from(content)]]));

// Two walls of a red and a green material at right angles.
export const WALLS = {
  'walls.obj': `mtllib walls.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 0 1 1
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
usemtl red\nf 1/1 2/2 3/3 4/4
usemtl green\nf 1/1 4/4 6/3 5/2\n`,
  'walls.mtl': 'newmtl red\nKd 0.8 0.1 0.1\nmap_Kd checks.png\nnewmtl green\nKd 0.1 0.8 0.1\n',
  'checks.png': texture(),
};

// Black and white checks.
function texture() {
  const png = new PNG({ width: 8, height: 8 });
  for (let i = 0; i < 64; i++) png.data.fill((i + (i >> 3)) % 2 ? 255 : 0, 4 * i, 4 * i + 3).fill(255, 4 * i + 3, 4 * i + 4);
  return PNG.sync.write(png);
}
