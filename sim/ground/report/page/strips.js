// The strips: joined in one model, placed by control points or on a map, with their pictures, landing sites and errors.

import { html, table, styled, paragraph, fixed, brief, percent, times, degrees, counted } from './text.js';
import { lineAt, textAt, pathOf, dotAt } from './plot.js';
import { figureOf, placeIn, trackOf, arrow, legend, cased, numberAbove } from './figures.js';

const sentencesOf = (lines) => lines.map((line) => paragraph(`${line}.`));
const list = (ids) => ids.join(', ');

/// Points in a part of a picture, to scale, with +y upwards.
function planOf(points, left, width, height) {
  const range = (axis) => [Math.min(...points.map((p) => p[axis])), Math.max(...points.map((p) => p[axis]))];
  const [[x0, x1], [y0, y1]] = [range(0), range(1)];
  const scale = 0.86 * Math.min(x1 > x0 ? width / (x1 - x0) : 1e9, y1 > y0 ? height / (y1 - y0) : 1e9);
  return ([x, y]) => [left + 0.5 * width + (x - 0.5 * (x0 + x1)) * scale, 0.5 * height - (y - 0.5 * (y0 + y1)) * scale];
}

function byStrip(members) {
  const strips = new Map();
  for (const m of members) strips.set(m.strip, [...(strips.get(m.strip) ?? []), m]);
  return [...strips].sort(([a], [b]) => a - b);
}

/// On the left each strip in its own world, on the right all in one, with the links.
function tracks(model) {
  const [width, height] = [1200, 420];
  const before = byStrip(model.keyframes.filter((m) => m.posed_by_flight));
  const part = 0.5 * width / Math.max(1, before.length);
  const right = planOf(model.keyframes.map((m) => m.centre), 0.5 * width, 0.5 * width, height);
  const places = new Map(model.keyframes.map((m) => [m.keyframe, right(m.centre)]));
  const track = (points) => [pathOf('track', points), points.map(([x, y]) => dotAt('stop', x, y, 3))];
  return html`<figure><svg viewBox="0 0 1200 420" role="img" aria-label="tracks before and after joining"><rect width="1200" height="420" fill="#20262e"/>${
    before.map(([strip, members], i) => {
      const plan = planOf(members.map((m) => m.centre_by_flight), i * part, part, height);
      return [track(members.map((m) => plan(m.centre_by_flight))), textAt('number', (i + 0.5) * part, 16, 'middle', `strip ${strip}`)];
    })}${
    model.links.filter((l) => places.has(l.place) && places.has(l.keyframe)).map((l) => lineAt('stem', ...places.get(l.place), ...places.get(l.keyframe)))}${
    byStrip(model.keyframes).map(([, members]) => track(members.map((m) => places.get(m.keyframe))))}</svg><figcaption>Left: the strips as the flight states them, each in its own world. Right: the same keyframes in one model; thin lines are links.</figcaption></figure>\n`;
}

function heightSteps({ before, after }) {
  const told = (s) => `${brief(s.median_percent)} % of the flying height in the median and ${brief(s.p95_percent)} % in 95 of 100 cases`;
  if (after.samples === 0) return '';
  return paragraph(`Where two passes have depths of the same ground, their heights differ by ${told(after)} (${counted(after.samples, 'place')} of ${counted(after.pairs, 'pair')} of keyframes)${
    before.samples > 0 ? `; by the poses of the flight it was ${told(before)} (${counted(before.samples, 'place')})` : ''}.`);
}

const linksTable = (links) => links.length > 0 && html`<details><summary>Links</summary>${
  table(['keyframe', 'sees ground of', 'strips', 'points in common', "error by the flight's poses, px", 'in the model, px'],
    links.map((l) => [l.keyframe, l.place, list(l.strips), l.points, l.error_by_flight_px === null ? '' : brief(l.error_by_flight_px), l.error_px === null ? '' : brief(l.error_px)]))}</details>\n`;

