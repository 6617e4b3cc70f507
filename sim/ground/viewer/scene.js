// The 3D view of one strip: draws when something has changed, and finds the place under the pointer.

import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { makeTerrain } from './terrain.js';
import { makeTrack } from './track.js';
import { makeMarks } from './marks.js';
import { planeAt, heightAt } from './grid.js';
import { layersOf, reliefOf } from './layers.js';

THREE.ColorManagement.enabled = false;

// A machine without a graphics processor has no time for smooth edges.
function drawnByProcessor() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/// Null where the browser cannot.
export function makeScene(canvas, state, overlay) {
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ canvas, antialias: !drawnByProcessor(), alpha: true });
  } catch {
    return null;
  }
  renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(38, 1, 0.1, 1000);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, canvas);
  controls.enableDamping = false;
  controls.maxPolarAngle = 0.495 * Math.PI;
  controls.screenSpacePanning = false;
  controls.listenToKeyEvents = () => {};

  const view = { renderer, camera, controls, terrain: null, track: null, marks: null, frames: 0, frameMs: 0, drawn: null };
  let origin = [0, 0];
  let extent = 1;
  let pending = false;
  let lost = false;
  let turned = false;
  let untouched = null;  // the kind of a whole view that nobody has moved yet
  let coarse = false;
  const timing = { slow: false, turning: false, last: 0, average: 16 };

  const request = () => {
    if (pending || lost) return;
    pending = true;
    requestAnimationFrame(draw);
  };
  view.request = request;

  function draw(now) {
    pending = false;
    const begun = performance.now();
    const turning = turned;
    turned = false;
    if (turning && timing.turning) timing.average = 0.7 * timing.average + 0.3 * Math.min(now - timing.last, 1000);
    // Slower than 30 frames a second while it turns: a coarser net and larger pixels until it stands still.
    if (timing.average > 31) timing.slow = true;
    timing.turning = turning;
    timing.last = now;
    setCoarse(turning && timing.slow);
    renderer.render(scene, camera);
    view.calls = renderer.info.render.calls;
    view.drawnTriangles = renderer.info.render.triangles;
    ++view.frames;
    view.frameMs = performance.now() - begun;
    overlay?.(view);
  }

  const pixelRatio = () => Math.min(devicePixelRatio, 2) * (coarse ? 0.5 : 1);
  function setCoarse(on) {
    if (on === coarse) return;
    coarse = on;
    view.terrain?.setCoarse(on);
    renderer.setPixelRatio(pixelRatio());
  }

  controls.addEventListener('start', () => { untouched = null; });
  let settle = 0;
  controls.addEventListener('change', () => {
    turned = true;
    clearTimeout(settle);
    settle = setTimeout(request, Math.max(200, 3 * timing.average));
    request();
  });
  canvas.addEventListener('webglcontextlost', (event) => { event.preventDefault(); lost = true; });
  canvas.addEventListener('webglcontextrestored', () => { lost = false; request(); });

  view.resize = () => {
    const { clientWidth: width, clientHeight: height } = canvas.parentElement;
    if (!width || !height) return;
    renderer.setPixelRatio(pixelRatio());
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    if (untouched && view.track) view.home(untouched);
    request();
  };
  new ResizeObserver(view.resize).observe(canvas.parentElement);

  view.toScene = (x, y, z) => new THREE.Vector3(x - origin[0], y - origin[1], (z - planeAt(state.strip, x, y)) * state.exaggeration);
  /// Pixel of the canvas at which a place of the ground is drawn.
  view.screenOf = (x, y) => {
    const z = state.strip.grid ? heightAt(state.strip.grid, x, y) : NaN;
    const p = view.toScene(x, y, Number.isNaN(z) ? planeAt(state.strip, x, y) : z).project(camera);
    return [(0.5 + 0.5 * p.x) * canvas.clientWidth, (0.5 - 0.5 * p.y) * canvas.clientHeight];
  };

  /// The first place of the ground under a pixel of the canvas, or null.
  view.pick = (px, py) => {
    if (!state.strip?.grid) return null;
    const pointer = new THREE.Vector2((2 * px) / canvas.clientWidth - 1, 1 - (2 * py) / canvas.clientHeight);
    const caster = new THREE.Raycaster();
    caster.setFromCamera(pointer, camera);
    return march(state.strip, caster.ray, origin, state.exaggeration, extent);
  };
  /// The keyframe whose camera is drawn within some pixels, or null.
  view.pickCamera = (px, py) => {
    if (!state.show.track || !view.track) return null;
    let best = null;
    let least = 11;
    view.track.centres.forEach((c, i) => {
      const p = c.clone().project(camera);
      const far = Math.hypot((0.5 + 0.5 * p.x) * canvas.clientWidth - px, (0.5 - 0.5 * p.y) * canvas.clientHeight - py);
      if (p.z < 1 && far < least) [best, least] = [view.track.posed[i], far];
    });
    return best;
  };

  let generation = 0;
  view.useStrip = async (strip) => {
    const mine = ++generation;
    for (const part of [view.terrain?.mesh, view.track?.group, view.marks?.group]) part && scene.remove(part);
    view.terrain?.dispose();
    view.track?.dispose();
    view.marks?.dispose();
    view.terrain = view.track = view.marks = null;
    origin = originOf(strip);
    extent = extentOf(strip);
    view.track = makeTrack(strip, origin);
    view.marks = makeMarks(extent);
    scene.add(view.track.group, view.marks.group);
    if (strip.grid) {
      const terrain = await makeTerrain(strip, origin);
      if (mine !== generation) return terrain.dispose();
      view.terrain = terrain;
      scene.add(terrain.mesh);
    }
    view.track.show?.(state.show);
    view.home();
  };

  view.paint = () => {
    const layer = layersOf(state.flight).find((l) => l.id === state.layer);
    if (!view.terrain || !layer) return null;
    const made = layer.make(state.strip, state);
    view.terrain.setLayer(layer.id, made);
    request();
    return made;
  };
  view.exaggerate = () => {
    view.terrain?.setExaggeration(state.exaggeration);
    view.track?.setExaggeration(state.exaggeration);
    view.placeMarks();
  };
  view.placeMarks = () => {
    const at = (p) => {
      if (!p || !state.strip.grid) return null;
      const z = heightAt(state.strip.grid, p.x, p.y);
      return Number.isNaN(z) ? null : view.toScene(p.x, p.y, z);
    };
    view.marks?.place(at(state.place), at(state.cursor), at(state.profile.a), at(state.profile.b), (t) => {
      const { a, b } = state.profile;
      return at({ x: a.x + t * (b.x - a.x), y: a.y + t * (b.y - a.y) });
    });
    request();
  };

  // From the flight's right and behind, so that it goes from left to right and away.
  view.home = (kind = 'oblique') => {
    const { along, middle } = courseOf(state.strip, view.track, origin);
    const right = new THREE.Vector3(along.y, -along.x, 0);
    const from = kind === 'top' ? new THREE.Vector3(0, 0, 1).addScaledVector(right, 0.001)
      : right.multiplyScalar(0.74).addScaledVector(along, -0.3).add(new THREE.Vector3(0, 0, 0.66));
    camera.near = extent / 500;
    camera.far = 40 * extent;
    camera.updateProjectionMatrix();
    controls.target.copy(middle);
    camera.position.copy(middle).addScaledVector(from.normalize(), extent);
    fitAll(camera, controls.target, outlineOf(state.strip, view.track, origin, state.exaggeration));
    controls.minDistance = 0.02 * extent;
    controls.maxDistance = 12 * extent;
    controls.update();
    untouched = kind;
    request();
  };
  view.turn = (azimuth, polar) => {
    untouched = null;
    const offset = camera.position.clone().sub(controls.target);
    const s = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.x, offset.z, -offset.y));
    s.theta += azimuth;
    s.phi = Math.min(controls.maxPolarAngle, Math.max(0.001, s.phi + polar));
    const v = new THREE.Vector3().setFromSpherical(s);
    camera.position.copy(controls.target).add(new THREE.Vector3(v.x, -v.z, v.y));
    controls.update();
  };
  view.zoom = (factor) => {
    untouched = null;
    camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
    controls.update();
  };
  view.lookAt = (x, y) => {
    untouched = null;
    const z = state.strip.grid ? heightAt(state.strip.grid, x, y) : NaN;
    const to = view.toScene(x, y, Number.isNaN(z) ? planeAt(state.strip, x, y) : z);
    camera.position.add(to.clone().sub(controls.target));
    controls.target.copy(to);
    controls.update();
  };
  /// Strip units per pixel at the middle of the view, and the azimuth of the view.
  view.scale = () => (2 * Math.tan((camera.fov * Math.PI) / 360) * camera.position.distanceTo(controls.target)) / canvas.clientHeight;
  view.azimuth = () => controls.getAzimuthalAngle();
  return view;
}

