// When the images were taken: captures, their forecasts, telecommands.

import { html, table, styled, paragraph, fixed, brief, percent, counted } from './text.js';
import { plots } from './plot.js';

const mostCaptures = 60;
const sourceStyles = { forecast: 's1', 'on the way': 's3' };
const withoutFrame = (capture) => capture.state === 'no frame' || capture.state === 'rejected';
const signedPercent = (share) => `${share > 0 ? '+' : ''}${percent(share, 1)}`;
const inSeconds = (ns) => fixed(ns === null ? NaN : ns / 1e9, 3);
// No overlap is further off than all of it.
const forecastPoint = (x, check, value) => [x, 100 * value, check.sigma === null ? null : 100 * Math.min(check.sigma, 1)];

function keyframePlot(report) {
  const { checks } = report.captures;
  const measured = report.keyframes.filter((k) => k.index > 0 && Number.isFinite(k.overlap_with_previous) && k.overlap_with_previous >= 0 && k.overlap_with_previous <= 1);
  return {
    title: 'Overlap of each keyframe with the one before', x: 'keyframe', y: '%', fromZero: false,
    target: report.target_overlap === null ? null : 100 * report.target_overlap, targetName: 'target',
    series: [
      { name: 'forecast, 1 sigma', style: 's1', mark: 'dots', points: checks.filter((c) => c.keyframe !== null).map((c) => forecastPoint(c.keyframe, c, c.forecast)) },
      { name: 'measured', style: 's2', mark: 'dots', points: measured.map((k) => [k.id, 100 * k.overlap_with_previous]) },
    ],
  };
}

function errorPlot({ checks }) {
  const sources = [...new Set(checks.map((c) => c.source))].sort();
  return {
    title: 'Forecast minus measured overlap', x: 'capture', y: '%', target: 0,
    series: sources.map((name) => ({
      name, style: sourceStyles[name] ?? 's4', mark: 'dots',
      points: checks.filter((c) => c.source === name).map((c) => forecastPoint(c.capture, c, c.forecast - c.measured)),
    })),
  };
}

function sentences(report, c) {
  const achieved = c.achieved_minus_target_overlap;
  const forecast = c.forecast_minus_measured_overlap;
  const spread = (s, noun) => `(mean of ${counted(s.count, noun)}; standard deviation ${percent(s.standard_deviation, 1)}). `;
  return [
    c.frames_per_keyframe !== null && `${brief(c.frames_per_keyframe)} frames per keyframe. `,
    achieved.count > 0 && `Achieved minus target overlap is ${signedPercent(achieved.mean)}, target ${percent(report.target_overlap, 0)} ${spread(achieved, 'keyframe')}`,
    forecast.count > 0 && `Forecast minus measured overlap is ${signedPercent(forecast.mean)} ${spread(forecast, 'capture')}`,
    c.forecasts_with_sigma > 0 && `Inside 1 sigma lie ${percent(c.share_within_1_sigma, 0)} of the forecasts and inside 2 sigma ${percent(c.share_within_2_sigma, 0)}; 68 % and 95 % would be honest. `,
    c.forecasts_unchecked > 0 && `${counted(c.forecasts_unchecked, 'forecast')} cannot be checked: the overlap was not measured, or against another keyframe. `,
  ];
}

function countTable(c) {
  const sum = (states) => Object.values(states).reduce((a, b) => a + b, 0);
  return table([['captures', 't'], 'all', ...c.states], Object.entries(c.by_source_and_state)
    .map(([source, states]) => [source, sum(states), ...c.states.map((state) => states[state] ?? 0)]));
}

function captureTable({ list }) {
  const all = list.filter((c) => c.command !== null || withoutFrame(c));
  if (all.length === 0) return paragraph('No capture was telecommanded, and none stayed without a frame.', 'note');
  const first = [...all.filter((c) => c.frame === null), ...all.filter((c) => c.frame !== null)].slice(0, mostCaptures);
  const shown = first.sort((a, b) => a.id - b.id);
  return html`<h3>Telecommanded captures, and those without a frame</h3>
${shown.length < all.length && html`<p class="note">${shown.length} of ${all.length} shown, those without a frame before the others; <code>report.json</code> has all.</p>\n`}${
  table(['capture', ['source', 't'], 'wanted, s', 'exposed, s', 'difference, ms', 'frame', ['state', 't'], ['why', 't w']],
    shown.map((c) => [c.id, c.source, inSeconds(c.requested_ns), inSeconds(c.exposed_ns), fixed(c.exposed_minus_requested_ms, 1),
      c.frame ?? '–', styled(c.state, withoutFrame(c) ? 't warn' : 't'), c.reason]))}`;
}

/// Nothing without capture records.
export function captures(report) {
  const c = report.captures;
  if (!c) return '';
  return html`<h2>When the images were taken</h2>
<p>${sentences(report, c)}</p>
${plots([keyframePlot(report), ...(c.checks.length > 0 ? [errorPlot(c)] : [])])}
<h3>Captures by what asked for them</h3>\n${countTable(c)}${captureTable(c)}`;
}
