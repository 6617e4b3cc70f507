// Figures from above: a picture with what is drawn over it. zoom.js brings them closer.

import { html, brief, fixed } from './text.js';
import { textAt, pathOf, dotAt } from './plot.js';

/// Where a place of the world lies in a picture, px.
export const placeIn = ({ cosine, sine, along_low, across_high, unit_per_px: size }) => ([x, y]) =>
  [(cosine * x + sine * y - along_low) / size, (across_high + sine * x - cosine * y) / size];

/// Light on dark, so that it is seen over any ground.
export const cased = (points, kind = 'track') => [pathOf('track dark', points), pathOf(kind, points)];
export const numberAbove = ([x, y], text) => textAt('number above', x, y, 'middle', text);

/// 1, 2 or 5 times a power of ten, at most `value`.
export function roundDown(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].find((factor) => value >= factor * power || factor === 1) * power;
}

/// A bar for a round length, at the lower left; of a part of a picture with its `share` of the whole.
export function scaleBar({ width, height, unit_per_px: size }, unit, share = 1) {
  const length = roundDown(0.18 * width * size * share);
  const [left, right, y] = [16, 16 + length / (size * share), height - 16];
  return [cased([[left, y], [right, y]]), textAt('number', 0.5 * (left + right), y - 7, 'middle', `${brief(length)} ${unit}`)];
}

/// Points where the direction of the world lies, at the lower right.
export function arrow({ width, height, cosine, sine }, [x, y], name) {
  const [along, down] = [cosine * x + sine * y, sine * x - cosine * y];
  const at = (ahead, aside) => [width - 60 + ahead * along - aside * down, height - 60 + ahead * down + aside * along];
  const [u, v] = at(38, 0);
  return [cased([at(0, 0), at(24, 0)]), cased([at(17, 3.5), at(24, 0), at(17, -3.5)]), textAt('number', u, v + 4, 'middle', name)];
}

/// What the colours of a picture mean, at the upper right.
export function legend({ view, range: [low, high], colours }, title) {
  const [left, name] = [view.width - 216, `colours-${colours[0].match(/\d+/)}`];
  return html`<defs><linearGradient id="${name}">${colours.map((c, i) => html`<stop offset="${fixed(100 * i / (colours.length - 1), 0)}%" stop-color="${c}"/>`)}</linearGradient></defs>${
    textAt('number', left + 200, 24, 'end', title)}<rect x="${left}" y="31" width="200" height="11" fill="url(#${name})"/>${
    [[0, 'start', low], [100, 'middle', 0.5 * (low + high)], [200, 'end', high]].map(([x, anchor, value]) => textAt('number', left + x, 62, anchor, brief(value)))}`;
}

/// The track with a dot per keyframe [number, place]; a number only where it does not touch the one before.
export function trackOf(view, keyframes) {
  const at = placeIn(view);
  const points = keyframes.map(([, place]) => at(place));
  let numbered = [-1e9, -1e9];
  return [cased(points), keyframes.map(([id], i) => {
    const apart = Math.hypot(points[i][0] - numbered[0], points[i][1] - numbered[1]) >= 26;
    if (apart) numbered = points[i];
    return [dotAt('stop', ...points[i], 4.5, `keyframe ${id}`), apart && numberAbove(points[i], id)];
  })];
}

/// `label` is the figure's own. `frame` stays where it is when the figure is moved; without a unit there is no scale bar.
export const figureOf = ({ view, href }, { label, unit, marks, frame, caption }) => html`<figure><svg class="map" viewBox="0 0 ${view.width} ${view.height}" data-view="${JSON.stringify(view)}" data-unit="${unit}" tabindex="0" role="img" aria-label="${label}">${
  href && html`<image width="${view.width}" height="${view.height}" href="${href}"/>`}${marks}<g class="frame">${unit && html`<g class="scale">${scaleBar(view, unit)}</g>`}${frame}</g></svg><figcaption>${caption}</figcaption></figure>\n`;
