// One place of the ground: coordinates, height, who saw it.

import { element, facts, brief, fixed } from './text.js';
import { heightAt, sigmaAt, cellAt, planeAt } from './grid.js';
import { seenBy } from './camera_model.js';

const most = 24;

function sighting(state, { keyframe, pixel }) {
  const [width, height] = keyframe.camera;
  const where = `left:${((100 * (pixel.u + 0.5)) / width).toFixed(2)}%;top:${((100 * (pixel.v + 0.5)) / height).toFixed(2)}%`;
  const picture = keyframe.thumbnails.image
    ? element('img', { src: keyframe.thumbnails.image, alt: '' })
    : element('div', { class: 'none' }, 'no image');
  return element('button', {
    type: 'button', class: 'sighting', onclick: () => state.select(keyframe), 'aria-label': `keyframe ${keyframe.id}, pixel ${pixel.u.toFixed(0)}, ${pixel.v.toFixed(0)}`,
  }, element('span', { class: 'frame', style: `aspect-ratio:${width}/${height}` }, picture, element('i', { class: 'cross', style: where })),
  element('span', {}, `${keyframe.id} · ${pixel.u.toFixed(0)}, ${pixel.v.toFixed(0)}`));
}

export function placeTab(state, say) {
  const { place, strip } = state;
  if (!place || !strip.grid) return [element('p', { class: 'muted' }, 'No place is chosen. Click the ground, or move the cursor with the arrow keys and press Enter.')];
  const { grid, unit } = strip;
  const height = heightAt(grid, place.x, place.y);
  const sigma = sigmaAt(grid, place.x, place.y);
  const cell = cellAt(grid, place.x, place.y);
  const seen = seenBy(strip, place.x, place.y, height);
  const source = cell >= 0 ? strip.keyframes[grid.source_of[cell] - 1] : undefined;
  const told = `${fixed(height, 3)}${Number.isFinite(sigma) ? ` ± ${brief(sigma)}` : ''} ${unit}`;
  say(`Height ${told}, seen by ${seen.length} keyframes`);
  return [
    element('h2', {}, 'Place'),
    element('p', { class: 'figure' }, told),
    facts([
      ['x, y', `${fixed(place.x, 3)}, ${fixed(place.y, 3)} ${unit}`],
      ['Height', told],
      ['Above mean plane', `${fixed(height - planeAt(strip, place.x, place.y), 3)} ${unit}`],
      cell >= 0 && ['Measured by', grid.count_of[cell] ? `${grid.count_of[cell]} keyframe${grid.count_of[cell] > 1 ? 's' : ''}` : 'none: a closed seam'],
      cell >= 0 && grid.safe_of && ['Safe landing', grid.safe_of[cell] === 255 ? 'not known here' : `${grid.safe_of[cell]} %`],
      source && ['Shown from', `keyframe ${source}`],
    ]),
    element('h3', {}, `In the picture of ${seen.length} keyframe${seen.length === 1 ? '' : 's'}`),
    element('div', { class: 'sightings' }, ...seen.slice(0, most).map((s) => sighting(state, s))),
    seen.length > most ? element('p', { class: 'muted' }, `The ${most} nearest are shown.`) : null,
    element('p', { class: 'muted' }, 'Nearest first; terrain in between is not looked for.'),
  ];
}
