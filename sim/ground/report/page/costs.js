// Values along the flight, and what it cost: processor time, memory, storage.

import { html, table, styled, paragraph, fixed, percent, durationText, times, counted } from './text.js';
import { plots } from './plot.js';
import { storageFacts } from './storage.js';

function overlapPlot(report) {
  const ofKeyframes = new Set(report.keyframes.map((k) => k.frame));
  const frames = report.frames.filter((f) => f.keyframe > 0 && f.verdict === 'ok' && !ofKeyframes.has(f.id));
  return {
    title: 'Overlap with the latest keyframe', x: 'frame', y: '%', fromZero: false,
    target: report.target_overlap === null ? null : 100 * report.target_overlap, targetName: 'target',
    series: [
      { name: 'frames', style: 's1', mark: 'dots', points: frames.map((f) => [f.id, times(100, f.overlap)]) },
      { name: 'keyframes', style: 's2', mark: 'dots', points: report.keyframes.filter((k) => k.index > 0).map((k) => [k.frame, times(100, k.overlap_with_previous)]) },
    ],
  };
}

export function alongTheFlight(report) {
  const perKeyframe = (name, style, mark, value) => ({
    name, style, mark, points: report.keyframes.map((k) => [k.id, value(k)]),
  });
  const keyframePlot = (title, y, ...series) => ({ title, x: 'keyframe', y, series });
  const kilobytes = (product) => (product ? product.bytes / 1e3 : null);
  const stripOf = (k) => report.strips.find((s) => s.id === k.strip)?.accuracy;
  const ofLength = (k) => (k.error && stripOf(k)?.length > 0 ? times(100 / stripOf(k).length, k.error.position) : null);
  const list = [
    overlapPlot(report),
    keyframePlot('Image Richness Index and novelty', '0 to 1',
      perKeyframe('richness', 's1', 'line', (k) => k.richness?.index),
      perKeyframe('novelty', 's2', 'line', (k) => k.richness?.novelty)),
    keyframePlot('Reprojection error of the adjustment window', 'px',
      perKeyframe('rms', 's1', 'line', (k) => (k.pose?.matches > 0 ? k.pose.rms_px : null))),
    keyframePlot('Bytes of the products', 'kB',
      perKeyframe('image', 's1', 'bars', (k) => kilobytes(k.image_product)),
      perKeyframe('depth', 's3', 'bars', (k) => kilobytes(k.depth_product))),
  ];
  if (report.has_reference) {
    const series = [perKeyframe('position, of distance', 's2', 'line', ofLength)];
    if (report.keyframes.some((k) => k.error?.depth)) {
      series.push(perKeyframe('height, of height flown', 's3', 'line', (k) => k.error?.depth?.median_abs_percent));
    }
    list.push(keyframePlot('Errors against the reference', '%', ...series));
  }
  return html`<h2>Along the flight</h2>\n${plots(list)}`;
}

function memorySentences({ flight, storage }) {
  return [
    flight?.static_bytes != null && `Static memory of the flight software ${fixed(flight.static_bytes / 1048576, 1)} MiB. `,
    flight?.peak_rss_mib != null && `The process took ${fixed(flight.peak_rss_mib, 0)} MiB at most. `,
    flight?.wall_s != null && `The run took ${durationText(flight.wall_s)} on the host. `,
    storage && `Onboard storage: ${storageFacts(storage).map(([name, value]) => `${name.toLowerCase()} ${value}`).join('; ')}. `,
  ].filter(Boolean);
}

function componentTable(report) {
  const all = report.components.reduce((sum, c) => sum + c.busy_s, 0);
  const count = (n) => styled(n, n > 0 ? 'warn' : '');
  return table(
    [['component', 't'], 'steps', 'processor time', 'share', 'per keyframe', 'longest step', 'overruns', 'faults', 'restarts'],
    report.components.map((c) => [c.name, c.steps, durationText(c.busy_s), all > 0 ? percent(c.busy_s / all, 0) : '–',
      durationText(c.busy_s / Math.max(1, report.keyframes.length)), durationText(c.longest_step_s), count(c.overruns), count(c.faults), count(c.restarts)]));
}

function timingSection({ timing, keyframes }) {
  if (!timing) return '';
  const reduced = keyframes.filter((k) => k.degraded > 0).length;
  const bars = (name, style, counts) => ({ name, style, mark: 'bars', points: counts.map((n, i) => [i, Math.log10(1 + n)]) });
  return html`<p>${timing.frames} minor frames, ${timing.overruns} ended late; the longest took ${durationText(timing.longest_s)}, the latest began ${durationText(timing.latest_s)} behind its time. Work was reduced or restored ${timing.degraded_changes} times; ${counted(reduced, 'keyframe')} computed at a reduced level.</p>
${/* In virtual time nothing takes mission time. */ (timing.longest_s > 0 || timing.latest_s > 0) && plots([{
    title: 'Minor frames: late begins and lengths', x: 'below 2^x microseconds', y: 'log10(1 + frames)',
    series: [bars('late', 's2', timing.late), bars('length', 's1', timing.length)],
  }])}`;
}

/// Nothing where fewer reports came than make a line.
function housekeepingPlots({ housekeeping }) {
  if (housekeeping.length < 3) return '';
  const line = (name, style, key, factor = 1e-6) => ({ name, style, mark: 'line', points: housekeeping.map((h, i) => [i + 1, factor * h[key]]) });
  const report = (title, y, ...series) => ({ title, x: 'housekeeping report', y, series });
  return plots([
    report('Data held on board', 'MB', line('frames', 's1', 'frame_bytes'), line('depth', 's2', 'depth_bytes'), line('products', 's3', 'product_bytes')),
    report('Database on board', 'MB', line('file', 's1', 'database_bytes'), line('unused', 's2', 'database_free_bytes')),
    report('Processor time of the components', 's since the start', line('all', 's1', 'busy_s', 1)),
  ]);
}

export function cost(report) {
  const memory = memorySentences(report);
  return html`<h2>What it cost</h2>
${memory.length > 0 && paragraph(memory)}${report.components.length === 0
    ? paragraph('No component housekeeping came down.', 'note')
    : [componentTable(report), timingSection(report), housekeepingPlots(report)]}`;
}
