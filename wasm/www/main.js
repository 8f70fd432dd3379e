// The page: a scene is built by a worker of its own, held by one worker per core, and drawn by all of them.

import { Accuracy, QUALITIES } from './accuracy.js';
import { chosen, dropped, fetched, read, title } from './files.js';
import { time } from './format.js';
import { listen } from './input.js';
import { between, sunDirection } from './orbit.js';
import { bind, offer, show, showPick, showStats, showWarnings } from './panel.js';
import { Picture } from './picture.js';
import { Pool, alone } from './pool.js';
import { copy, download, png } from './save.js';
import { beginning, fromHash, sides, toHash } from './state.js';

const $ = (id) => document.getElementById(id);
const [canvas, stage, form] = [$('picture'), $('stage'), $('settings')];

const state = fromHash(location.hash);
// What the page opens with: the camera of the link belongs to it.
const first = state.scene ? { url: state.scene } : {};
// {source, name, built, camera, effects, hasNormals, stats, up, asked}
let scene = null;
// {source, control}
let building = null;
let memory = 0;
let frame = null;
// Number of sources that were opened.
let opened = 0;
// Whether the scene has not been seen yet.
let isFresh = false;

const asked = Math.floor(new URLSearchParams(location.search).get('workers'));
const workers = Math.min(64, asked > 0 ? asked : navigator.hardwareConcurrency || 2);
let module, pool, picture, accuracy;
// What workers take, one scene after the other: all must hold the same.
let loading = null;

async function prepare() {
  bind(form, state, changed);
  module = await WebAssembly.compileStreaming(fetch('pkg/voxdag_bg.wasm'));
  pool = new Pool(module, workers);
  accuracy = new Accuracy($('accuracy'), pool);
  picture = new Picture(canvas, pool, { onpass, onerror: failed });
  new ResizeObserver(() => update()).observe(stage);
}
const prepared = prepare();

async function start() {
  await prepared;
  // A visitor may have been faster.
  if (!building) await open(first);
}

// The demo, over what is said of something that could not be opened; its resolution may have been too much.
function fallBack() {
  state.resolution = beginning().resolution;
  show(form, state);
  open({}, true);
}

// Opens files, a URL or, of neither, the scene that comes along. The camera stays if it is the same scene again.
async function open(source, isFallback = false) {
  building?.control.abort(new Error('cancelled'));
  const control = new AbortController();
  const { signal } = control;
  building = { source, control };
  const isLast = () => building?.control === control;
  const { resolution, up } = scene?.asked ?? state;
  try {
    if (!isFallback) hideError();
    performance.mark('open');
    progress('Reading…');
    await prepared;
    source.files ??= source.url && (await fetched(source.url, signal));
    const files = source.files && (await read(source.files));
    signal.throwIfAborted();
    progress('Building…');
    const built = await alone(module, { job: 'build', files, resolution, up }, {
      signal,
      onprogress: (done, total) => progress('Building…', done / total),
      transfer: files?.map(({ bytes }) => bytes.buffer),
    });
    while (loading) await loading.catch(() => {});
    signal.throwIfAborted();
    // From here on there is no way back, only a next one.
    progress('Loading…');
    $('cancel').disabled = true;
    loading = load(built, !source.files).finally(() => (loading = null));
    const { stats, ...info } = await loading;
    const name = (source.url && state.title) || (source.files ? built.name : 'Demo scene');
    const isAgain = source === (scene?.source ?? first);
    const isBuilt = built.triangles === undefined;
    scene = { ...info, source, name, built, stats };
    // A file has its own; the next mesh is built with what was asked for before.
    scene.up = isBuilt ? (info.camera.up[2] > 0.5 ? 'z' : 'y') : up;
    scene.asked = isBuilt ? { resolution, up } : null;
    source.id ??= ++opened;
    if (!isAgain) {
      state.camera = null;
      state.scene = source.url ?? '';
      if (!source.url) state.title = '';
      accuracy.clear();
    }
    frame = null;
    $('scene-name').textContent = name;
    showAsBuilt();
    offer(form, { ...info, isBuilt });
    showWarnings($('warnings'), built.warnings);
    statistics();
    isFresh = true;
    update();
  } catch (error) {
    if (isLast() && scene) {
      showAsBuilt();
      // Workers that could not take the new scene have the old one.
      if (!picture.view) update();
    }
    if (signal.aborted) return;
    const name = source.files ? title(source.files) : source.url ?? 'the demo scene';
    failed(error, `${name} could not be opened`);
  } finally {
    if (isLast()) {
      building = null;
      progress(null);
      if (!scene && !isFallback) fallBack();
    }
  }
}