// Some points of everything that is shown: covered cells here and there, and the cameras.
function outlineOf(strip, track, origin, exaggeration) {
  const points = [...track.centres];
  const { grid } = strip;
  if (!grid) return points;
  const relief = reliefOf(strip);
  const step = Math.max(1, Math.floor(Math.sqrt(relief.length / 4000)));
  for (let j = 0; j < grid.height; j += step) {
    for (let i = 0; i < grid.width; i += step) {
      const z = relief[j * grid.width + i];
      if (!Number.isNaN(z)) points.push(new THREE.Vector3(grid.x0 + i * grid.cell - origin[0], grid.y0 - j * grid.cell - origin[1], z * exaggeration));
    }
  }
  return points;
}

// Moves the camera, with its direction kept, until all points fill the view but for a margin.
function fitAll(camera, target, points) {
  if (points.length < 2) return;
  const half = Math.tan((camera.fov * Math.PI) / 360);
  for (let round = 0; round < 12; ++round) {
    camera.lookAt(target);
    camera.updateMatrixWorld();
    const low = new THREE.Vector2(Infinity, Infinity);
    const high = new THREE.Vector2(-Infinity, -Infinity);
    for (const point of points) {
      const p = point.clone().project(camera);
      low.min(p);
      high.max(p);
    }
    const distance = camera.position.distanceTo(target);
    const axis = (k) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, k);
    const shift = axis(0).multiplyScalar(0.5 * (low.x + high.x) * distance * half * camera.aspect)
      .add(axis(1).multiplyScalar(0.5 * (low.y + high.y) * distance * half));
    const scale = Math.min(3, Math.max(0.4, Math.max(high.x - low.x, high.y - low.y) / 1.8));
    const offset = camera.position.clone().sub(target).multiplyScalar(scale);
    target.add(shift);
    camera.position.copy(target).add(offset);
  }
}

