// From pointers, wheel and keys to cameras: one finger or the left button orbits, two fingers or the right button pan, a
// pinch or the wheel zooms, a click picks, a double click sets the target.

import { orbit, pan, zoom } from './orbit.js';

// Pixels that a click may stray, and milliseconds between two that are one.
const STRAY = 5;
const TWICE = 320;

// `get` gives {camera, radius}; `move(camera)`, `pick(x, y)` and `target(x, y)` take what comes of it, places as fractions of
// the canvas; `home()` shows all.
export function listen(canvas, { get, move, pick, target, home }) {
  const pointers = new Map();
  let click = null;
  let last = { time: -Infinity };

  const height = () => canvas.clientHeight || 1;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };

  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const isPan = event.button > 0 || event.shiftKey;
    click = pointers.size === 1 ? { at: [event.clientX, event.clientY], isPan } : null;
    canvas.classList.add('dragging');
  });

  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    const { camera, radius } = get();
    if (!camera || (dx === 0 && dy === 0)) return;
    if (pointers.size === 1) {
      if (click?.at && Math.hypot(now[0] - click.at[0], now[1] - click.at[1]) <= STRAY) return;
      if (click) click.at = null;
      pointers.set(event.pointerId, now);
      const [x, y] = [dx / height(), dy / height()];
      move(click?.isPan ? pan(camera, x, y) : orbit(camera, x, y));
    } else {
      // What the two are to each other before and after: the middle pans, the distance zooms.
      const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
      const apart = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
      pointers.set(event.pointerId, now);
      move(zoom(pan(camera, dx / 2 / height(), dy / 2 / height()), apart(before) / apart(now), radius));
    }
  });

  const up = (event) => {
    if (!pointers.delete(event.pointerId)) return;
    if (pointers.size) return void (click = { at: null, isPan: false });
    canvas.classList.remove('dragging');
    const isClick = event.type === 'pointerup' && click?.at && !click.isPan;
    click = null;
    if (!isClick) return;
    const near = Math.hypot(event.clientX - last.x, event.clientY - last.y) < 6 * STRAY;
    if (event.timeStamp - last.time < TWICE && near) {
      last = { time: -Infinity };
      target(...place(event));
    } else {
      last = { time: event.timeStamp, x: event.clientX, y: event.clientY };
      pick(...place(event));
    }
  };
  canvas.addEventListener('pointerup', up);
  canvas.addEventListener('pointercancel', up);
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());

  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const { camera, radius } = get();
    const lines = event.deltaMode === 1 ? 16 : 1;
    // A pinch on a touchpad comes as a wheel with control, in small steps.
    if (camera) move(zoom(camera, Math.exp(event.deltaY * lines * (event.ctrlKey ? 0.01 : 0.0015)), radius));
  }, { passive: false });

  canvas.addEventListener('keydown', (event) => {
    const { camera, radius } = get();
    if (!camera || event.ctrlKey || event.metaKey || event.altKey) return;
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const [x, y] = arrows[event.key] ?? [0, 0];
    if (x || y) move(event.shiftKey ? pan(camera, -x * 0.05, -y * 0.05) : orbit(camera, -x * 0.04, -y * 0.04));
    else if (event.key === '+' || event.key === '=') move(zoom(camera, 0.9, radius));
    else if (event.key === '-') move(zoom(camera, 1 / 0.9, radius));
    else if (event.key === 'Home') home();
    else if (event.key === 'Enter') pick(0.5, 0.5);
    else return;
    event.preventDefault();
  });
}