/// Nothing where no link came down.
export function joined(report) {
  if (!report.joined) return '';
  const { models, apart } = report.joined;
  return html`<h2>One model</h2>\n${models.map((m) => [
    html`<p>${counted(m.keyframes.length, 'keyframe')} of strip${m.strips.length > 1 ? 's' : ''} ${list(m.strips)} stand in one model, shown as strip ${m.strip}: ${counted(m.points, 'point')} seen ${m.sightings} times, median error ${brief(m.median_error_px)} px.${
      m.by_ties && " Some strips stand where the flight's ties put them, because no points join them."}</p>\n`,
    tracks(m), heightSteps(m.height_steps), linksTable(m.links)])}${
    apart.map((s) => paragraph(`Strip ${s.strip} stays apart with ${counted(s.keyframes, 'keyframe')}: ${s.why}.`, 'note'))}`;
}

function controlRow(p) {
  const role = p.used ? 'used' : p.check && p.fault === null ? 'check point' : styled('not used', 't warn');
  return [p.name, role, p.marks, fixed(p.rms_px, 2), ...[0, 1, 2].map((axis) => fixed(p.residual_m?.[axis], 3)),
    p.residual_m ? brief(Math.hypot(...p.residual_m)) : '–', brief(p.expected_m), p.fault];
}

/// Nothing without control points.
export const control = (report) => report.control && html`<h2>Control points</h2>
<p class="note">The map was placed, scaled and levelled by the points that are used; they take precedence over the vehicle's navigation. Check points are only measured. Residuals are the place on the map minus the surveyed one. Expected: one sigma that the survey and marks of one pixel explain.</p>
${sentencesOf(report.sentences.control)}${report.control.map((strip) => html`<h3>Strip ${strip.strip}</h3>${
  table([['Point', 't'], ['Role', 't'], 'marks', 'rms, px', 'x or east, m', 'y or north, m', 'up, m', 'all, m', 'expected, m', ['', 't w']], strip.points.map(controlRow))}`)}`;

function fixRow(f) {
  const start = [f.keyframe, f.verdict, f.state === 'none' ? '' : f.state];
  if (f.evidence === undefined) return [...start, ...Array(10).fill('')];
  const compared = [...start, f.sense, f.prior, `${brief(f.evidence)} (${f.votes} of ${f.patches})`];
  if (f.ground_m === undefined) return [...compared, ...Array(7).fill('')];
  const place = f.longitude_deg === null ? `${fixed(f.ground_m[0], 1)}, ${fixed(f.ground_m[1], 1)} m` : `${fixed(f.longitude_deg, 6)}°, ${fixed(f.latitude_deg, 6)}°`;
  const metres = (value) => (value === null ? '' : brief(value));
  return [...compared, brief(f.pixel_m * Math.hypot(...f.shift_px)), brief(f.shift_sigmas), place, `${brief(f.sigma_major_m)} x ${brief(f.sigma_minor_m)}`,
    metres(f.off_by_vehicle_m), metres(f.off_by_first_fixes_m), metres(f.off_by_all_fixes_m)];
}
const fixColumns = ['keyframe', ['verdict', 't'], ['counts', 't'], ['compared', 't'], ['searched by', 't'], 'evidence\n(votes)', 'shift from\nthe prior, m',
  'the same,\nsigmas', 'ground point', 'error\nellipse, m', 'off by the\nvehicle, m', 'off by first\nfixes, m', 'off by all\nfixes, m'];

/// Such that ellipses are seen: 1, 2, 5, 10, ...
function magnification(fixed, unitPerPx) {
  const sizes = fixed.map((f) => f.sigma_major_m).sort((a, b) => a - b);
  const wanted = 14 * unitPerPx / Math.max(sizes[sizes.length >> 1] ?? 0, 1e-9 * unitPerPx);
  let factor = 1;
  for (let i = 0; i < 30 && factor < wanted; ++i) factor *= i % 3 === 1 ? 2.5 : 2;
  return factor;
}

