// Events with what to do about them: of the whole flight, or of the chosen span of time.

import { element, seconds } from './text.js';

const most = 300;

export function eventsTab(state) {
  const { list, all } = state.flight.timeline.events;
  const { span } = state;
  const some = list.filter((e) => !span || (e.time_s >= span[0] && e.time_s <= span[1]));
  const shown = [...some].sort((p, q) => q.severity - p.severity || p.time_s - q.time_s).slice(0, most);
  return [
    element('h2', {}, 'Events'),
    element('p', { class: 'muted' }, span ? `${some.length} between ${seconds(span[0])} and ${seconds(span[1])}` : `${all} came down${list.length < all ? `; the ${list.length} most severe are in this page` : ''}`),
    element('ol', { class: 'events' }, ...shown.map((e) => element('li', { class: `severity-${e.severity}` },
      element('div', {}, element('span', { class: 'chip' }, e.severity_name), ` ${seconds(e.time_s)} · ${e.component}`),
      element('div', {}, e.text), element('div', { class: 'muted' }, e.advice)))),
    some.length > most ? element('p', { class: 'muted' }, `The ${most} most severe are listed.`) : null,
  ];
}
