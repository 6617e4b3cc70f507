// The flight against the truth, from a score.

import { html, table, paragraph, bulleted, fixed, brief, times, counted } from './text.js';
import { plots, pathOf, lineAt, textAt, dotAt } from './plot.js';
import { figureOf, legend, roundDown } from './figures.js';

const styles = ['s1', 's2', 's3', 's4'];
const pictureWidth = 1120;

/// Longest first, so that what is drawn is the larger part of the flight; then in order.
const drawnStrips = ({ strips }) => strips.filter((s) => s.length > 0 && s.position_mean_percent !== null)
  .sort((a, b) => b.length - a.length).slice(0, styles.length).sort((a, b) => a.id - b.id);

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/// Truth and error of the keyframes along and across the flight.
function stopsOf({ up, forward, keyframes }) {
  if (!up || !forward) return [];
  const left = cross(up, forward);
  return keyframes.filter((k) => k.true_centre && k.aligned_centre).map((k) => {
    const error = k.aligned_centre.map((v, i) => v - k.true_centre[i]);
    return { id: k.id, truth: [dot(forward, k.true_centre), dot(left, k.true_centre)], error: [dot(forward, error), dot(left, error)] };
  });
}

/// The largest error becomes about a twentieth of the track.
function exaggeration(stops) {
  const error = Math.max(...stops.map((s) => Math.hypot(...s.error)));
  const extent = Math.max(...stops.map((s) => Math.hypot(s.truth[0] - stops[0].truth[0], s.truth[1] - stops[0].truth[1])));
  const ratio = error > 0 ? 0.05 * extent / error : 0;
  return ratio > 1 && ratio < 1e9 ? roundDown(ratio) : 1;
}

/// True and estimated track from above, flight from left to right, errors drawn larger than they are.
function trackFigure(strip) {
  const stops = stopsOf(strip);
  if (stops.length < 2) return '';
  const factor = exaggeration(stops);
  const estimate = ({ truth, error }) => [truth[0] + factor * error[0], truth[1] + factor * error[1]];
  const points = stops.flatMap((s) => [s.truth, estimate(s)]);
  const [low, high] = [Math.min, Math.max].map((extreme) => [0, 1].map((axis) => extreme(...points.map((p) => p[axis]))));
  const [margin, tallest] = [36, 520];
  const [along, across] = [Math.max(high[0] - low[0], 1e-12), Math.max(high[1] - low[1], 1e-12)];
  const scale = Math.min((pictureWidth - 2 * margin) / along, tallest / across);
  const height = Math.max(110, across * scale + 2 * margin + 24);
  const at = ([x, y]) => [0.5 * (pictureWidth - along * scale) + (x - low[0]) * scale, margin + (high[1] - y) * scale];
  const bar = roundDown(0.16 * pictureWidth / scale);
  const [x1, y] = [pictureWidth - 20, height - 14];
  const x0 = x1 - bar * scale;
  return html`<figure><svg class="plot" viewBox="0 0 ${pictureWidth} ${fixed(height, 0)}" role="img" aria-label="true and estimated track">${
    pathOf('line s1', stops.map((s) => at(s.truth)))}${pathOf('line s2 dashed', stops.map((s) => at(estimate(s))))}${
    stops.map((s) => [pathOf('line s2', [at(s.truth), at(estimate(s))]), dotAt('dot s1', ...at(s.truth), 3, `keyframe ${s.id}, true`),
      dotAt('dot s2', ...at(estimate(s)), 3, `keyframe ${s.id}, off by ${brief(Math.hypot(...s.error))}`)])}${
    lineAt('bar-line', x0, y, x1, y)}${textAt('tick', 0.5 * (x0 + x1), y - 6, 'middle', brief(bar))}</svg><figcaption>Strip ${strip.id} from above, flight from left to right: <span class="key s1"></span> true track, <span class="key s2"></span> estimated track, laid onto it by a similarity, its errors ${
    factor === 1 ? 'to scale' : `${brief(factor)} times larger than they are`}.</figcaption></figure>\n`;
}

const nameOf = (strip) => `strip ${strip.id}`;
const alongStrip = (title, series, more) => ({ title, x: "distance flown, truth's unit", y: "truth's unit", counts: false, series, ...more });
const stripSeries = (strip, name, style, mark, value) => ({ name, style, mark, points: strip.keyframes.map((k) => [k.distance, value(k)]) });
const perStrip = (strips, value) => strips.map((s, i) => stripSeries(s, nameOf(s), styles[i], 'line', value));

