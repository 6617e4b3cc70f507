// The top of the page: what was covered, how accurate, what it cost, what went wrong.

import { html, paragraph, fixed, brief, bytesText, durationText, times, counted } from './text.js';

function calibrationWords({ camera_calibration: found, camera_sigma_focal_px: sigma }) {
  if (!found) return '';
  if (!found.frozen) return ' (nominal: the camera was not known and could not be calibrated)';
  if (found.source === 'given') return '';
  return ` ± ${brief(sigma)} px (${found.source === 'nominal' ? 'nominal: the images did not determine it' : `found in flight, at keyframe ${found.keyframe}`})`;
}

function readoutWords(readout) {
  if (!readout) return '';
  const time = `, rolling shutter of ${brief(times(1e3, readout.s))}`;
  return readout.sigma_s > 0 ? `${time} ± ${brief(1e3 * readout.sigma_s)} ms (found in flight)` : `${time} ms`;
}

function subtitle({ flight, camera, ...report }) {
  return [
    flight?.source,
    flight?.frames != null && `${fixed(flight.frames, 0)} frames`,
    camera && `camera ${camera.width} × ${camera.height}, focal length ${brief(camera.fx)} px${calibrationWords(report)}${readoutWords(report.camera_readout)}`,
    flight?.software && `software ${flight.software}`,
    flight?.profile && `profile ${flight.profile}`,
    flight?.seed != null && `seed ${fixed(flight.seed, 0)}`,
  ].filter(Boolean).join(' · ');
}

function coverageSentence({ totals: t, strips }) {
  const [{ length_unit: length, track_length: flown, flying_height: height }] = strips.length === 1 ? strips : [{}];
  const above = height > 0 ? ` (${brief(flown / height)} times the flying height)` : '';
  return `${t.final_poses} of ${counted(t.keyframes, 'keyframe')} ${t.final_poses === 1 ? 'has' : 'have'} a final pose and ${t.with_depth} an elevation map, in ${counted(strips.length, 'strip')}${flown > 0 ? ` of ${brief(length.factor * flown)} ${length.name}${above}` : ''}. `;
}

const known = (value) => Number.isFinite(value);

function accuracySentence({ accuracy }) {
  if (!accuracy) return 'There is no reference to measure the accuracy against. ';
  const a = accuracy.joined_model ?? accuracy.strips;
  const text = [
    known(a.position_mean_percent) && `camera positions${accuracy.joined_model ? ' of the joined model' : ''} are off by ${brief(a.position_mean_percent)} % of the distance flown on average and by ${brief(a.position_max_percent)} % at most`,
    known(a.height_percent) && `merged heights by ${brief(a.height_percent)} % of the flying height (median)`,
    known(a.depth_percent) && `depths of single pixels by ${brief(a.depth_percent)} % of the flying height (median)`,
    known(a.keyframe_depth_percent) && `depths of the median keyframe by ${brief(a.keyframe_depth_percent)} % of the flying height`,
  ].filter(Boolean).join('; ');
  return text ? `Against the reference, ${text}. ` : 'Too few poses match the reference to measure the accuracy. ';
}

const severe = (events) => events.filter((e) => e.level >= 2);

function troubleSentences({ totals: t, missing, events }) {
  return [
    t.products_over_grant > 0 && `${counted(t.products_over_grant, 'product')} exceeded the byte grant. `,
    missing.length > 0 && `${counted(missing.length, 'part')} of the downlink ${missing.length === 1 ? 'has' : 'have'} not come: see below what and where. `,
    t.files_skipped > 0 && `${counted(t.files_skipped, 'file')} of the outbox could not be used. `,
    severe(events).length > 0 ? `${counted(severe(events).length, 'event')} of medium or high severity: see below what to do.` : 'No event above low severity was reported.',
  ];
}

const tile = (what, value, unit, how, kind = '') =>
  html`<div class="tile"><div class="what">${what}</div><div class="value ${kind}">${value}${unit && html` <small>${unit}</small>`}</div><div class="how">${how}</div></div>\n`;
const ofHeight = '% of height flown';

