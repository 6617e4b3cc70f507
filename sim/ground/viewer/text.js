// Numbers for people, as in the report, and elements.

export { brief, fixed, percent, bytesText, counted, seconds } from '../report/page/text.js';

/// 2nd, 3rd, 21st
export function ordinal(n) {
  const ending = { one: 'st', two: 'nd', few: 'rd', other: 'th' };
  return `${n}${ending[new Intl.PluralRules('en', { type: 'ordinal' }).select(n)]}`;
}

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
