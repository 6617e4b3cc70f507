// Markup and numbers of the pages. Text gets into markup only through html``, which escapes it.

const entities = { '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;', "'": '&#39;' };
/// Control characters become blanks.
const escaped = (text) => String(text).replace(/[&<>"'\x00-\x1f\x7f]/g, (c) => entities[c] ?? ' ');

class Markup {
  constructor(text) { this.text = text; }
  toString() { return this.text; }
}
function inserted(value) {
  if (value == null || value === false) return '';
  if (value instanceof Markup) return value.text;
  return Array.isArray(value) ? value.map(inserted).join('') : escaped(value);
}
/// html`<p>${text}</p>`: markup stays, lists are joined, and null and false are nothing.
export const html = (parts, ...values) =>
  new Markup(parts.reduce((text, part, i) => text + inserted(values[i - 1]) + part));

/// A dash for what is not known.
export const fixed = (value, digits) =>
  (!Number.isFinite(value) ? '–' : Math.abs(value) >= 1e12 ? value.toExponential(2) : value.toFixed(digits));
/// About three significant digits.
export function brief(value) {
  const size = Math.abs(value);
  if (Number.isFinite(value) && size > 0 && size < 1e-4) return value.toExponential(1);
  return fixed(value, size >= 100 || size === 0 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : size >= 0.01 ? 3 : 5);
}
/// Of a share of 0 to 1.
export const percent = (share, digits = 1) => (Number.isFinite(share) ? `${fixed(100 * share, digits)} %` : '–');
export function bytesText(bytes) {
  if (!Number.isFinite(bytes)) return '–';
  if (bytes < 1000) return `${bytes} B`;
  return bytes < 1e6 ? `${fixed(bytes / 1e3, bytes < 1e4 ? 2 : 1)} kB` : `${fixed(bytes / 1e6, 2)} MB`;
}
export function durationText(seconds) {
  if (!Number.isFinite(seconds)) return '–';
  if (seconds < 1e-3) return `${fixed(seconds * 1e6, 0)} µs`;
  if (seconds < 1) return `${fixed(seconds * 1e3, seconds < 0.1 ? 1 : 0)} ms`;
  return seconds < 120 ? `${fixed(seconds, 1)} s` : `${fixed(seconds / 60, 1)} min`;
}
/// Null is 0 in a product: what is not known stays so.
export const times = (factor, value) => (Number.isFinite(value) ? factor * value : NaN);
export const largest = (values) => (values.every(Number.isFinite) ? Math.max(...values) : NaN);
export const seconds = (time) => (Number.isFinite(time) ? `${fixed(time, 1)} s` : '–');
export const counted = (count, noun) => `${count} ${noun}${count === 1 ? '' : 's'}`;
export const degrees = (radians) => radians * 180 / Math.PI;

export const paragraph = (text, kind) => html`<p${kind && html` class="${kind}"`}>${text}</p>\n`;
export const bulleted = (lines, kind) =>
  html`<ul${kind && html` class="${kind}"`}>${lines.map((line) => html`<li>${line}</li>`)}</ul>\n`;
export const aside = (text) => html` <span class="sub">${text}</span>`;

/// A value of a table with another class than its column.
export const styled = (value, kind) => ({ value, kind });
const isStyled = (value) => value !== null && typeof value === 'object' && 'kind' in value;
const kindOf = (kind) => kind && html` class="${kind}"`;
const title = (text) => text.split('\n').map((line, i) => [i > 0 && html`<br>`, line]);

/// Columns are titles, with line breaks where wanted, or [title, class]; rows are lists of values. A narrow window may
/// show rows as lists, with the title before each value.
export function table(columns, rows, kind = 'scroll') {
  const heads = columns.map((column) => [].concat(column));
  const cell = (value, i) => {
    const own = isStyled(value) ? value : { value, kind: heads[i][1] };
    return html`<td data-title="${heads[i][0].replace('\n', ' ')}"${kindOf(own.kind)}>${own.value}</td>`;
  };
  return html`<div class="${kind}"><table><tr>${heads.map(([text, style]) => html`<th${kindOf(style)}>${title(text)}</th>`)}</tr>
${rows.map((row) => html`<tr>${row.map(cell)}</tr>\n`)}</table></div>\n`;
}