function tilesOf(a, whose) {
  const heights = [
    ['Height error, median', a.height_percent, 'merged heights'], ['Depth error, median', a.depth_percent, 'depths of single pixels'],
    ['Depth error, median keyframe', a.keyframe_depth_percent, 'each keyframe by its median pixel'],
  ];
  return [
    tile(`Position error, mean${whose}`, brief(a.position_mean_percent), '% of distance', `at most ${brief(a.position_max_percent)} %, ${counted(a.poses, 'pose')}`),
    heights.filter(([, value]) => known(value)).map(([what, value, how]) => tile(what + whose, brief(value), ofHeight, how)),
  ];
}

function accuracyTiles(accuracy) {
  if (!accuracy) return '';
  if (!accuracy.joined_model) return tilesOf(accuracy.strips, '');
  return [tilesOf(accuracy.joined_model, ', joined model'), accuracy.strips && tilesOf(accuracy.strips, ', strips on board')];
}

/// What the flight itself says of its errors; without truth it is all there is.
const statedTiles = ({ position_percent: p, height_percent: h }) => [
  p && tile('Position, estimated 1 σ', brief(p.median), ofHeight, `median of the keyframes; at most ${brief(p.max)} %`),
  h && tile('Heights, estimated 1 σ', brief(h.median), ofHeight, `median of the map; 95 % below ${brief(h.p95)} %; of ${h.parts}`),
];

function areaTile({ strips }) {
  const maps = strips.filter((s) => s.grid);
  if (maps.length === 0) return '';
  const largest = maps.reduce((a, b) => (b.grid.covered_area > a.grid.covered_area ? b : a));
  const { factor, name: unit } = largest.length_unit;
  return tile('Ground mapped', brief(times(factor * factor, largest.grid.covered_area)), `square ${unit}`,
    `in cells of ${brief(factor * largest.grid.map.cell)} ${unit}${maps.length > 1 ? `; the largest of ${maps.length} maps` : ''}`);
}

function costTiles({ totals: t, flight }) {
  const cpu = flight?.flight_cpu_s ?? flight?.cpu_s;
  const [bytes, peak] = [flight?.static_bytes, flight?.peak_rss_mib];
  return [
    tile('Downlinked products', bytesText(t.product_bytes), '', `${counted(t.products, 'file')}, ${brief(t.product_bits_per_pixel)} bit per keyframe pixel`),
    cpu != null && t.keyframes > 0 && tile('Processor per keyframe', durationText(cpu / t.keyframes), '', `${durationText(cpu)} in all`),
    (bytes != null || peak != null) && tile(bytes != null ? 'Static memory' : 'Peak memory', fixed(bytes != null ? bytes / 1048576 : peak, 1), 'MiB',
      bytes != null && peak != null ? `process peak ${fixed(peak, 0)} MiB` : flight.profile),
  ];
}

export function overview(report) {
  const { totals: t, strips, events, sentences } = report;
  const [all, high] = [severe(events).length, events.some((e) => e.level >= 3)];
  const posed = t.final_poses === 0 ? 'bad' : t.final_poses === t.keyframes ? 'good' : 'warn';
  return html`<header><p class="kicker">Aerobot imaging and localization: flight report</p><h1>${report.title}</h1><div class="sub">${subtitle(report)}</div>${
    report.viewer && html`<div><a href="viewer.html">Look at the flight in 3D</a></div>`}</header>
${sentences.nothing.map((line) => paragraph(line, 'bad'))}${sentences.camera.map((line) => paragraph(line, 'warn'))}
<p class="lede">${coverageSentence(report)}${accuracySentence(report)}${troubleSentences(report)}</p>
<div class="tiles">
${tile('Keyframes with final pose', t.final_poses, `of ${t.keyframes}`, `${counted(strips.length, 'strip')}, ${t.with_depth} with depth`, posed)}${
  areaTile(report)}${accuracyTiles(report.accuracy)}${statedTiles(report.estimated_errors)}${costTiles(report)}${
  tile('Events of medium or high severity', all, '', `${counted(events.length, 'event')} in all`, high ? 'bad' : all > 0 ? 'warn' : 'good')}</div>\n`;
}
