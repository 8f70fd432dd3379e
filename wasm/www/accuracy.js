// What accuracy costs, live: of each setting that was tried, the milliseconds per frame and how far its picture is from the
// best one of the same view at rest.
//
// The reference is the picture with 16 rays in every pixel, of the finest voxels and the best normals that were tried in
// this view; the error is the RMSE in linear light. A setting is a point from the time that its view has a reference; when
// the camera moves, points stay until they are measured again.

import { digits, time } from './format.js';

// From cheap to right; the default before the wider plane, which rounds corners off.
const NORMALS = ['face', 'gradient', 'ernerfeldt1', 'plane1', 'ernerfeldt2', 'plane3', 'stored', 'plane2'];
const NAMES = {
  face: 'faces', gradient: 'gradient', plane1: 'plane 3³', plane2: 'plane 5³', plane3: 'plane 7³', stored: 'stored',
  ernerfeldt1: 'Ernerfeldt 3³', ernerfeldt2: 'Ernerfeldt 5³',
};
// What a visitor may want to know of a view: normals by one ray, then rays by the default normals.
export const QUALITIES = [
  ...['face', 'gradient', 'plane1', 'plane2', 'plane3'].map((normals) => ({ normals, samples: 1, supersample: 'all' })),
  { normals: 'plane2', samples: 4, supersample: 'all' },
  ...['near', 'adaptive', 'all'].map((supersample) => ({ normals: 'plane2', samples: 16, supersample })),
];
// Bytes of pictures that are kept of a view, beside its reference.
const MOST = 128 << 20;
const SVG = 'http://www.w3.org/2000/svg';

// Those that nothing faster is nearer than.
export function front(points) {
  let best = Infinity;
  return [...points]
    .sort((a, b) => a.ms - b.ms || a.error - b.error)
    .filter(({ error }) => error < best && ((best = error), true));
}

export class Accuracy {
  constructor(element, pool) {
    this.element = element;
    this.pool = pool;
    this.clear();
  }

  clear() {
    this.points = new Map();
    this.view = { key: null };
    this.draw();
  }

  // A pass was drawn. `view.resolution` and `view.scene` say of what.
  async add({ view, pass, ms, pixels, width, height }) {
    const { camera, settings, size, scene, resolution } = view;
    const { show, normals, effects, sun, ambient } = settings;
    if (show !== 'shaded') return;
    const key = JSON.stringify([scene, camera, size, effects, sun, ambient]);
    if (key !== this.view.key) this.view = { key, pictures: new Map(), best: null };
    const { samples, supersample, scale } = pass;
    const rays = scale > 1 ? `1/${scale} size` : supersample !== 'all' ? samples : `${samples} ${samples > 1 ? 'rays' : 'ray'}`;
    const where = { all: '', near: ' near', adaptive: ' at edges' }[supersample];
    const setting = `${resolution}³ ${NAMES[normals]} ${rays}${where}`;
    const rank = samples === 16 && supersample === 'all' ? resolution * 10 + NORMALS.indexOf(normals) : -1;
    const picture = { setting, name: `${rays}${where}`, detail: `${resolution}³ ${NAMES[normals]}`, ms, rank, pixels, size: [width, height] };
    const { pictures } = this.view;
    pictures.delete(setting);
    pictures.set(setting, picture);
    let kept = [...pictures.values()].reduce((sum, each) => sum + each.pixels.length, 0);
    for (const each of pictures.values()) {
      if (kept <= MOST) break;
      if (each === picture || each === this.view.best) continue;
      pictures.delete(each.setting);
      kept -= each.pixels.length;
    }
    if (rank >= 0 && rank >= (this.view.best?.rank ?? 0)) {
      this.view.best = picture;
      await this.compare([...pictures.values()], size);
    } else if (this.view.best) {
      await this.compare([picture], size);
    }
  }

  // Measures pictures against the reference of their view.
  async compare(pictures, size) {
    // Those of now: another scene may have come before all are measured.
    const { view, points } = this;
    const reference = words(view.best.pixels);
    for (const picture of pictures) {
      const shown = words(picture.size[0] === size[0] ? picture.pixels : enlarged(picture, size));
      const error = picture === view.best ? 0 : await this.pool.run({ job: 'rmse', reference, picture: shown }, { kept: true });
      const { setting, name, detail, ms } = picture;
      points.set(setting, { setting, name, detail, ms, error, isReference: picture === view.best });
    }
    for (const point of points.values()) point.isReference &&= point.setting === view.best.setting;
    this.draw();
  }

  draw() {
    const points = [...this.points.values()];
    const best = front(points);
    const note = document.createElement('p');
    note.className = 'note';
    note.textContent = points.length
      ? 'Error: RMSE in linear light against the picture of this view at rest with 16 rays (ring). The line joins the settings that nothing faster is nearer than.'
      : 'Each setting that is drawn becomes a point: its time per frame, and its error against the picture at rest with 16 rays.';
    const numbers = points.length ? [plot(points, best), table(points, best)] : [];
    this.element.replaceChildren(...numbers, note);
  }
}