function originOf(strip) {
  if (strip.grid) return [strip.grid.x0 + 0.5 * strip.grid.width * strip.grid.cell, strip.grid.y0 - 0.5 * strip.grid.height * strip.grid.cell];
  const first = strip.members.find((k) => k.pose);
  return first ? first.pose.centre.slice(0, 2) : [0, 0];
}

function extentOf(strip) {
  if (strip.grid) return Math.max(1e-6, Math.hypot(strip.grid.width, strip.grid.height) * strip.grid.cell);
  return Math.max(1e-6, strip.track_length, strip.flying_height, 1e-3);
}

function courseOf(strip, track, origin) {
  const { centres } = track;
  const along = centres.length > 1 ? centres.at(-1).clone().sub(centres[0]).setZ(0) : new THREE.Vector3(1, 0, 0);
  if (along.lengthSq() === 0) along.set(1, 0, 0);
  const middle = new THREE.Vector3();
  if (!strip.grid && centres.length) centres.forEach((c) => middle.addScaledVector(c, 1 / centres.length));
  return { along: along.normalize(), middle };
}

// Along the ray in steps of a cell until it is below the surface, then by halves.
function march(strip, ray, origin, exaggeration, extent) {
  const { grid } = strip;
  const above = (t) => {
    const x = ray.origin.x + t * ray.direction.x + origin[0];
    const y = ray.origin.y + t * ray.direction.y + origin[1];
    const z = heightAt(grid, x, y);
    return { x, y, over: ray.origin.z + t * ray.direction.z - (z - planeAt(strip, x, y)) * exaggeration };
  };
  const far = ray.origin.length() + 2 * extent;
  const near = Math.max(0, ray.origin.length() - 2 * extent);
  const step = Math.max(grid.cell, (far - near) / 8000);
  let before = near;
  for (let t = near; t <= far; t += step) {
    const here = above(t);
    if (here.over <= 0) {
      let [low, high] = [before, t];
      for (let k = 0; k < 30; ++k) {
        const middle = 0.5 * (low + high);
        if (above(middle).over <= 0) high = middle;
        else low = middle;
      }
      const { x, y } = above(high);
      return { x, y };
    }
    before = t;
  }
  return null;
}
