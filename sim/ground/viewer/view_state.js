// What is chosen and shown, and who wants to know when it changes.

export function makeState(flight) {
  const listeners = [];
  const state = {
    flight,
    strip: flight.strips[0] ?? null,
    layer: 'ortho',
    // Over a survey, links are a net that hides the ground.
    show: { track: true, links: flight.links.length > 0 && flight.links.length < flight.keyframes.length, fixes: flight.fixes.length > 0, footprints: true, uncertainty: false },
    exaggeration: 1,
    keyframe: null,  // selected
    span: null,      // [from, to] of the timeline, s
    place: null,     // { x, y }
    cursor: null,    // { x, y } of the keyboard
    profile: { a: null, b: null },
    measuring: false,

    onChange: (listener) => listeners.push(listener),
    /// Takes the changes over and gives their names to all listeners.
    set(changes) {
      const names = Object.keys(changes).filter((name) => state[name] !== changes[name]);
      if (names.length === 0) return;
      Object.assign(state, changes);
      for (const listener of listeners) listener(new Set(names));
    },
    inSpan: (k) => state.span !== null && k.time_s >= state.span[0] && k.time_s <= state.span[1],
    /// Ids that are highlighted: the span's keyframes, or the selected one.
    chosen() {
      if (state.span) return new Set(state.strip.members.filter(state.inSpan).map((k) => k.id));
      return new Set(state.keyframe ? [state.keyframe.id] : []);
    },
    /// Selects, and shows the strip that the keyframe is in.
    select(keyframe) {
      const strip = flight.strips.find((s) => s.id === keyframe?.strip);
      if (strip && strip !== state.strip) state.useStrip(strip);
      state.set({ keyframe });
    },
    useStrip(strip) {
      state.set({ strip, keyframe: null, place: null, cursor: null, profile: { a: null, b: null } });
    },
    step(by) {
      const all = flight.keyframes;
      if (!all.length) return;
      const at = state.keyframe ? all.indexOf(state.keyframe) : by > 0 ? -1 : all.length;
      state.select(all[Math.min(all.length - 1, Math.max(0, at + by))]);
    },
  };
  return state;
}