/// The ground point, with its error `factor` times larger.
function fixCross(fix, contradicts, view, factor) {
  const [x, y] = placeIn(view)(fix.ground_m).map((v) => fixed(v, 1));
  const [xx, xy, yy] = fix.ground_covariance_m2;
  const turn = -degrees(0.5 * Math.atan2(xy, 0.5 * (xx - yy)));
  const colour = contradicts ? '#d33a2c' : fix.state === 'accepted' ? '#58b06a' : '#e08a3c';
  const radius = (sigma) => fixed(factor * sigma / view.unit_per_px, 1);
  return html`<g stroke="${colour}" stroke-width="1.6"><title>keyframe ${fix.keyframe}</title><ellipse cx="${x}" cy="${y}" rx="${radius(fix.sigma_major_m)}" ry="${radius(fix.sigma_minor_m)}" transform="rotate(${fixed(turn, 1)} ${x} ${y})" fill="${colour}" fill-opacity="0.2"/><path d="M${x} ${y}m-7 0h14m-7 -7v14"/></g>`;
}

/// Nothing where no fix places the strip.
function fixFigure(report, strip, picture) {
  if (!picture) return '';
  const { view } = picture;
  const { by_vehicle: byVehicle, by_first_fixes: byFirst, by_all_fixes: byAll } = strip.tracks_m;
  const placed = strip.keyframes.filter((f) => f.ground_m);
  const factor = magnification(placed, view.unit_per_px);
  const wrong = new Set((report.joined?.models ?? []).flatMap((m) => m.on_map?.fixes ?? []).filter((f) => !f.used).map((f) => f.keyframe));
  const line = (track, kind) => track.length > 0 && cased(track.map(placeIn(view)), kind);
  return figureOf(picture, {
    label: `track and fixes of strip ${strip.strip} on the map`, unit: 'm',
    marks: [line(byVehicle, 'track dotted'), line(byFirst, 'track dashed'), line(byAll, 'track'), placed.map((f) => fixCross(f, wrong.has(f.keyframe), view, factor))],
    caption: [`Strip ${strip.strip} on the map, north up. `,
      picture.href && "Grey is the map's image, and what is dark lies beside it. ",
      picture.other_map && `The map of --map is another one (${picture.other_map}), so its image is not shown. `,
      'The line is the track where all fixes put it', byFirst.length > 0 && '; dashed is where the first of them and the images alone lead',
      byVehicle.length > 0 && "; dotted is where the vehicle's measurements alone put it",
      `. Crosses are the ground points of the fixes, each with the ellipse of its error, one sigma, ${brief(factor)} times larger than it is: green counts, orange was not confirmed in flight, red contradicts the others and counts as nothing.`],
  });
}

/// Nothing where no fix record came down.
export const fixes = (report, pictures) => report.fixes && html`<h2>Place on the map</h2>
${sentencesOf(report.sentences.fixes)}${report.fixes.strips.map((s) => html`${
  s.map_sigma_m > 0 && paragraph(`Map ${s.map ?? '–'} as a whole may be off by ${brief(s.map_sigma_m)} m on the body (one sigma to each side), which is common to all fixes and not in their errors.`, 'note')}${
  fixFigure(report, s, pictures.figures[`fixes ${s.strip}`])}<details><summary>Fixes of strip ${s.strip}</summary>${table(fixColumns, s.keyframes.map(fixRow))}</details>\n`)}${
  sentencesOf(report.sentences.on_map)}`;

/// How well the vehicle has measured where the strip is, one sigma.
export function navigationText(n) {
  const told = (name, value, unit) => (value > 0 ? `${name} ${brief(value)}${unit}` : `${name} not known`);
  return `${[told('scale', times(100, n.scale_sigma), ' %'), told('tilt', degrees(n.tilt_sigma_rad), '°'), told('heading', degrees(n.heading_sigma_rad), '°'),
    told('place', n.horizontal_sigma_m, ' m')].join(', ')} (one sigma; ${n.verdict})${n.refused > 0 ? `; ${counted(n.refused, 'measurement')} left out` : ''}`;
}

