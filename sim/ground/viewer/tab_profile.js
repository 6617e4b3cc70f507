// A measured profile: heights between two places with one sigma around them, as a plot and as a table to take away.

import { element, facts, svg, brief, fixed } from './text.js';
import { profileOf, profileCsv } from './grid.js';

const [width, height, left, bottom, top] = [340, 210, 46, 26, 10];

// Round steps for about n ticks.
function ticks(low, high, n) {
  const raw = (high - low) / n || 1;
  const decade = 10 ** Math.floor(Math.log10(raw));
  const step = decade * (raw / decade > 5 ? 10 : raw / decade > 2 ? 5 : raw / decade > 1 ? 2 : 1);
  const out = [];
  for (let v = Math.ceil(low / step) * step; v <= high + 1e-9 * step && out.length < 20; v += step) out.push(v);
  return out;
}

// Runs of points that have a height: gaps of the map are gaps of the line.
function runs(points) {
  const out = [];
  let run = null;
  for (const p of points) {
    if (!Number.isFinite(p.height)) run = null;
    else if (run) run.push(p);
    else out.push((run = [p]));
  }
  return out;
}

function plot({ points, distance }, unit) {
  const seen = points.filter((p) => Number.isFinite(p.height));
  const low = Math.min(...seen.map((p) => p.height - (p.sigma || 0)));
  const high = Math.max(...seen.map((p) => p.height + (p.sigma || 0)));
  const margin = 0.06 * (high - low) || 1;
  const x = (d) => left + (d / (distance || 1)) * (width - left - 8);
  const y = (z) => height - bottom - ((z - low + margin) / (high - low + 2 * margin)) * (height - bottom - top);
  const picture = svg('svg', { viewBox: `0 0 ${width} ${height}`, class: 'profile', role: 'img', 'aria-label': `Heights along ${brief(distance)} ${unit}, from ${brief(low)} to ${brief(high)} ${unit}` });
  const text = (content, attributes) => { const t = svg('text', attributes); t.textContent = content; return t; };
  for (const v of ticks(low, high, 4)) picture.append(svg('line', { class: 'gridline', x1: left, x2: width - 8, y1: y(v), y2: y(v) }), text(brief(v), { x: left - 5, y: y(v) + 4, 'text-anchor': 'end' }));
  for (const v of ticks(0, distance, 4)) picture.append(text(brief(v), { x: x(v), y: height - 10, 'text-anchor': 'middle' }));
  picture.append(text(`height, ${unit}`, { x: left + 4, y: top + 8 }), text(`distance, ${unit}`, { x: width - 8, y: height - bottom - 4, 'text-anchor': 'end' }));
  for (const run of runs(points)) {
    const upper = run.map((p) => `${x(p.distance).toFixed(1)},${y(p.height + (p.sigma || 0)).toFixed(1)}`);
    const lower = run.map((p) => `${x(p.distance).toFixed(1)},${y(p.height - (p.sigma || 0)).toFixed(1)}`).reverse();
    picture.append(svg('polygon', { class: 'band', points: [...upper, ...lower].join(' ') }),
      svg('polyline', { class: 'line', points: run.map((p) => `${x(p.distance).toFixed(1)},${y(p.height).toFixed(1)}`).join(' ') }));
  }
  return picture;
}

function download(text) {
  const link = element('a', { href: URL.createObjectURL(new Blob([text], { type: 'text/csv' })), download: 'profile.csv' });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

export function profileTab(state, say) {
  const { strip } = state;
  const { a, b } = state.profile;
  const begin = element('button', { type: 'button', onclick: () => state.set({ measuring: true, profile: { a: null, b: null } }) }, a ? 'Measure another' : 'Measure');
  if (!strip?.grid) return [element('p', { class: 'muted' }, 'There is no surface to measure on.')];
  if (!a || !b) return [element('h2', {}, 'Profile'), element('p', {}, a ? 'The beginning is set: now the end.' : 'Heights along a line between two places.'), element('p', { class: 'muted' }, 'Click twice on the ground, or move the cursor with the arrow keys and press Enter twice.'), begin];
  const profile = profileOf(strip.grid, a, b);
  const { unit } = strip;
  const seen = profile.points.filter((p) => Number.isFinite(p.height));
  if (!seen.length) return [element('h2', {}, 'Profile'), element('p', {}, 'Nothing was seen along this line.'), begin];
  const heights = seen.map((p) => p.height);
  say(`Profile: ${brief(profile.distance)} ${unit} long, drop ${brief(profile.drop)} ${unit}`);
  return [
    element('h2', {}, 'Profile'),
    element('p', { class: 'figure' }, `${brief(profile.distance)} ${unit}`),
    plot(profile, unit),
    element('p', { class: 'muted' }, `Heights are z of the strip; the colour Height shows them above its mean plane. Band: one sigma. Gaps: nothing seen.`),
    facts([
      ['Distance', `${fixed(profile.distance, 3)} ${unit}`],
      ['Drop', `${fixed(profile.drop, 3)} ${unit}`],
      ['Mean slope', `${fixed((Math.atan2(Math.abs(profile.drop), profile.distance) * 180) / Math.PI, 1)}°`],
      ['Lowest, highest', `${fixed(Math.min(...heights), 3)}, ${fixed(Math.max(...heights), 3)} ${unit}`],
      ['From', `${fixed(a.x, 3)}, ${fixed(a.y, 3)}`], ['To', `${fixed(b.x, 3)}, ${fixed(b.y, 3)}`],
      ['Heights', `${seen.length} of ${profile.points.length} along the line`],
    ]),
    element('div', { class: 'buttons' }, begin, element('button', { type: 'button', id: 'csv', onclick: () => download(profileCsv(profile, unit)) }, 'Download CSV')),
  ];
}
