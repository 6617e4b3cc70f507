// Keyframes one by one: a table of numbers and a gallery of pictures.

import { html, table, styled, aside, fixed, brief, percent, bytesText, largest } from './text.js';

function bytesOfGrant(product) {
  if (!product) return '–';
  const share = product.grant_bytes && aside(percent(product.bytes / product.grant_bytes, 0));
  return styled([bytesText(product.bytes), share], product.within_grant === false ? 'bad' : '');
}

/// Title, value, and class. A pose read from a product's metadata has no statistics with it.
function columnsOf(report) {
  const ofMatches = (text) => (k) => (k.pose && (k.pose.matches > 0 || k.pose.inliers > 0) ? text(k.pose) : '–');
  const has = (value) => report.keyframes.some(value);
  const columns = [
    ['keyframe', (k) => k.id],
    ['strip', (k) => k.strip],
    ['frame', (k) => k.name, 't'],
    ['overlap', (k) => (k.index > 0 ? percent(k.overlap_with_previous, 1) : '–')],
    ['matches', ofMatches((p) => p.matches)],
    ['inliers', ofMatches((p) => p.inliers)],
    ['rms\npx', ofMatches((p) => fixed(p.rms_px, 2))],
    ['parallax\npx', ofMatches((p) => fixed(p.parallax_px, 1))],
    ['position\n1 σ', (k) => (k.pose ? brief(largest(k.pose.sigma)) : '–')],
    ['new\nterrain', (k) => (k.newly_seen_px === null ? '–' : percent(k.newly_seen_px / (k.width * k.height), 0))],
    ['richness', (k) => fixed(k.richness?.index, 3)],
    ['image\nof grant', (k) => bytesOfGrant(k.image_product)],
    ['depth\nof grant', (k) => bytesOfGrant(k.depth_product)],
  ];
  if (has((k) => k.image_psnr_db)) columns.push(['PSNR in\nmask, dB', (k) => fixed(k.image_psnr_db?.inside_mask, 1)]);
  if (report.has_reference) columns.push(['position\nerror', (k) => brief(k.error?.position)]);
  if (has((k) => k.error?.depth)) {
    columns.push(['height\nerror', (k) => (k.error?.depth ? `${brief(k.error.depth.median_abs_percent)} %` : '–')]);
  }
  columns.push(['verdict', (k) => styled(k.verdict, k.verdict.startsWith('ok') ? 't good' : 't w warn'), 't']);
  return columns;
}

export function keyframeTable(report) {
  const columns = columnsOf(report);
  return html`<h2>Keyframes</h2>
${table(columns.map(([title, , kind]) => [title, kind]), report.keyframes.map((k) => columns.map(([, value]) => value(k))), 'scroll keyframes')}
<p class="note">Overlap and parallax are with the previous keyframe; rms is the reprojection error of the adjustment window; 1 σ is the largest axis, in strip units.</p>\n`;
}

const picture = (source, name, { width, height }) =>
  (source ? html`<img loading="lazy" alt="${name}" width="${width}" height="${height}" src="${source}">` : html`<div class="none">no ${name}</div>`);

export function gallery(report, pictures) {
  const frame = (k) => html`<div class="frame"><b>${k.id}</b> <span class="sub">${k.name}</span><div class="row">${
    ['image', 'depth', 'mask'].map((name) => picture(pictures.keyframes[k.id]?.[name], name, k))}</div></div>\n`;
  return html`<h2>Keyframe pictures</h2>
<p class="note">As decoded from the downlink: image, depth (dark is near, each keyframe with its own colours), newly seen terrain.</p>
<div class="frames">\n${report.keyframes.map(frame)}</div>\n`;
}