function stripFacts(s) {
  const { factor, name: unit } = s.length_unit;
  const length = (value) => `${brief(times(factor, value))} ${unit}`;
  const { grid, model } = s;
  return html`<p>${s.final_poses} of ${counted(s.keyframes, 'keyframe')} posed${s.track_length > 0 && `, ${length(s.track_length)} flown`}${
    s.flying_height > 0 && ` at ${length(s.flying_height)} above the ground`}${
    grid && `; ${brief(times(factor * factor, grid.covered_area))} square ${unit} mapped in cells of ${length(grid.map.cell)}`}${
    grid?.seams.cells > 0 && `, heights at the seams of its patches ${length(grid.seams.step_median)} apart (median; 95 % below ${brief(times(factor, grid.seams.step_p95))})`}${
    s.newly_seen_share > 0 && `; ${percent(s.newly_seen_share, 0)} of the keyframes' pixels sent as new terrain`}${s.end !== null && `. The strip ended: ${s.end}`}.</p>
<p class="note">${model && html`Surface <code>${s.surface_file}</code>: ${model.vertices} vertices, ${model.faces} faces, ${model.cell_stride === 1 ? 'all cells' : `one cell in ${model.cell_stride} each way`}. `}${
  s.colmap && html`COLMAP model <code>${s.colmap.folder}</code>: ${s.colmap.images} images, ${s.colmap.points} points. `}${s.place_text && `Place: ${s.place_text}. `}${
  s.files.length > 0 && html`For other tools:${s.files.map((name) => html` <a href="${name}">${name}</a>`)}. `}${
  unit === 'units' && "The scale is the strip's own: its first baseline is 1."}${s.navigation && `By the vehicle's navigation: ${navigationText(s.navigation)}. `}</p>\n`;
}

function stripFigures(report, strip, picture) {
  if (!picture) return paragraph('No depth came down for this strip: there is no terrain to show.', 'note');
  const { view, heights, north } = picture;
  const track = report.keyframes.filter((k) => k.strip === strip.id && k.pose?.state === 'final').map((k) => [k.id, k.pose.centre]);
  const direction = arrow(view, north ?? [0, 1], north ? 'N' : 'y');
  return [
    figureOf(picture, {
      label: `orthoimage of strip ${strip.id} with the track`, unit: strip.unit, marks: trackOf(view, track), frame: direction,
      caption: ['Orthoimage, turned so that the flight goes from left to right. The line is the track, the numbers are keyframes. Contrast stretched over the central 98 % of the grey values.',
        picture.laid && ' Hatched: no height was measured; the image is laid on interpolated ground.', ' Blank: nothing was sent.'],
    }),
    figureOf(heights, {
      label: `heights of strip ${strip.id}`, unit: strip.unit, frame: [legend(heights, `Height above the mean plane, ${strip.unit}`), direction],
      caption: `Heights above the mean plane, shaded from the upper left (slopes ${brief(heights.exaggeration)} times steeper than they are).`,
    })];
}

export function strips(report, pictures) {
  const posed = report.strips.filter((s) => s.final_poses > 0);
  const without = report.strips.filter((s) => s.final_poses === 0).map((s) => s.id);
  const figures = (s) => stripFigures(report, s, pictures.figures[`strip ${s.id}`]);
  const reason = report.camera_frozen === false
    ? 'the camera was not found, so nothing is mapped.'
    : 'no two of their keyframes could be related, so nothing is mapped. See the keyframes for the reasons.';
  return html`${posed.map((s) => html`<h2>Strip ${s.id}</h2>\n${stripFacts(s)}${figures(s)}`)}${
    without.length > 0 && html`<h2>Strips without a pose</h2>\n${paragraph(`${list(without)}: ${reason}`)}`}`;
}

function landingFigure(site, unit, picture) {
  const radius = Math.max(5, picture.footprint_px / 2);
  return figureOf(picture, {
    label: `probability of a safe landing on strip ${site.strip}`, unit, frame: legend(picture, 'Probability of a safe landing, 0 to 1'),
    marks: site.sites.map((one, i) => {
      const [x, y] = placeIn(picture.view)(one.place);
      return [dotAt('track dark', x, y, radius), dotAt('track', x, y, radius, `rank ${i + 1}`), numberAbove([x, y - radius], i + 1)];
    }),
    caption: 'Probability that a lander is safe with its footprint there. Grey: the footprint is not covered by heights. Circles: the best sites, by rank.',
  });
}

function landingOf(site, unit, picture) {
  const head = html`<h3>Landing sites of strip ${site.strip}</h3>\n`;
  if (site.fault) return [head, paragraph(`No sites can be found: ${site.fault}.`, 'warn')];
  return html`${head}<p>A footprint of ${brief(site.footprint_m)} m is safe where its plane is at most ${brief(site.slope_deg)}° steep and the ground within it rises and falls by at most ${brief(site.step_m)} m about that plane.${
    site.sites.length === 0 && ` No place is safe with a probability of ${percent(site.least_safe, 1)}.`}</p>
${picture && landingFigure(site, unit, picture)}${site.sites.length > 0 && html`${
  table(['Rank', 'safe, %', 'slope, °', 'roughness, m', 'step, m', 'x', 'y', 'z'], site.sites.map((one, i) =>
    [i + 1, fixed(times(100, one.safe), 2), fixed(one.slope_deg, 1), brief(one.roughness_m), brief(one.step_m), ...one.place.map((v) => fixed(v, 1))]))}
<p class="note">Rank by the probability; x, y, z in the strip's own axes. Measured on the map: the true slope and step differ within their errors, which the probability has in it. <code>landing-sites.geojson</code> has the places for other tools.</p>\n`}`;
}

/// Nothing where no landing sites were asked for.
export const landing = (report, pictures) =>
  report.landing && html`<h2>Landing sites</h2>\n${report.landing.map((site) => landingOf(site, report.strips.find((s) => s.id === site.strip)?.unit, pictures.figures[`landing ${site.strip}`]))}`;

const errorRow = (name, e) => [name, brief(e.mean), brief(e.rms), brief(e.max), ...['mean_percent_of_length', 'rms_percent_of_length', 'max_percent_of_length',
  'mean_percent_of_extent', 'max_percent_of_extent'].map((key) => `${brief(e[key])} %`)];

function accuracyOf({ id, accuracy: a }) {
  return html`<h3>Strip ${id}</h3><p>${counted(a.poses, 'pose')} over ${brief(a.length)} reference units of flight (extent ${brief(a.extent)}); one strip unit is ${brief(a.scale_reference_from_strip)} reference units.${
    a.too_few && html` <span class="warn">With so few poses the alignment absorbs most of the error.</span>`}</p>
${table([['Camera positions', 't'], 'mean', 'rms', 'max', 'mean,\nof length', 'rms,\nof length', 'max,\nof length', 'mean,\nof extent', 'max,\nof extent'],
    [errorRow('aligned by positions', a.position), errorRow('turned by attitudes', a.position_with_attitude)])}
<p>Attitude error: mean ${brief(degrees(a.rotation_rad.mean))}°, max ${brief(degrees(a.rotation_rad.max))}°.${
  a.on_map && ` On the map, without any alignment, cameras are off by ${brief(a.on_map.position_m.median)} m in the median and ${brief(a.on_map.position_m.max)} m at most.`}${
  a.depth_median_abs_percent_of_flying_height && ` Median absolute height error per keyframe, in per cent of the flying height: mean ${brief(a.depth_median_abs_percent_of_flying_height.mean)}, worst ${brief(a.depth_median_abs_percent_of_flying_height.max)}.`}</p>\n`;
}

/// Nothing without a reference.
export function accuracy(report) {
  if (!report.has_reference) return '';
  const measured = report.strips.filter((s) => s.accuracy);
  return html`<h2>Errors against the reference</h2>
<p class="note">Positions after a similarity alignment (Umeyama). The second line takes the rotation from the attitudes instead, so that a track turned about itself is not forgiven. Length is the path over the reference positions, extent their largest distance.${
  report.joined?.models.length > 0 && " The poses are those of the ground's model; the scores are of the poses as the flight sent them."}</p>
${measured.length > 0 ? measured.map(accuracyOf) : paragraph('No strip has two poses whose images are named in the reference.', 'warn')}`;
}