const words = (pixels) => new Uint32Array(pixels.buffer, pixels.byteOffset, pixels.length / 4);

// A small picture as the canvas shows it.
function enlarged({ pixels, size: [w, h] }, [width, height]) {
  const [small, large] = [new OffscreenCanvas(w, h), new OffscreenCanvas(width, height)];
  small.getContext('2d').putImageData(new ImageData(pixels, w, h), 0, 0);
  const context = large.getContext('2d', { alpha: false, willReadFrequently: true });
  context.drawImage(small, 0, 0, width, height);
  return context.getImageData(0, 0, width, height).data;
}

function make(name, attributes, ...children) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

// Milliseconds to the right, errors upwards, both by decades; the reference stands on the ground.
function plot(points, best) {
  const [width, height, left, right, top, bottom] = [300, 176, 48, 12, 10, 30];
  const svg = make('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img',
    'aria-label': `Milliseconds per frame and error of ${points.length} settings; the table has the numbers` });
  const span = (values, least) => {
    const [low, high] = values.length ? [Math.min(...values), Math.max(...values)].map(Math.log10) : [1, 2];
    const pad = Math.max(0.12, (least - (high - low)) / 2);
    return [low - pad, high + pad];
  };
  const [x0, x1] = span(points.map((p) => p.ms), 0.8);
  const [y0, y1] = span(points.filter((p) => p.error > 0).map((p) => p.error), 0.8);
  const ground = height - bottom;
  const x = (ms) => left + ((Math.log10(ms) - x0) / (x1 - x0)) * (width - left - right);
  const y = (error) => (error > 0 ? ground - 14 - ((Math.log10(error) - y0) / (y1 - y0)) * (ground - 14 - top) : ground);
  svg.append(make('path', { class: 'axis', d: `M${left} ${top}V${ground}H${width - right}` }));
  for (const value of ticks(x0, x1, 4)) {
    svg.append(make('path', { class: 'grid', d: `M${x(value)} ${top}V${ground}` }));
    svg.append(make('text', { x: x(value), y: ground + 12, 'text-anchor': 'middle' }, time(value)));
  }
  for (const value of ticks(y0, y1, 5)) {
    svg.append(make('path', { class: 'grid', d: `M${left} ${y(value)}H${width - right}` }));
    svg.append(make('text', { x: left - 5, y: y(value) + 3, 'text-anchor': 'end' }, digits(value)));
  }
  svg.append(make('text', { class: 'label', x: (left + width - right) / 2, y: height - 3, 'text-anchor': 'middle' }, 'time per frame'));
  svg.append(make('text', { class: 'label', x: 0, y: 0, transform: `translate(9 ${(top + ground) / 2}) rotate(-90)`, 'text-anchor': 'middle' }, 'error'));
  const line = best.map((p, i) => (i ? `H${x(p.ms)}V${y(p.error)}` : `M${x(p.ms)} ${y(p.error)}`)).join('');
  if (line) svg.append(make('path', { class: 'front', d: line }));
  for (const point of points) {
    const kind = point.isReference ? 'reference' : best.includes(point) ? 'best' : '';
    const title = make('title', {}, `${point.name} (${point.detail}): ${time(point.ms)}, error ${digits(point.error)}`);
    svg.append(make('circle', { class: `point ${kind}`, cx: x(point.ms), cy: y(point.error), r: kind ? 4 : 3 }, title));
  }
  return svg;
}

// Round values in a range of decades, at most so many.
function ticks(from, to, most) {
  for (const steps of [[1, 2, 5], [1, 3], [1]]) {
    const found = [];
    for (let decade = Math.floor(from); decade <= to; decade++) {
      found.push(...steps.map((step) => step * 10 ** decade).filter((v) => Math.log10(v) > from && Math.log10(v) < to));
    }
    if (found.length <= most || steps.length === 1) return found;
  }
}

function table(points, best) {
  const element = document.createElement('table');
  element.createTHead().innerHTML = '<tr><th scope="col">Setting</th><th scope="col">Frame</th><th scope="col">Error</th></tr>';
  const body = element.createTBody();
  for (const point of points.sort((a, b) => a.ms - b.ms)) {
    const row = body.insertRow();
    row.className = best.includes(point) ? 'best' : '';
    const head = document.createElement('th');
    head.scope = 'row';
    const detail = document.createElement('small');
    detail.textContent = point.detail;
    head.append(point.name, ' ', detail);
    row.append(head);
    row.insertCell().textContent = time(point.ms);
    row.insertCell().textContent = point.isReference ? 'reference' : digits(point.error);
  }
  return element;
}