// Resolution and up axis are those of the scene that is shown.
function showAsBuilt() {
  state.resolution = scene.stats.resolution;
  state.up = scene.up;
  show(form, state);
}

// Gives a scene to all workers, and says what it holds.
async function load(built, isDemo) {
  picture.set(null);
  const [info] = await pool.all({ job: 'load', words: built.words });
  delete built.words;
  if (isDemo) info.camera = await pool.run({ job: 'demoCamera' });
  info.stats = await pool.run({ job: 'stats' });
  memory = (await pool.all({ job: 'memory' })).reduce((sum, bytes) => sum + bytes, 0);
  return info;
}

// The camera, unless the visitor has moved it the scene's own.
const camera = () => state.camera ?? scene?.camera;

function changed(name) {
  if (name === 'resolution' || name === 'up') {
    // Of what is being opened, if something is.
    const { source } = building ?? scene ?? {};
    if (source) open(source);
  } else {
    update();
  }
}

// Draws what the state says from now on.
function update() {
  // Workers that load have no scene of which a picture could be drawn.
  if (!scene || loading) return;
  const size = fit();
  const { show, normals, rest, light, ambient, up } = state;
  const sun = light === 'sun' ? sunDirection(up, state.azimuth, state.elevation) : null;
  const settings = {
    show, normals, rest, sun,
    effects: state.effects.split(',').filter(Boolean),
    ambient: sun ? ambient : null,
    demo: !scene.source.files,
  };
  $('mark').hidden = true;
  picture.set({ camera: camera(), settings, size, scene: scene.source.id, resolution: scene.stats.resolution });
}

// The picture's size in pixels; a chosen one is shown as large as it fits.
function fit() {
  const [width, height] = [stage.clientWidth, stage.clientHeight];
  const wanted = sides(state.size);
  if (wanted) {
    const scale = Math.min(width / wanted[0], height / wanted[1]);
    [canvas.style.width, canvas.style.height] = wanted.map((side) => `${side * scale}px`);
    return wanted;
  }
  canvas.style.width = canvas.style.height = '100%';
  const density = Math.min(devicePixelRatio, 2);
  return [width, height].map((side) => Math.max(1, Math.round(side * density)));
}

function onpass(drawn) {
  const { pass, ms, rays, view } = drawn;
  if (isFresh) performance.mark('picture');
  isFresh = false;
  accuracy.add(drawn).catch(failed);
  const { show } = view.settings;
  const isShaded = show === 'shaded' || show === 'samples';
  const name = pass.scale > 1 ? `1/${pass.scale} size` : isShaded ? `${pass.samples} ${pass.samples > 1 ? 'rays' : 'ray'}` : show;
  $('quality').textContent = `${name} · ${time(ms)}`;
  performance.measure(name, { duration: ms, end: performance.now() });
  if (pass.scale > 1) return;
  frame = { ms, rays, name };
  statistics();
  history.replaceState(null, '', location.pathname + location.search + toHash(state));
}

const statistics = () => scene && showStats($('stats'), { ...scene, frame, workers, memory });

$('more').onclick = async () => {
  const button = $('more');
  button.disabled = true;
  try {
    await picture.compare(QUALITIES, async (drawn, share) => {
      await accuracy.add(drawn);
      button.textContent = `${Math.round(100 * share)} %`;
    });
  } catch (error) {
    failed(error);
  } finally {
    button.textContent = 'Try more';
    button.disabled = false;
  }
};

// Pointers and keys.
listen(canvas, {
  get: () => ({ camera: camera(), radius: scene?.stats.radius }),
  move(camera) {
    state.camera = camera;
    update();
  },
  home() {
    state.camera = null;
    update();
  },
  async pick(x, y) {
    const hit = await ray(x, y).catch(failed);
    if (hit === undefined) return;
    showPick($('pick'), hit);
    const mark = $('mark');
    mark.hidden = !hit;
    mark.style.left = `${canvas.offsetLeft + x * canvas.clientWidth}px`;
    mark.style.top = `${canvas.offsetTop + y * canvas.clientHeight}px`;
  },
  async target(x, y) {
    const hit = await ray(x, y).catch(failed);
    if (hit) glide({ ...camera(), target: hit.position });
  },
});

