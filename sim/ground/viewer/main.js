// The viewer's page: reads the flight, builds the page, and keeps its parts in step.

import { readFlight } from './data.js';
import { makeState } from './view_state.js';
import { makeScene } from './scene.js';
import { buildPage, nothingPage } from './page.js';
import { makeTimeline } from './timeline.js';
import { makePanel } from './panel.js';
import { makeOverlay } from './overlay.js';
import { listenToKeys } from './keyboard.js';
import { listenToPointer } from './pointer.js';
import { rangeOf } from './grid.js';
import { reliefOf } from './layers.js';
import { heightAt, sigmaAt, profileOf } from './grid.js';

// Relief that shows without shouting: until a tenth of the slopes is steeper than about 20 degrees.
function sensibleExaggeration(strip) {
  if (!strip?.grid) return 1;
  const relief = reliefOf(strip);
  const { width, cell } = strip.grid;
  const slopes = relief.map((z, c) => (c % width ? Math.abs(z - relief[c - 1]) / cell : NaN));
  const steep = rangeOf(slopes, 0.5, 0.9)[1];
  return steep > 0 ? Math.min(5, Math.max(1, Math.round((2 * 0.3) / steep) / 2)) : 1;
}

async function start() {
  const flight = readFlight();
  const root = document.getElementById('app');
  if (flight.nothing) return nothingPage(root, flight);
  const state = makeState(flight);
  const page = buildPage(root, state);
  const scene = state.strip ? makeScene(page.canvas, state, () => overlay.draw()) : null;
  const overlay = makeOverlay(page, state, scene);
  if (!scene) page.withoutScene();
  const timeline = makeTimeline(page.timeline, state, page.say);
  const panel = makePanel(page.panel, state, page.say);
  state.set({ exaggeration: sensibleExaggeration(state.strip) });

  async function showStrip() {
    if (!scene) return;
    await scene.useStrip(state.strip);
    scene.resize();
    scene.home();
    scene.exaggerate();
    scene.track.highlight?.(state.chosen());
    overlay.legend(scene.paint());
  }

  state.onChange(async (names) => {
    if (scene) {
      if (names.has('strip')) await showStrip();
      if (!scene.track) return;
      if (names.has('show')) scene.track.show?.(state.show);
      if (names.has('exaggeration')) scene.exaggerate();
      if (names.has('keyframe') || names.has('span')) {
        scene.track.highlight(state.chosen());
        if (state.layer === 'mask') overlay.legend(scene.paint());
      }
      if (names.has('layer') || names.has('strip')) overlay.legend(scene.paint());
      if (['place', 'cursor', 'profile'].some((n) => names.has(n))) scene.placeMarks();
      scene.request();
    }
    page.update(names);
    timeline.update(names);
    panel.update(names);
  });
  listenToKeys(page, state, scene);
  if (scene) listenToPointer(page.canvas, state, scene);
  await showStrip();
  page.update(new Set());
  timeline.update(new Set());
  panel.update(new Set());
  // For scripts that look at the page from outside.
  window.ilpViewer = { state, scene, flight, timeline, heightAt, sigmaAt, profileOf, ready: true };
  document.documentElement.dataset.ready = 'true';
}

start().catch((error) => {
  console.error(error);
  const root = document.getElementById('app');
  root.textContent = `This page cannot be shown: ${error.message}`;
});
