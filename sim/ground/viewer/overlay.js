// What lies over the view: legend, scale bar, the world's axes, hints.

import { element, svg, brief, ordinal } from './text.js';
import { layersOf } from './layers.js';
import { verdicts } from './links.js';

function niceLength(wanted) {
  const decade = 10 ** Math.floor(Math.log10(wanted));
  return decade * (wanted >= 5 * decade ? 5 : wanted >= 2 * decade ? 2 : 1);
}

export function makeOverlay(page, state, scene) {
  const legend = element('div', { class: 'legend' });
  const bar = element('div', { class: 'bar' });
  const barText = element('span', {});
  const needle = svg('g', {}, svg('path', { d: 'M0 -17 L5 4 L0 0 L-5 4 Z', fill: 'currentColor' }));
  const axis = svg('text', { 'text-anchor': 'middle', 'font-size': 11, y: 4 });
  axis.textContent = 'y';
  const compass = svg('svg', { viewBox: '-28 -28 56 56', width: 56, height: 56, role: 'img', 'aria-label': "direction of the world's y axis" }, needle, axis);
  const hint = element('div', { class: 'hint', hidden: true });
  page.stage.append(legend, element('div', { class: 'scale' }, compass, element('div', {}, barText, bar)), hint);

  for (const [name, title, kind] of [['Oblique', 'First view (0)', 'oblique'], ['Top', 'From above (9)', 'top']]) {
    page.views.append(element('button', { type: 'button', title, onclick: () => scene?.home(kind) }, name));
  }

  const swatch = ([colour, text]) => element('span', { class: 'key' }, element('i', { style: `background:${colour}` }), text);
  const stroke = (verdict, count) => element('span', { class: 'key' },
    element('i', { class: verdict.dashed ? 'stroke dashed' : 'stroke', style: `border-color:#${verdict.colour.toString(16).padStart(6, '0')}` }), `${verdict.name} (${count})`);
  // One key for each look that links of the strip have.
  function linkKeys() {
    const count = scene?.track?.links?.count;
    if (!state.show.links || !count) return [];
    const keys = verdicts.filter((v) => count[v.id]).map((v) => stroke(v, count[v.id]));
    return keys.length ? [element('div', { class: 'keysrow links' }, element('span', {}, 'Links:'), ...keys)] : [];
  }
  function fixKeys() {
    const fixes = scene?.track?.fixes;
    if (!state.show.fixes || !fixes?.keys.length) return [];
    const keys = fixes.keys.map(({ name, count, colour }) => stroke({ name, colour }, count));
    return [element('div', { class: 'keysrow links' }, element('span', {}, `Fixes on the map, one sigma × ${fixes.enlarged}:`), ...keys)];
  }
  function drawLegend(made) {
    if (!made) return legend.replaceChildren(element('p', {}, state.strip?.grid ? '' : 'No depth of this strip has come down: there is its track, but no surface.'), ...linkKeys(), ...fixKeys());
    const layer = layersOf(state.flight).find((l) => l.id === state.layer);
    const parts = [element('b', {}, layer.name)];
    if (made.legend?.kind === 'ramp') {
      parts.push(element('div', { class: 'ramp', style: `background:${made.legend.gradient}` }),
        element('div', { class: 'ends' }, element('span', {}, made.legend.low), element('span', {}, made.legend.high)));
    } else if (made.legend) {
      parts.push(element('div', { class: 'keysrow' }, ...made.legend.keys.map(swatch)));
    }
    parts.push(element('p', {}, made.about));
    const { grid } = state.strip;
    if (grid.laid) parts.push(element('div', { class: 'keysrow' }, swatch(['rgb(214,130,70)', 'hatched: no height; the image is laid on interpolated ground'])));
    const thinned = grid.stride > 1 ? `every ${ordinal(grid.stride)} cell shown, ` : '';
    parts.push(element('p', { class: 'muted' }, `${thinned}cell ${brief(grid.cell)} ${state.strip.unit}, relief × ${state.exaggeration}`));
    if (state.show.uncertainty && scene?.track?.enlarged) parts.push(element('p', { class: 'muted' }, `Blue: one sigma of the camera's position, × ${scene.track.enlarged}`));
    legend.replaceChildren(...parts, ...linkKeys(), ...fixKeys());
  }

  let made = null;
  const overlay = {
    legend(next) {
      made = next;
      drawLegend(made);
    },
    draw() {
      if (!scene || !state.strip) return;
      const unit = scene.scale();
      const length = niceLength(140 * unit);
      bar.style.width = `${(length / unit).toFixed(0)}px`;
      barText.textContent = `${brief(length)} ${state.strip.unit}`;
      // Of north where it is known, else of the world's y axis.
      const [x, y] = state.strip.place?.north ?? [0, 1];
      axis.textContent = state.strip.place ? 'N' : 'y';
      const angle = ((scene.azimuth() + Math.atan2(x, y)) * 180) / Math.PI;
      needle.setAttribute('transform', `rotate(${angle.toFixed(1)})`);
      const r = (angle * Math.PI) / 180;
      axis.setAttribute('transform', `translate(${(23 * Math.sin(r)).toFixed(1)} ${(-23 * Math.cos(r)).toFixed(1)})`);
    },
  };
  state.onChange((names) => {
    if (names.has('exaggeration') || names.has('show')) drawLegend(made);
    hint.hidden = !state.measuring;
    hint.textContent = state.profile.a && !state.profile.b ? 'Profile: now its end' : 'Profile: choose its beginning';
  });
  return overlay;
}