// What is seen through a place of the picture.
async function ray(x, y) {
  if (!picture?.view) return undefined;
  const { camera, settings, size: [width, height] } = picture.view;
  const asked = { ...settings, samples: 1, supersample: 'all', width, height };
  return pool.run({ job: 'pick', camera, settings: asked, x: x * width, y: y * height }, { kept: true, first: true });
}

// Moves the camera there in a moment.
function glide(to) {
  const [from, start] = [camera(), performance.now()];
  let moved = state.camera;
  const length = matchMedia('(prefers-reduced-motion: reduce)').matches ? 0 : 250;
  const step = (now) => {
    // Whoever moves the camera meanwhile, moves it.
    if (state.camera !== moved) return;
    const t = length ? Math.min(1, Math.max(0, (now - start) / length)) : 1;
    state.camera = moved = between(from, to, t * t * (3 - 2 * t));
    update();
    if (t < 1) requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

// Files.
$('open').onclick = () => $('files').click();
$('open-folder').onclick = () => $('folder').click();
$('open-demo').onclick = () => open({});
for (const input of [$('files'), $('folder')]) {
  input.onchange = () => {
    if (input.files.length) open({ files: chosen(input.files) });
    input.value = '';
  };
}
let within = 0;
addEventListener('dragenter', () => ($('drop').hidden = !++within));
addEventListener('dragleave', () => ($('drop').hidden = !--within));
addEventListener('dragover', (event) => event.preventDefault());
addEventListener('drop', (event) => {
  event.preventDefault();
  within = 0;
  $('drop').hidden = true;
  dropped(event.dataTransfer).then((files) => files.length && open({ files })).catch(failed);
});
$('cancel').onclick = () => building?.control.abort(new Error('cancelled'));

// What can be taken along.
const base = () => (scene?.name ?? 'voxdag').replace(/\.\w+$/, '').toLowerCase().replaceAll(' ', '-');
$('save-png').onclick = () => png(canvas, base()).catch(failed);
$('save-vxd').onclick = async () => {
  const bytes = await pool.run({ job: 'save' }, { kept: true, first: true }).catch(failed);
  if (bytes) download(new Blob([bytes], { type: 'application/octet-stream' }), `${base()}.vxd`);
};
$('share').onclick = async () => {
  const link = location.origin + location.pathname + location.search + toHash({ ...state, camera: camera() });
  if (!(await copy(link))) return;
  const isHere = scene?.source.files && !scene.source.url;
  toast(isHere ? 'Link copied: it carries the view, not your files' : 'Link copied');
};
for (const button of document.querySelectorAll('.menu button')) {
  button.addEventListener('click', () => (button.closest('details').open = false));
}
addEventListener('pointerdown', ({ target }) => {
  for (const menu of document.querySelectorAll('.menu[open]')) menu.open = menu.contains(target);
});
addEventListener('keydown', ({ key }) => {
  if (key !== 'Escape') return;
  $('pick').hidden = $('mark').hidden = true;
  hideError();
  for (const menu of document.querySelectorAll('.menu[open]')) {
    menu.open = false;
    menu.querySelector('summary').focus();
  }
});
// A link that is pasted into this very page.
addEventListener('hashchange', () => location.reload());

// What is said.
function progress(text, share) {
  $('progress').hidden = text === null;
  $('cancel').disabled = false;
  $('progress-text').textContent = text ?? '';
  if (share === undefined) $('progress-bar').removeAttribute('value');
  else $('progress-bar').value = share;
}

function failed(error, heading = 'Something went wrong') {
  const { message, fatal } = error;
  $('error-title').textContent = heading;
  const text = fatal ? `The module stopped (${message}): it may have run out of memory` : message;
  $('error-text').textContent = text.includes('out of memory') ? `${text}. Try a smaller resolution.` : text;
  $('error').hidden = false;
}

function hideError() {
  $('error').hidden = true;
}
$('error-close').onclick = hideError;

function toast(text) {
  $('toast').textContent = text;
  $('toast').hidden = false;
  clearTimeout(toast.timer);
  toast.timer = setTimeout(() => ($('toast').hidden = true), 3000);
}

start().catch((error) => failed(error, 'The page could not be started'));
