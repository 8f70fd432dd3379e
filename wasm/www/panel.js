// The form beside the picture: what is chosen there becomes state, and what is known is shown.

import { bytes, digits, grouped, rate, time } from './format.js';

const NUMBERS = ['resolution', 'azimuth', 'elevation', 'ambient'];

// Puts state into the form, and tells `onchange(name)` what the visitor changes in it.
export function bind(form, state, onchange) {
  show(form, state);
  form.addEventListener('submit', (event) => event.preventDefault());
  form.addEventListener('input', ({ target: { name } }) => {
    if (name === 'effects') {
      state.effects = [...form.elements.effects].filter((box) => box.checked).map((box) => box.value).join(',');
    } else {
      const { value } = form.elements[name];
      state[name] = NUMBERS.includes(name) ? +value : value;
    }
    show(form, state);
    onchange(name);
  });
}

export function show(form, state) {
  for (const name of ['resolution', 'up', 'show', 'normals', 'rest', 'size', 'light', 'azimuth', 'elevation', 'ambient']) {
    const field = form.elements[name];
    const isMissing = field.options && ![...field.options].some((option) => option.value === String(state[name]));
    // A link may ask for what the list has not.
    if (isMissing) field.add(new Option(String(state[name]).replace('x', ' × '), state[name]));
    field.value = state[name];
  }
  const chosen = state.effects.split(',');
  for (const box of form.elements.effects) box.checked = chosen.includes(box.value);
  form.querySelector('#sun').hidden = state.light !== 'sun';
}

// What the scene has no use for is not offered.
export function offer(form, { effects, hasNormals, isBuilt }) {
  for (const box of form.elements.effects) {
    const isUseful = box.value === 'shadows' || effects.includes(box.value);
    box.closest('label').hidden = !isUseful;
  }
  form.querySelector('option[value=stored]').hidden = !hasNormals;
  for (const name of ['resolution', 'up']) form.elements[name].disabled = isBuilt;
  form.querySelector('#built').hidden = !isBuilt;
}

function rows(list, entries) {
  list.replaceChildren(...entries.filter(([, value]) => value !== undefined).flatMap(([name, value]) => {
    const [term, text] = ['dt', 'dd'].map((tag) => document.createElement(tag));
    [term.textContent, text.textContent] = [name, value];
    return [term, text];
  }));
}

export function showStats(list, { stats, built, frame, workers, memory }) {
  if (!stats) return;
  rows(list, [
    ['Triangles', built.triangles && grouped(built.triangles)],
    ['Voxels', grouped(stats.voxels)],
    ['Resolution', `${grouped(stats.resolution)}³`],
    ['DAG', bytes(stats.dagBytes)],
    ['Bits per voxel', digits((8 * stats.dagBytes) / Math.max(1, stats.voxels))],
    ['File', bytes(stats.fileBytes)],
    ['Materials', grouped(stats.materials)],
    ['Build', built.triangles === undefined ? undefined : time(built.ms)],
    ['Frame', frame && `${time(frame.ms)} (${frame.name})`],
    ['Rays', frame && rate(frame.rays / (frame.ms / 1000))],
    ['Memory', `${workers} × ${bytes(memory / workers)}`],
  ]);
}

export function showWarnings(details, warnings) {
  details.hidden = !warnings.length;
  details.open = false;
  details.querySelector('summary').textContent = warnings.length === 1 ? '1 warning' : `${warnings.length} warnings`;
  details.querySelector('ul').replaceChildren(...warnings.slice(0, 200).map((text) => {
    const item = document.createElement('li');
    item.textContent = text;
    return item;
  }));
}

export function showPick(list, hit) {
  list.hidden = false;
  if (!hit) return rows(list, [['Nothing', 'the background']]);
  rows(list, [
    ['Voxel', hit.voxel.join(', ')],
    ['Position', hit.position.map((x) => String(+x.toPrecision(6))).join(', ')],
    ['Normal', hit.normal.map((x) => (x + 0).toFixed(3)).join(', ')],
    ['Material', hit.material || '(no name)'],
    ['Distance', digits(hit.distance)],
  ]);
}
