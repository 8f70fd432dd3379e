// The picture on the canvas: coarse at once, refined while nothing changes, 16 rays per pixel in the end.
//
// A pass is a whole picture of some quality, drawn as bands of rows by whichever worker is free. A change starts a new
// generation: bands of the old one that wait are dropped, and what still comes of it is not shown. Only coarse passes are
// always finished, so that there is something to see while one drags; but of no scene that is there no longer.

import { DROPPED } from './pool.js';

// Milliseconds that nothing must have changed for before refining.
const REST = 120;
// Milliseconds that a coarse picture may take.
const COARSE = 40;

// The passes that lead to the quality chosen for the picture at rest, the coarse one left out.
function passes({ show, rest }) {
  const [samples, supersample = 'all'] = rest.split('-');
  if (show === 'samples') return [{ samples: 16, supersample: supersample === 'all' ? 'adaptive' : supersample }];
  const final = { samples: +samples, supersample };
  if (show !== 'shaded' || final.samples === 1) return [{ samples: 1, supersample: 'all' }];
  const steps = [1, 4].map((samples) => ({ samples, supersample: 'all' }));
  return final.samples === 4 ? steps : [...steps, final];
}

export class Picture {
  // `onpass` is told of each whole pass of a view: {view, pass, ms, rays, pixels, width, height}.
  constructor(canvas, pool, { onpass, onerror }) {
    this.canvas = canvas;
    this.context = canvas.getContext('2d', { alpha: false });
    this.scratch = document.createElement('canvas');
    this.pool = pool;
    this.onpass = onpass;
    this.onerror = onerror;
    this.generation = 0;
    // The first generation of the scene that workers hold.
    this.first = 0;
    this.changed = 0;
    this.view = null;
    // Milliseconds per ray of one sample, as last measured.
    this.pace = null;
  }

  // Shows a view from now on: {camera, settings, size}; null before workers take another scene.
  set(view) {
    this.view = view;
    this.generation++;
    if (!view) this.first = this.generation;
    this.changed = performance.now();
    this.pool.drop();
    this.canvas.dataset.state = 'drawing';
    if (!this.isRunning) this.run();
  }

  // Draws until nothing has changed since it began.
  async run() {
    this.isRunning = true;
    let generation, failure;
    while (generation !== this.generation) {
      generation = this.generation;
      failure = null;
      try {
        if (this.view) await this.refine(this.view, generation);
      } catch (error) {
        failure = error;
      }
    }
    this.isRunning = false;
    if (failure) this.onerror(failure);
    else if (this.view) this.canvas.dataset.state = 'rested';
  }

  // Draws one pass after the other until something changes.
  async refine(view, generation) {
    const coarse = await this.draw(view, { scale: this.coarseScale(view), samples: 1, supersample: 'all' }, generation);
    if (generation < this.first) return;
    this.present(coarse, view);
    this.onpass(coarse);
    await this.rest(generation);
    for (const pass of passes(view.settings)) {
      if (generation !== this.generation) return;
      const drawn = await this.draw(view, { scale: 1, ...pass }, generation);
      if (!drawn || generation !== this.generation) return;
      this.present(drawn, view);
      this.onpass(drawn);
    }
  }

  // Draws the view in other qualities, unseen, and tells `each` of it and of the share that is done; until something changes.
  async compare(qualities, each) {
    while (this.isRunning) await new Promise((resolve) => setTimeout(resolve, 50));
    const { view, generation } = this;
    for (const [i, { normals, ...pass }] of qualities.entries()) {
      if (!view || generation !== this.generation) return;
      const settings = { ...view.settings, show: 'shaded', normals };
      const drawn = await this.draw({ ...view, settings }, { scale: 1, ...pass }, null);
      if (drawn) await each(drawn, (i + 1) / qualities.length);
    }
  }

  // Waits until nothing has changed for a while, or something does.
  async rest(generation) {
    for (;;) {
      const left = this.changed + REST - performance.now();
      if (left <= 0 || generation !== this.generation) return;
      await new Promise((resolve) => setTimeout(resolve, left));
    }
  }

  // How many times narrower and lower a picture is that takes about COARSE.
  coarseScale({ size: [width, height] }) {
    const fits = (scale) => (width * height * this.pace) / scale ** 2 <= COARSE;
    return this.pace ? [2, 3, 4, 6].find(fits) ?? 8 : 4;
  }

  // Draws a pass; undefined if it was dropped.
  async draw(view, pass, generation) {
    const { camera, settings } = view;
    const [width, height] = view.size.map((side) => Math.ceil(side / pass.scale));
    const asked = { ...settings, ...pass, width, height };
    const isShaded = settings.show === 'shaded' || settings.show === 'samples';
    const kept = pass.scale > 1;
    const band = kept ? 12 : Math.max(4, Math.min(16, 4 * Math.round(8 / pass.samples)));
    const pixels = new Uint8ClampedArray(4 * width * height);
    const start = performance.now();
    let rays = 0;
    let dropped = false;

    const bands = [];
    for (let from = 0; from < height; from += band) bands.push([from, Math.min(from + band, height)]);
    const put = (from, to) => (answer) => {
      if (answer === DROPPED) return void (dropped = true);
      pixels.set(answer.pixels, 4 * width * from);
      rays += answer.rays;
      if (!kept && generation === this.generation && this.canvas.width === width && this.canvas.height === height) {
        this.context.putImageData(new ImageData(answer.pixels, width, to - from), 0, from);
      }
    };
    if (isShaded) {
      await Promise.all(bands.map(([from, to]) =>
        this.pool.run({ job: 'rows', camera, settings: asked, from, to }, { kept }).then(put(from, to))));
    } else {
      // Numbers become colours when all of them are known.
      const looks = await Promise.all(bands.map(([from, to]) =>
        this.pool.run({ job: 'look', camera, settings: asked, from, to }, { kept })));
      if (looks.includes(DROPPED)) return undefined;
      const ranges = looks.map((look) => look.range).filter(Boolean);
      const range = [Math.min(...ranges.map((r) => r[0]), Infinity), Math.max(...ranges.map((r) => r[1]), -Infinity)];
      rays = looks.reduce((sum, look) => sum + look.rays, 0);
      await Promise.all(bands.map(([from, to], i) => {
        const { words } = looks[i];
        const job = { job: 'paint', settings: asked, words, range };
        return this.pool.run(job, { kept: true, transfer: [words.buffer] }).then(put(from, to));
      }));
    }
    if (dropped) return undefined;
    // Clocks may stand for as long as a picture takes.
    const ms = Math.max(0.1, performance.now() - start);
    if (isShaded && pass.samples === 1) this.pace = ms / (width * height);
    return { view, pass, ms, rays, pixels, width, height };
  }

  // Puts a whole pass on the canvas.
  present({ pixels, width, height, pass }, { size }) {
    const { canvas, context, scratch } = this;
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    const image = new ImageData(pixels, width, height);
    if (pass.scale === 1) {
      context.putImageData(image, 0, 0);
    } else {
      [scratch.width, scratch.height] = [width, height];
      scratch.getContext('2d').putImageData(image, 0, 0);
      context.drawImage(scratch, 0, 0, ...size);
    }
    canvas.dataset.pass = pass.scale > 1 ? 'coarse' : pass.samples;
    canvas.dataset.frames = 1 + +(canvas.dataset.frames ?? 0);
  }
}
