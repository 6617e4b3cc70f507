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

// The parts of the error of a height (height_error.hpp); what is left of the whole is that of matching.
function errorParts({ errors }, source, x, y, z, whole) {
  const [centreZ, centreSigma, share] = errors.keyframes[source - 1] ?? [z, 0, 0];
  const poses = Math.hypot(share * (centreZ - z), centreSigma);
  const scale = errors.scale * Math.abs(z - errors.middle[2]);
  const tilt = errors.tilt * Math.hypot(x - errors.middle[0], y - errors.middle[1]);
  const matching = Math.sqrt(Math.max(0, whole ** 2 - poses ** 2 - scale ** 2 - tilt ** 2 - errors.place ** 2));
  return Object.entries({ matching, poses, scale, tilt, place: errors.place })
    .map(([name, sigma]) => `${name} ${sigma > 0 ? brief(sigma) : '–'}`).join(', ');
}

// Longitude, latitude and height as the GeoTIFF files have them, where the strip is on a body.
function onBody(strip, x, y, z, sigma) {
  const { place: p, grid } = strip;
  if (!p) return [];
  const u = (x - grid.x0) / (p.width || 1), v = (grid.y0 - y) / (p.height || 1);
  const [longitude, latitude] = [0, 1].map((k) => (1 - v) * ((1 - u) * p.corners[0][k] + u * p.corners[1][k])
    + v * ((1 - u) * p.corners[2][k] + u * p.corners[3][k]));
  const error = Number.isFinite(sigma) ? ` ± ${brief(p.scale * sigma)}` : '';
  return [
    ['Longitude, latitude', `${fixed(longitude, 6)}°, ${fixed(latitude, 6)}° (${p.body})`],
    ['Height on the map', `${fixed(p.height_of_0 + p.scale * z, 2)}${error} m`],
  ];
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
      ...onBody(strip, place.x, place.y, height, sigma),
      Number.isFinite(sigma) && strip.errors && ['Its error', errorParts(strip, cell >= 0 ? grid.source_of[cell] : 0, place.x, place.y, height, sigma)],
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
