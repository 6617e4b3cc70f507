// Small plots as SVG. Colours come from the style sheet, so that they follow light and dark.

import { html, fixed, brief } from './text.js';

const size = { width: 560, height: 230, left: 52, right: 14, top: 34, bottom: 40 };

function niceStep(span, ticks) {
  const raw = span / ticks;
  const power = 10 ** Math.floor(Math.log10(raw));
  return [1, 2, 5, 10].find((factor) => raw <= factor * power) * power;
}
function niceAxis(low, high, ticks) {
  const end = high - low < 1e-12 * Math.max(1, Math.abs(high)) ? low + Math.max(1, 0.1 * Math.abs(low)) : high;
  const step = niceStep(end - low, ticks);
  return { low: Math.floor(low / step) * step, high: Math.ceil(end / step) * step, step };
}
function tickText(value, step) {
  if (Math.abs(value) >= 1e4) return `${fixed(value / 1e3, 0)}k`;
  const decimals = step >= 1 ? 0 : Math.min(6, Math.ceil(-Math.log10(step) - 1e-9));
  return fixed(Math.abs(value) < 1e-6 * step ? 0 : value, decimals);
}
function rangeOf(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return [low, high];
}

export const lineAt = (kind, x1, y1, x2, y2) =>
  html`<line class="${kind}" x1="${fixed(x1, 1)}" y1="${fixed(y1, 1)}" x2="${fixed(x2, 1)}" y2="${fixed(y2, 1)}"/>`;
export const textAt = (kind, x, y, anchor, text) =>
  html`<text class="${kind}" x="${fixed(x, 1)}" y="${fixed(y, 1)}" text-anchor="${anchor}">${text}</text>`;
export const pathOf = (kind, points) =>
  html`<polyline class="${kind}" points="${points.map(([x, y]) => `${fixed(x, 1)},${fixed(y, 1)}`).join(' ')}"/>`;
export const dotAt = (kind, x, y, radius, title) =>
  html`<circle class="${kind}" cx="${fixed(x, 1)}" cy="${fixed(y, 1)}" r="${radius}">${title && html`<title>${title}</title>`}</circle>`;

/// A series is {name, style (s1 to s4), mark, points: [[x, y, error bar or nothing]]}; its mark is 'line' with dots,
/// 'curve' without, 'dots' or 'bars'. `target` is a dashed level; with `counts`, x are whole numbers. Points that are not
/// finite are left out.
export function plot({ title, x, y, series, target = null, targetName = '', fromZero = true, counts = true }) {
  const { width, height, left, right, top, bottom } = size;
  const drawn = series.map((s) => ({ ...s, points: s.points.filter((p) => Number.isFinite(p[0]) && Number.isFinite(p[1])) }));
  const error = (p) => (Number.isFinite(p[2]) ? p[2] : 0);
  const all = drawn.flatMap((s) => s.points);
  const open = html`<svg class="plot" viewBox="0 0 ${width} ${height}" role="img" aria-label="${title}">${textAt('title', 0, 14, 'start', title)}`;
  if (all.length === 0) return html`${open}${textAt('tick', 0.5 * width, 0.5 * height, 'middle', 'no data')}</svg>\n`;

  const bars = drawn.filter((s) => s.mark === 'bars').length;
  const levels = [target, fromZero ? 0 : null].filter((level) => level !== null);
  const [yLow, yHigh] = rangeOf([...levels, ...all.flatMap((p) => [p[1] - error(p), p[1] + error(p)])]);
  const [xLow, xHigh] = rangeOf(all.map((p) => p[0]));
  const side = bars ? 0.6 : 0.25;
  const xAxis = counts ? { low: xLow - side, high: xHigh + side, step: Math.max(1, niceStep(xHigh - xLow + 1, 10)) } : niceAxis(xLow, xHigh, 8);
  const yAxis = niceAxis(yLow, yHigh, 5);
  const px = (v) => left + (v - xAxis.low) / (xAxis.high - xAxis.low) * (width - left - right);
  const py = (v) => height - bottom - (v - yAxis.low) / (yAxis.high - yAxis.low) * (height - top - bottom);

  const parts = [];
  for (let v = yAxis.low; v <= yAxis.high + 0.5 * yAxis.step; v += yAxis.step) {
    parts.push(lineAt('grid', left, py(v), width - right, py(v)), textAt('tick', left - 7, py(v) + 3.5, 'end', tickText(v, yAxis.step)));
  }
  for (let v = Math.ceil(xAxis.low / xAxis.step) * xAxis.step; v <= xAxis.high; v += xAxis.step) {
    parts.push(textAt('tick', px(v), height - bottom + 15, 'middle', tickText(v, xAxis.step)));
  }
  parts.push(textAt('tick', width - right, height - 8, 'end', x));
  // A long unit begins at the border, so that it is not cut.
  const fits = 6.2 * y.length < left - 7;
  parts.push(textAt('tick', fits ? left - 7 : 0, top - 8, fits ? 'end' : 'start', y));

  const wide = Math.min((px(1) - px(0)) * 0.8 / bars, 26);
  const base = py(Math.max(0, yAxis.low));
  let bar = 0;
  for (const s of drawn) {
    const told = (p) => `${s.name} ${brief(p[0])}: ${brief(p[1])}`;
    if (s.mark === 'bars') {
      const shift = (bar++ - 0.5 * bars) * wide;
      parts.push(s.points.map((p) => html`<rect class="bar ${s.style}" x="${fixed(px(p[0]) + shift, 1)}" y="${fixed(Math.min(py(p[1]), base), 1)}" width="${fixed(Math.max(0.8, wide - 1), 1)}" height="${fixed(Math.abs(base - py(p[1])), 1)}"><title>${told(p)}</title></rect>`));
      continue;
    }
    if (s.mark !== 'dots') parts.push(pathOf(`line ${s.style}`, s.points.map((p) => [px(p[0]), py(p[1])])));
    if (s.mark === 'curve') continue;
    parts.push(s.points.filter((p) => error(p) > 0).map((p) => lineAt(`line ${s.style}`, px(p[0]), py(p[1] - p[2]), px(p[0]), py(p[1] + p[2]))));
    parts.push(s.points.map((p) => dotAt(`dot ${s.style}`, px(p[0]), py(p[1]), s.points.length > 120 ? 1.4 : 2.8, told(p))));
  }
  if (target !== null) {
    parts.push(lineAt('target', left, py(target), width - right, py(target)), textAt('tick target-text', width - right, py(target) - 4, 'end', targetName));
  }
  let at = left;
  for (const s of drawn.length > 1 ? drawn : []) {
    parts.push(html`<rect class="bar ${s.style}" x="${fixed(at, 1)}" y="${height - 15}" width="9" height="9"/>`, textAt('tick', at + 13, height - 7, 'start', s.name));
    at += 28 + 6.2 * s.name.length;
  }
  return html`${open}${parts}</svg>\n`;
}
export const plots = (list) => html`<div class="plots">\n${list.map(plot)}</div>\n`;
