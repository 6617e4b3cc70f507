// Figures from above are moved by dragging and by the arrow keys, and brought closer by a double click, by + and -, and by
// the wheel where they have the focus.

import { html } from './text.js';
import { placeIn, scaleBar } from './figures.js';

const viewOf = (map) => JSON.parse(map.dataset.view);
/// What is shown of a figure, px.
const boxOf = (map) => map.getAttribute('viewBox').split(' ').map(Number);
const middleOf = ([left, top, width, height]) => [left + width / 2, top + height / 2];

/// Around a place, with this width, px; no more than the whole.
function show(map, [x, y], wanted) {
  const view = viewOf(map);
  const share = Math.min(1, Math.max(wanted / view.width, 1 / 400));
  const begin = (middle, all) => Math.min(all * (1 - share), Math.max(0, middle - all * share / 2));
  const [left, top] = [begin(x, view.width), begin(y, view.height)];
  map.setAttribute('viewBox', [left, top, share * view.width, share * view.height].join(' '));
  // Lines and numbers keep their size on the screen.
  map.style.setProperty('--px', share);
  map.style.touchAction = share < 1 ? 'none' : '';
  map.querySelector('.frame').setAttribute('transform', `translate(${left} ${top}) scale(${share})`);
  const scale = map.querySelector('.scale');
  if (scale) scale.innerHTML = html`${scaleBar(view, map.dataset.unit, share)}`.toString();
}

/// What lies under the pointer stays there; without one, the middle.
function closer(map, factor, pointer) {
  const middle = middleOf(boxOf(map));
  const { x, y } = pointer ? new DOMPoint(pointer.clientX, pointer.clientY).matrixTransform(map.getScreenCTM().inverse()) : { x: middle[0], y: middle[1] };
  show(map, [x + (middle[0] - x) / factor, y + (middle[1] - y) / factor], boxOf(map)[2] / factor);
}

function move(map, dx, dy) {
  const [x, y] = middleOf(boxOf(map));
  const size = 1 / map.getScreenCTM().a;
  show(map, [x - dx * size, y - dy * size], boxOf(map)[2]);
}

/// A place of the world and a width in its unit, for showAgain() in the next picture of the same ground.
export function whatIsShown(map) {
  const { along_low, across_high, unit_per_px: size, cosine, sine, width } = viewOf(map);
  const box = boxOf(map);
  const [x, y] = middleOf(box);
  const [along, across] = [along_low + x * size, across_high - y * size];
  return { place: [cosine * along - sine * across, sine * along + cosine * across], width: box[2] < width ? box[2] * size : Infinity, focus: document.activeElement === map };
}

export function showAgain(map, { place, width, focus }) {
  const view = viewOf(map);
  if (width < Infinity) show(map, placeIn(view)(place), width / view.unit_per_px);
  if (focus) map.focus({ preventScroll: true });
}

const keys = { ArrowLeft: (map) => move(map, 40, 0), ArrowRight: (map) => move(map, -40, 0), ArrowUp: (map) => move(map, 0, 40), ArrowDown: (map) => move(map, 0, -40), '+': (map) => closer(map, 1.5), '-': (map) => closer(map, 1 / 1.5) };

function listen(type, act) {
  document.addEventListener(type, (event) => {
    const map = event.target.closest?.('svg.map');
    if (map && act(map, event)) event.preventDefault();
  }, { passive: false });
}
listen('keydown', (map, { key }) => {
  keys[key]?.(map);
  return key in keys;
});
listen('wheel', (map, event) => {
  if (document.activeElement !== map) return false;
  closer(map, Math.exp(-event.deltaY / 400), event);
  return true;
});
listen('dblclick', (map, event) => {
  closer(map, 2, event);
  return true;
});
listen('pointerdown', (map, { pointerId }) => { map.setPointerCapture(pointerId); });
listen('pointermove', (map, { pointerId, movementX, movementY }) => {
  if (map.hasPointerCapture(pointerId)) move(map, movementX, movementY);
});
