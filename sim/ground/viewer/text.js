// Numbers for people, and elements.

/// About three significant digits.
export function brief(value) {
  if (!Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (size >= 1000) return Math.round(value).toLocaleString('en').replaceAll(',', '\u202f');
  return value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : size >= 0.01 ? 3 : size === 0 ? 0 : 4);
}
export const fixed = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : '–');
export const percent = (value) => (Number.isFinite(value) ? `${(100 * value).toFixed(1)} %` : '–');
export function bytesText(n) {
  if (!Number.isFinite(n)) return '–';
  return n < 1e3 ? `${n} B` : n < 1e6 ? `${(n / 1e3).toFixed(1)} kB` : `${(n / 1e6).toFixed(2)} MB`;
}
export const counted = (n, what) => `${n} ${what}${n === 1 ? '' : 's'}`;
/// 2nd, 3rd, 21st
export function ordinal(n) {
  const ending = { one: 'st', two: 'nd', few: 'rd', other: 'th' };
  return `${n}${ending[new Intl.PluralRules('en', { type: 'ordinal' }).select(n)]}`;
}
export const seconds = (t) => (Number.isFinite(t) ? `${t.toFixed(1)} s` : '–');

/// Text is set as text: what came down is never markup.
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, '');
    else if (value !== false && value != null) node.setAttribute(name, value);
  }
  node.append(...children.filter((c) => c != null));
  return node;
}
const svgSpace = 'http://www.w3.org/2000/svg';
export function svg(tag, attributes = {}, ...children) {
  const node = document.createElementNS(svgSpace, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}
export const facts = (rows) =>
  element('dl', { class: 'facts' }, ...rows.filter(Boolean).flatMap(([name, value]) =>
    [element('dt', {}, name), element('dd', {}, value)]));
