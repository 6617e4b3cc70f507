// The panel beside the view: one tab for each thing that can be asked about.

import { element } from './text.js';
import { keyframeTab } from './tab_keyframe.js';
import { placeTab } from './tab_place.js';
import { profileTab } from './tab_profile.js';
import { eventsTab } from './tab_events.js';
import { flightTab } from './tab_flight.js';

const tabs = [
  { id: 'flight', name: 'Flight', draw: flightTab, on: [] },
  { id: 'keyframe', name: 'Keyframe', draw: keyframeTab, on: ['keyframe'] },
  { id: 'place', name: 'Place', draw: placeTab, on: ['place', 'strip'] },
  { id: 'profile', name: 'Profile', draw: profileTab, on: ['profile', 'strip'] },
  { id: 'events', name: 'Events', draw: eventsTab, on: ['span'] },
];

export function makePanel(root, state, say) {
  let current = 'flight';
  const body = element('div', { class: 'body', role: 'tabpanel', id: 'panel-body', tabindex: 0 });
  const open = (id) => {
    current = id;
    for (const b of buttons) {
      b.setAttribute('aria-selected', b.dataset.tab === id);
      b.tabIndex = b.dataset.tab === id ? 0 : -1;
    }
    const tab = tabs.find((t) => t.id === id);
    body.setAttribute('aria-label', tab.name);
    body.replaceChildren(...tab.draw(state, say).filter(Boolean));
    body.scrollTop = 0;
  };
  const buttons = tabs.map((t) => element('button', { type: 'button', role: 'tab', 'data-tab': t.id, 'aria-controls': 'panel-body', onclick: () => open(t.id) }, t.name));
  root.append(element('div', { class: 'tabs', role: 'tablist', 'aria-label': 'Details' }, ...buttons), body);
  return {
    update(names) {
      if (names.has('keyframe') && state.keyframe) return open('keyframe');
      if (names.has('place') && state.place) return open('place');
      if (names.has('profile') && state.profile.a) return open('profile');
      const tab = tabs.find((t) => t.id === current);
      if (names.size === 0 || tab.on.some((n) => names.has(n))) open(current);
    },
  };
}
