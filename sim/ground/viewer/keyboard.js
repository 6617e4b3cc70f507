// Every action of the page by keyboard; help.js lists them.

import { layersOf } from './layers.js';
import { takePlace } from './pointer.js';
import { cellAt } from './grid.js';

// From the place, or from the middle of what was seen.
function firstCursor(state) {
  if (state.place) return { ...state.place };
  const { grid } = state.strip;
  const middle = { x: grid.x0 + 0.5 * grid.width * grid.cell, y: grid.y0 - 0.5 * grid.height * grid.cell };
  if (cellAt(grid, middle.x, middle.y) >= 0) return middle;
  const covered = [];
  grid.height_of.forEach((z, c) => { if (!Number.isNaN(z)) covered.push(c); });
  const cell = covered[covered.length >> 1];
  return { x: grid.x0 + (cell % grid.width) * grid.cell, y: grid.y0 - Math.floor(cell / grid.width) * grid.cell };
}

// Arrows point as on the screen: along the axis of the world that is nearest to it.
function moveCursor(state, scene, dx, dy, far) {
  const { grid } = state.strip;
  if (!state.cursor) return state.set({ cursor: firstCursor(state) });
  const step = grid.cell * (far ? 10 : 1) * Math.max(1, Math.round(scene.scale() * 4 / grid.cell));
  const turn = (Math.round(scene.azimuth() / (Math.PI / 2)) * Math.PI) / 2;
  const x = state.cursor.x + step * (dx * Math.cos(turn) - dy * Math.sin(turn));
  const y = state.cursor.y + step * (dx * Math.sin(turn) + dy * Math.cos(turn));
  const i = Math.round((x - grid.x0) / grid.cell);
  const j = Math.round((grid.y0 - y) / grid.cell);
  state.set({ cursor: {
    x: grid.x0 + Math.min(grid.width - 1, Math.max(0, i)) * grid.cell,
    y: grid.y0 - Math.min(grid.height - 1, Math.max(0, j)) * grid.cell,
  } });
}

function drop(state) {
  state.set({ keyframe: null, span: null, place: null, cursor: null, measuring: false, profile: { a: null, b: null } });
}

const flip = (state, name) => state.set({ show: { ...state.show, [name]: !state.show[name] } });
const relief = (state, by) => state.set({ exaggeration: Math.min(8, Math.max(1, state.exaggeration + by)) });

function everywhere(page, state, scene) {
  const surface = scene && state.strip?.grid;
  const actions = {
    '?': () => page.help.showModal(),
    '[': () => state.step(-1),
    ']': () => state.step(1),
    Escape: () => drop(state),
  };
  if (!scene) return actions;
  Object.assign(actions, {
    t: () => flip(state, 'track'),
    l: () => { if (state.flight.links.length) flip(state, 'links'); },
    m: () => { if (state.flight.fixes.length) flip(state, 'fixes'); },
    f: () => flip(state, 'footprints'),
    u: () => flip(state, 'uncertainty'),
    '+': () => scene.zoom(0.85),
    '=': () => scene.zoom(0.85),
    '-': () => scene.zoom(1 / 0.85),
    a: () => scene.turn(-0.12, 0),
    d: () => scene.turn(0.12, 0),
    w: () => scene.turn(0, -0.09),
    s: () => scene.turn(0, 0.09),
    0: () => scene.home(),
    9: () => scene.home('top'),
  });
  if (!surface) return actions;
  layersOf(state.flight).forEach((layer, i) => { actions[i + 1] = () => state.set({ layer: layer.id }); });
  return Object.assign(actions, {
    p: () => state.set({ measuring: !state.measuring }),
    x: () => relief(state, 0.5),
    X: () => relief(state, -0.5),
    c: () => { const at = state.cursor ?? state.place; if (at) scene.lookAt(at.x, at.y); },
  });
}

function onView(state, scene, event) {
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  if (event.key in arrows) return () => moveCursor(state, scene, ...arrows[event.key], event.shiftKey);
  if (event.key === 'Enter') {
    return () => {
      if (!state.cursor) return state.set({ cursor: firstCursor(state) });
      if (cellAt(state.strip.grid, state.cursor.x, state.cursor.y) >= 0) takePlace(state, { ...state.cursor });
    };
  }
  return null;
}

// Arrows inside a group of radio buttons or tabs.
function inGroup(event) {
  const group = event.target.closest?.('[role=radiogroup],[role=tablist]');
  const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (!group || !by) return false;
  const buttons = [...group.querySelectorAll('button:not([disabled])')];
  const next = buttons[(buttons.indexOf(event.target) + by + buttons.length) % buttons.length];
  next.focus();
  next.click();
  return true;
}

export function listenToKeys(page, state, scene) {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || page.help.open) return;
    const typing = event.target.matches?.('input,select,textarea');
    if (typing && event.key !== 'Escape') return;
    if (inGroup(event)) return event.preventDefault();
    const surface = scene && state.strip?.grid;
    const action = (event.target === page.canvas && surface ? onView(state, scene, event) : null)
      ?? everywhere(page, state, scene)[event.key] ?? everywhere(page, state, scene)[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
