// Clicks on the view: a camera, a place, or an end of the measured line.

export function takePlace(state, place) {
  if (!state.measuring) return state.set({ place });
  const { a, b } = state.profile;
  if (!a || b) state.set({ profile: { a: place, b: null } });
  else state.set({ profile: { a, b: place }, measuring: false });
}

export function listenToPointer(canvas, state, scene) {
  let down = null;
  canvas.addEventListener('pointerdown', (e) => { down = [e.offsetX, e.offsetY]; });
  canvas.addEventListener('click', (e) => {
    // The end of a turn is no click.
    if (down && Math.hypot(e.offsetX - down[0], e.offsetY - down[1]) > 4) return;
    const keyframe = state.measuring ? null : scene.pickCamera(e.offsetX, e.offsetY);
    if (keyframe) return state.select(keyframe);
    const place = scene.pick(e.offsetX, e.offsetY);
    if (place) takePlace(state, place);
  });
}