function bowCurve({ bow_fit: fit, length }, style) {
  const points = Array.from({ length: 41 }, (_, i) => i / 20 - 1).map((u) => [0.5 * (u + 1) * length, fit[0] + u * (fit[1] + u * fit[2])]);
  return { name: 'bow', style, mark: 'curve', points };
}

function heightPlot(strips) {
  const one = strips.length === 1;
  const series = strips.flatMap((s, i) => [
    stripSeries(s, one ? 'cameras' : nameOf(s), styles[i], 'dots', (k) => k.height_error),
    ...(s.bow_fit ? [bowCurve(s, styles[one ? 1 : i])] : []),
    ...(one && s.surface_error.length > 0 ? [{ name: 'merged ground, median', style: 's3', mark: 'curve', points: s.surface_error }] : []),
  ]);
  return alongStrip('Height error along the strip, with its bow', series, { target: 0 });
}

function stripPlots(strips) {
  if (strips.length === 0) return [];
  const position = perStrip(strips, (k) => k.position_error);
  if (strips.length === 1) position[0].name = 'whole strip aligned';
  return [
    alongStrip('Position error', position),
    alongStrip('Position error with only the begin aligned: drift', perStrip(strips, (k) => k.drift_error)),
    heightPlot(strips),
    alongStrip("Local scale against the strip's mean", perStrip(strips, (k) => times(100, k.local_scale === null ? NaN : k.local_scale - 1)), { y: '%', target: 0 }),
  ];
}

function keyframePlots(report, { keyframes, target_overlap: scored }) {
  const measured = keyframes.filter((k) => k.sigma && k.relative_error);
  const perKeyframe = (name, style, mark, list, value) => ({ name, style, mark, points: list.map((k) => [k.id, value(k)]) });
  const target = scored ?? report.target_overlap;
  const overlaps = [perKeyframe('stated', 's1', 'dots', keyframes, (k) => times(100, k.overlap))];
  if (keyframes.some((k) => k.true_overlap !== null)) overlaps.push(perKeyframe('true', 's2', 'dots', keyframes, (k) => times(100, k.true_overlap)));
  return [
    {
      title: 'Position relative to the first pair: sigma and error', x: 'keyframe', y: 'strip unit',
      series: [perKeyframe('estimated, 1 sigma', 's1', 'line', measured, (k) => Math.hypot(...k.sigma)),
        perKeyframe('actual error', 's2', 'dots', measured, (k) => Math.hypot(...k.relative_error))],
    },
    {
      title: 'Overlap of each keyframe with the one before', x: 'keyframe', y: '%', fromZero: false,
      target: target === null ? null : 100 * target, targetName: 'target', series: overlaps,
    },
  ];
}

function scoreTables(scores) {
  const text = (value) => (Number.isInteger(value) ? fixed(value, 0) : brief(value));
  const groups = [...new Set(scores.map((s) => s.group))];
  return html`<h3>Scores</h3>\n<div class="columns">\n${groups.map((group) => table([[group, 't w'], 'score', 'perfect'],
    scores.filter((s) => s.group === group).map((s) => [s.label, text(s.value), s.perfect])))}</div>\n`;
}

const heightErrors = (picture) => figureOf(picture, {
  label: 'height errors', frame: legend(picture, "Error of the height, truth's unit"),
  caption: "Errors of the merged heights on the truth's grid, strip laid onto the truth: blue too low, red too high. Blank: not mapped.",
});

/// Nothing without a score.
export function score(report, pictures) {
  const s = report.score;
  if (!s) return '';
  const drawn = drawnStrips(s);
  return html`<h2>Against the truth</h2>
${!s.complete && paragraph('The flight is not complete; it is scored as far as it went.', 'warn')}${
  drawn.length < s.strips.length && paragraph(`${counted(drawn.length, 'strip')} of ${s.strips.length} drawn: the longest with poses enough to be measured. The scores are of all.`, 'note')}
<p class="note">Lengths are in the truth's unit: metres where it was simulated.</p>
${drawn.map(trackFigure)}${plots([...stripPlots(drawn), ...keyframePlots(report, s)])}${
  pictures.figures['height errors'] && heightErrors(pictures.figures['height errors'])}${scoreTables(s.scores)}${s.remarks.length > 0 && bulleted(s.remarks, 'note')}`;
}
