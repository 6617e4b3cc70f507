// The page around the view: title, tools, the view itself, panel, timeline.

import { element, bytesText } from './text.js';
import { layersOf } from './layers.js';
import { helpDialog } from './help.js';

export function nothingPage(root, flight) {
  root.replaceChildren(element('main', { class: 'nothing' },
    element('p', { class: 'kicker' }, 'Aerobot imaging and localization'),
    element('h1', {}, flight.title),
    element('p', { class: 'lede' }, 'Nothing can be shown: of this flight nothing usable has come down yet.'),
    element('p', {}, flight.nothing),
    element('p', { class: 'muted' }, 'When files have arrived, run ilp-ground again: this page is then the flight.')));
  document.documentElement.dataset.ready = 'true';
}

const switches = [
  ['track', 'Track', 'T'],
  ['links', 'Links', 'L'],
  ['fixes', 'Fixes', 'M'],
  ['footprints', 'Footprints', 'F'],
  ['uncertainty', 'Uncertainty', 'U'],
];

export function buildPage(root, state) {
  const { flight } = state;
  const { totals } = flight;
  const said = element('div', { class: 'hidden', 'aria-live': 'polite' });
  const help = helpDialog(flight);
  const strips = element('select', { 'aria-label': 'Strip', onchange: (e) => state.useStrip(flight.strips[e.target.selectedIndex]) },
    ...flight.strips.map((s) => element('option', {}, `Strip ${s.id} · ${s.members.length} keyframes`)));
  const layerButtons = layersOf(flight).map((layer, i) => element('button', {
    type: 'button', role: 'radio', 'data-layer': layer.id, title: `${layer.name} (${i + 1})`, onclick: () => state.set({ layer: layer.id }),
  }, layer.name));
  const nothing = { links: 'This flight has no links', fixes: 'No strip of this flight stands on a map' };
  const none = (id) => id in nothing && !flight[id].length;
  const switchButtons = switches.map(([id, name, key]) => element('button', {
    type: 'button', 'data-show': id, disabled: none(id),
    title: none(id) ? nothing[id] : `${name} (${key})`, onclick: () => state.set({ show: { ...state.show, [id]: !state.show[id] } }),
  }, name));
  const slider = element('input', {
    id: 'exaggeration', type: 'range', 'aria-label': 'Vertical exaggeration', min: 1, max: 8, step: 0.5, oninput: (e) => state.set({ exaggeration: Number(e.target.value) }),
  });
  const factor = element('output', { for: 'exaggeration' });
  const measure = element('button', { type: 'button', title: 'Measure a profile between two points (P)', 'aria-pressed': 'false', onclick: () => state.set({ measuring: !state.measuring }) }, 'Profile');
  const views = element('div', { class: 'group views', role: 'group', 'aria-label': 'View' });
  const canvas = element('canvas', { id: 'view', tabindex: 0, role: 'application', 'aria-label': 'Terrain in 3D. Arrow keys move the cursor, Enter asks for the place, question mark for help.' });
  const stage = element('div', { class: 'stage' }, canvas, views);
  const panel = element('aside', { class: 'panel', 'aria-label': 'Details' });
  const timeline = element('section', { class: 'timeline', 'aria-label': 'Timeline of the flight' });
  const tools = element('div', { class: 'tools', role: 'toolbar', 'aria-label': 'What is shown' },
    element('div', { class: 'group', role: 'radiogroup', 'aria-label': 'Colour of the surface' }, ...layerButtons),
    element('div', { class: 'group', role: 'group', 'aria-label': 'Shown over it' }, ...switchButtons),
    element('label', { class: 'group slide', title: 'Vertical exaggeration (X, Shift+X)' }, 'Relief ×', factor, slider),
    element('div', { class: 'group' }, measure));
  const about = [`${totals.final_poses} of ${totals.keyframes} keyframes posed`, `${totals.with_depth} with depth`, `${bytesText(totals.received_bytes)} came down`].join(' · ');
  root.replaceChildren(
    element('a', { class: 'skip', href: '#view' }, 'To the view'),
    element('header', {},
      element('div', { class: 'title' }, element('h1', {}, flight.title), element('span', { class: 'muted' }, about)),
      flight.strips.length > 1 ? strips : null,
      element('a', { class: 'button', href: 'report.html' }, 'Report'),
      element('button', { type: 'button', onclick: () => help.showModal(), title: 'Help (?)' }, 'Help')),
    element('main', {}, element('div', { class: 'left' }, tools, stage), panel), timeline, said, help);

  const page = {
    root, canvas, stage, panel, timeline, help, views,
    say: (text) => { said.textContent = text; },
    withoutScene() {
      const { strip } = state;
      const picture = strip?.plan ? element('img', { src: strip.plan, alt: 'Orthoimage of the strip, turned so that the flight goes from left to right' }) : null;
      const why = strip ? 'This browser cannot draw in 3D (WebGL is missing or switched off), so the surface is shown from above.' : 'There is no strip to show: no keyframe has come down.';
      stage.replaceChildren(element('div', { class: 'without' }, element('p', { role: 'alert' }, why), picture));
      tools.hidden = true;
    },
    update() {
      strips.selectedIndex = flight.strips.indexOf(state.strip);
      const surface = Boolean(state.strip?.grid);
      for (const b of layerButtons) {
        b.setAttribute('aria-checked', b.dataset.layer === state.layer);
        b.tabIndex = b.dataset.layer === state.layer ? 0 : -1;
        b.disabled = !surface;
      }
      for (const b of switchButtons) b.setAttribute('aria-pressed', state.show[b.dataset.show]);
      measure.setAttribute('aria-pressed', state.measuring);
      measure.disabled = slider.disabled = !surface;
      slider.value = state.exaggeration;
      factor.textContent = ` ${state.exaggeration}`;
      canvas.classList.toggle('measuring', state.measuring);
    },
  };
  return page;
}
