// How the page is used, by pointer and by keyboard; and whose work it contains.

import { layersOf } from './layers.js';
import { element } from './text.js';

const keysOf = (layers) => [
  ['← ↑ → ↓', 'move the cursor over the ground (Shift: in large steps)'],
  ['Enter', 'ask for the place under the cursor'],
  ['P', 'measure: then two places, by clicks or by Enter'],
  ['[  ]', 'previous and next keyframe'],
  [`1 … ${layers.length}`, `colour: ${layers.map((l) => l.name.toLowerCase()).join(', ')}`],
  ['T  L  M  F  U', 'track, links, fixes on the map, footprints, uncertainty'],
  ['X  Shift X', 'more, less exaggeration of the relief'],
  ['+  −', 'nearer, farther'],
  ['A  D  W  S', 'turn the view left, right, up, down'],
  ['C', 'centre the view on the cursor or the place'],
  ['0  9', 'first view; from above'],
  ['Tab', 'to the next tool; arrows inside a group and in the timeline'],
  ['Esc', 'drop what is chosen'],
  ['?', 'this help'],
];
const pointer = [
  ['Drag', 'turn the view'],
  ['Right drag, Shift drag', 'move it'],
  ['Wheel', 'nearer, farther'],
  ['Click on the ground', 'coordinates, height, the keyframes that saw it'],
  ['Click on a camera', 'its keyframe'],
  ['Drag in the timeline', 'highlight the keyframes of that time'],
];
const table = (rows) => element('dl', { class: 'keys' }, ...rows.flatMap(([key, what]) => [element('dt', {}, key), element('dd', {}, what)]));

export function helpDialog(flight) {
  const dialog = element('dialog', { class: 'help', 'aria-label': 'Help' });
  dialog.append(
    element('h2', {}, 'Using this page'),
    element('div', { class: 'columns' },
      element('div', {}, element('h3', {}, 'Keyboard'), table(keysOf(layersOf(flight)))),
      element('div', {}, element('h3', {}, 'Pointer'), table(pointer),
        element('h3', {}, 'Reading it'),
        element('p', {}, 'Coordinates are those of the strip: its origin and its scale. Heights are its z; relief is the height above its mean plane, to which the view is levelled. The track stands true to scale over relief that may be exaggerated.'),
        element('p', {}, 'The surface may be thinned for this page (the legend says by how much); the files beside the report have every cell.'))),
    element('details', {}, element('summary', {}, 'Contains three.js: licence'), element('pre', {}, document.getElementById('licence')?.textContent ?? '')),
    element('button', { type: 'button', autofocus: true, onclick: () => dialog.close() }, 'Close'));
  return dialog;
}
