// The parts of the page as markup. What came down is text in it (text.js).
import { html, table, percent, bytesText, fixed, seconds } from './text.js';
import { severityKind } from './problems.js';

/// [name, value, class]
export const facts = (rows) => html`${rows.map(([name, value, kind]) => html`<div><dt>${name}</dt><dd class="${kind ?? ''}">${value}</dd></div>`)}`;

const product = (item) => (item && item[0] > 0 ? `${bytesText(item[0])}, ${item[1]}${item[2] ? `/${item[2]}` : ''}` : '–');

/// Of [[number, item], ...].
export const keyframeTable = (list) => list.length > 0 && table(
  ['keyframe', ['frame', 't'], 'time', ['state', 't'], 'overlap', 'richness', 'image, layers', 'depth, layers'],
  list.map(([id, k]) => [id, k.n, seconds(k.t), k.v, percent(k.o), fixed(k.r, 2), product(k.i), product(k.d)]));

export function eventList(list, least) {
  const shown = list.filter(([, e]) => e.level >= least).slice(-200).reverse();
  if (shown.length === 0) return html`<li class="note">No event of this severity has come down.</li>`;
  return html`${shown.map(([, e]) => html`<li>${seconds(e.time_ns / 1e9)} <b class="${severityKind(e.level)}">${e.severity}</b> ${e.text}${
    e.advice && e.level >= 2 && html`<p class="note">${e.advice}</p>`}</li>`)}`;
}

export const items = (lines, none) => html`${(lines.length > 0 ? lines : [none]).map((line) => html`<li>${line}</li>`)}`;
export const link = (name) => html`<a href="/files/${name.split('/').map(encodeURIComponent).join('/')}">${name}</a>`;
