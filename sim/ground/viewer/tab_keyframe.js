// One keyframe: pictures, where it was taken, what it found, its products.

import { element, facts, brief, fixed, percent, bytesText, seconds } from './text.js';
import { verdictOf } from './links.js';

const pictures = [['image', 'image'], ['depth', 'depth'], ['mask', 'newly seen']];

function gallery(keyframe) {
  return element('div', { class: 'pictures' }, ...pictures.map(([id, name]) => {
    const source = keyframe.thumbnails[id];
    const shown = source ? element('img', { src: source, alt: `${name} of keyframe ${keyframe.id}` }) : element('div', { class: 'none' }, `no ${name}`);
    return element('figure', {}, shown, element('figcaption', {}, name));
  }));
}

export function productFacts(name, product, depth) {
  if (!product) return [element('h3', {}, `${name} product`), element('p', { class: 'muted' }, 'Did not come down, and nothing says that it was made.')];
  const layers = product.layers === undefined ? 'not received' : `${product.layers}${product.layers_made ? ` of ${product.layers_made}` : ''}`;
  return [
    element('h3', {}, `${name} product`),
    facts([
      product.file && ['File', product.file],
      product.bytes !== undefined && ['Size', `${bytesText(product.bytes)}${product.grant_bytes ? ` of ${bytesText(product.grant_bytes)} granted` : ''}`],
      ['Layers', layers],
      product.quality > 0 && ['Quality', depth ? `${fixed(product.quality, 3)} px at most off` : `${fixed(product.quality, 1)} dB in what is new`],
      product.scheme && ['Coding', product.scheme],
    ]),
  ];
}

/// The other keyframes that show its ground; a button chooses one.
function linkList(state, keyframe) {
  const links = state.flight.links.filter((l) => l.keyframe === keyframe.id || l.place === keyframe.id);
  if (!links.length) return [];
  return [element('h3', {}, 'Links'), element('ul', { class: 'links' }, ...links.map((link) => {
    const other = state.flight.byId.get(link.keyframe === keyframe.id ? link.place : link.keyframe);
    const told = [verdictOf(link)?.name ?? 'unknown verdict', link.points > 0 && `${link.points} points, ${fixed(link.error_px, 2)} px off`, other && other.strip !== keyframe.strip && `in strip ${other.strip}`].filter(Boolean).join(', ');
    return element('li', {}, other ? element('button', { type: 'button', onclick: () => state.select(other) }, `Keyframe ${other.id}`) : element('span', {}, 'Keyframe not received'), ` ${told}`);
  }))];
}

export function keyframeTab(state) {
  const k = state.keyframe;
  if (!k) return [element('p', { class: 'muted' }, 'No keyframe is chosen. Click a camera, a mark of the timeline, or press ] for the first.')];
  const unit = state.strip?.unit ?? '';
  const p = k.pose;
  return [
    element('div', { class: 'heading' }, element('h2', {}, `Keyframe ${k.id}`),
      element('button', { type: 'button', onclick: () => state.step(-1), 'aria-label': 'previous keyframe' }, '‹'),
      element('button', { type: 'button', onclick: () => state.step(1), 'aria-label': 'next keyframe' }, '›')),
    element('p', { class: k.verdict.startsWith('ok') ? 'good' : 'warn' }, k.verdict),
    gallery(k),
    facts([
      ['Frame', `${k.name}${k.time_guessed ? '' : `, at ${seconds(k.time_s)}`}`],
      ['Overlap', percent(k.overlap)],
      p && ['Position', `${p.centre.map((v) => fixed(v, 3)).join(', ')} ${unit}`],
      p && ['Its sigma', Math.max(...p.sigma) > 0 ? `${p.sigma.map(brief).join(', ')} ${unit}` : 'fixes the origin, or not told'],
      p && p.matches > 0 && ['Matches', `${p.inliers} of ${p.matches} agree, ${fixed(p.rms_px, 2)} px rms`],
      p && p.parallax_px > 0 && ['Parallax', `${fixed(p.parallax_px, 1)} px`],
      ['Newly seen', percent(k.newly_seen)],
      ['Richness', fixed(k.richness, 3)],
    ]),
    ...linkList(state, k),
    ...productFacts('Image', k.image, false),
    ...productFacts('Depth', k.depth, true),
    element('p', { class: 'muted' }, `Full size beside this page: keyframes/${String(k.id).padStart(6, '0')}-image.png, -depth.pfm, -mask.png`),
  ];
}
