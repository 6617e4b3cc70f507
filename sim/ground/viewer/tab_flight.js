// The flight in figures: strips, storage, link, what is missing.

import { storageFacts } from '../report/page/storage.js';
import { navigationText } from '../report/page/strips.js';
import { element, facts, brief, bytesText, percent, ordinal } from './text.js';

function stripFacts(strip) {
  const posed = strip.members.filter((k) => k.pose).length;
  return [
    element('h3', {}, `Strip ${strip.id}`),
    facts([
      ['Keyframes', `${posed} posed of ${strip.members.length}`],
      ['Track', known(strip.track_length, strip.unit)],
      ['Flown above ground', known(strip.flying_height, strip.unit)],
      strip.navigation && ['By navigation', navigationText(strip.navigation)],
      strip.covered_area && ['Ground mapped', `${brief(strip.covered_area)} ${strip.unit}²`],
      strip.grid && ['Map', `${strip.grid.full_width} × ${strip.grid.full_height} cells of ${brief(strip.grid.full_cell)} ${strip.unit}`],
      strip.grid && ['Shown here', `${strip.grid.covered.toLocaleString('en')} heights${strip.grid.stride > 1 ? `, every ${ordinal(strip.grid.stride)} cell` : ''}; orthoimage ${strip.grid.texture_stride > 1 ? `1 : ${strip.grid.texture_stride}` : 'in full'}`],
      ['Ended by', strip.end],
    ]),
  ];
}

// 0 is a length that is not known.
function known(length, unit) {
  return length > 0 ? `${brief(length)} ${unit}` : '–';
}

function landingFacts(strip, state) {
  if (!strip.landing) return [];
  const { sites } = strip.landing;
  const go = (site) => () => state.set({ place: { x: site.x, y: site.y } });
  return [
    element('h3', {}, `Landing sites of strip ${strip.id}`),
    sites.length === 0 ? element('p', { class: 'muted' }, 'No place is safe enough.') : null,
    element('div', { class: 'sites' }, ...sites.map((site, i) => element('button', {
      type: 'button', onclick: go(site),
    }, `${i + 1}: ${brief(site.slope_deg)}°, step ${brief(site.step_m)} m`))),
  ];
}

export function flightTab(state) {
  const { flight } = state;
  const { totals, timeline } = flight;
  const skipped = flight.files.filter((f) => f.fault !== null);
  const confirmed = timeline.link.filter((l) => l[2] >= 0).length;
  const problems = [...flight.remarks, ...skipped.map((f) => `${f.name}: ${f.fault}`)];
  return [
    ...flight.sentences.camera.map((line) => element('p', { class: 'warn' }, line)),
    element('p', { class: 'muted' }, 'Click the ground for a place, a camera for its keyframe; drag in the timeline for a span of time.'),
    ...flight.strips.flatMap(stripFacts),
    ...flight.strips.flatMap((strip) => landingFacts(strip, state)),
    element('h3', {}, 'Link'),
    facts([
      ['Came down', `${bytesText(totals.received_bytes)} in ${totals.files_used} files`],
      ['Products', bytesText(totals.product_bytes)],
      timeline.link.length > 0 && ['Files sent', `${timeline.link.length}, ${confirmed} confirmed`],
      ['Target overlap', percent(flight.target_overlap)],
    ]),
    timeline.storage && element('h3', {}, 'Storage on board, at its latest report'),
    timeline.storage && facts(storageFacts(timeline.storage)),
    problems.length > 0 && element('h3', {}, 'Missing or contradicting'),
    problems.length > 0 && element('ul', { class: 'remarks' }, ...problems.slice(0, 60).map((p) => element('li', {}, p)), problems.length > 60 ? element('li', {}, `and ${problems.length - 60} more, in report.html`) : null),
  ];
}
