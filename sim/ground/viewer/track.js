// The camera's way over the ground: line, cameras, footprints, links, and how well the positions are known.

import * as THREE from 'three';
import { Line2 } from 'three/addons/lines/Line2.js';
import { LineGeometry } from 'three/addons/lines/LineGeometry.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import { planeAt } from './grid.js';
import { draped } from './drape.js';
import { rotationOf } from './camera_model.js';
import { eigenOf } from './ellipsoid.js';
import { makeFixes } from './fixes.js';
import { makeLinks } from './links.js';

const plain = new THREE.Color(0xffffff);
const strong = new THREE.Color(0xff9a3c);

const medianStep = (centres) => {
  const steps = centres.slice(1).map((c, i) => c.distanceTo(centres[i])).sort((p, q) => p - q);
  return steps[steps.length >> 1] || 1;
};

// A camera as a pyramid: apex at its centre, base towards what it sees; its sides in different light.
function pyramid() {
  const [a, b] = [0.5, 0.38];
  const base = [[-a, -b, 0.7], [a, -b, 0.7], [a, b, 0.7], [-a, b, 0.7]];
  const faces = base.map((p, i) => [[0, 0, 0], base[(i + 1) % 4], p]).concat([[base[0], base[1], base[2]], [base[0], base[2], base[3]]]);
  const lights = [1, 0.72, 0.86, 0.6, 0.34, 0.34];
  const g = new THREE.BufferGeometry();
  g.setAttribute('position', new THREE.Float32BufferAttribute(faces.flat(2), 3));
  g.setAttribute('color', new THREE.Float32BufferAttribute(lights.flatMap((l) => Array(9).fill(l)), 3));
  return g;
}

export function makeTrack(strip, origin) {
  const group = new THREE.Group();
  const posed = strip.members.filter((k) => k.pose);
  const centres = posed.map((k) => {
    const [x, y, z] = k.pose.centre;
    return new THREE.Vector3(x - origin[0], y - origin[1], z - planeAt(strip, x, y));
  });
  const track = { group, posed, centres, enlarged: 1, dispose() {}, setExaggeration() {}, highlight() {} };
  if (posed.length === 0) return track;
  const size = 0.24 * Math.min(medianStep(centres), strip.flying_height || Infinity);

  const casing = wideLine(centres, 0x10141a, 4.5, 0.5);
  const line = wideLine(centres, 0xfff3e2, 2, 1);
  [casing.renderOrder, line.renderOrder] = [1, 2];
  const cameras = new THREE.InstancedMesh(pyramid(), new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, vertexColors: true }), posed.length);
  posed.forEach((k, i) => cameras.setMatrixAt(i, cameraMatrix(k, centres[i], size)));
  cameras.frustumCulled = false;
  const lines = new THREE.Group();
  lines.add(casing, line, cameras);

  const links = makeLinks(strip, posed, centres, size);
  const fixes = makeFixes(strip, origin, size);
  const { mesh: ellipsoids, enlarged } = makeEllipsoids(posed, centres, size);
  const pale = matchMedia('(prefers-color-scheme: dark)').matches ? 0xf4e9d8 : 0x4a4038;
  const footprints = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: pale, transparent: true, opacity: 0.55 }));
  footprints.frustumCulled = false;
  const chosenGeometry = { current: null };
  const chosenMaterial = new LineMaterial({ color: 0xff9a3c, linewidth: 3 });
  const chosen = new LineSegments2(new LineSegmentsGeometry(), chosenMaterial);
  chosen.frustumCulled = false;
  group.add(lines, links.group, fixes.group, footprints, chosen);
  if (ellipsoids) group.add(ellipsoids);

  let exaggeration = 1;
  let highlighted = new Set();
  const outlines = posed.map((k) => {
    const points = [];
    for (let i = 0; i + 2 < (k.footprint?.length ?? 0); i += 3) points.push(k.footprint.slice(i, i + 3));
    return draped(strip.grid, points);
  });
  const outline = (i) => outlines[i].line.map(([x, y, z]) =>
    [x - origin[0], y - origin[1], (z - planeAt(strip, x, y)) * exaggeration + 0.02 * size]);
  const segments = (points) => points.flatMap((p, i) => [...p, ...points[(i + 1) % points.length]]);

  function drawFootprints() {
    const all = posed.flatMap((k, i) => segments(outline(i)));
    footprints.geometry.setAttribute('position', new THREE.Float32BufferAttribute(all, 3));
    drawChosen();
  }
  // Outlines of what is chosen; of a single one the lines of sight to its corners too.
  function drawChosen() {
    const some = posed.flatMap((k, i) => {
      if (!highlighted.has(k.id)) return [];
      const points = outline(i);
      const { corners } = outlines[i];
      const sight = highlighted.size === 1 ? [0, 1, 2, 3].flatMap((n) => points.length ? [...centres[i].toArray(), ...points[corners[(n * corners.length) / 4]]] : []) : [];
      return [...segments(points), ...sight];
    });
    chosen.visible = some.length > 0;
    chosenGeometry.current?.dispose();
    if (!some.length) return;
    chosenGeometry.current = new LineSegmentsGeometry().setPositions(some);
    chosen.geometry = chosenGeometry.current;
  }

  return Object.assign(track, {
    enlarged,
    links,
    fixes,
    cameras,
    footprints,
    show(which) {
      lines.visible = which.track;
      links.group.visible = which.links;
      fixes.group.visible = which.fixes;
      footprints.visible = which.footprints;
      if (ellipsoids) ellipsoids.visible = which.uncertainty;
    },
    setExaggeration(factor) {
      exaggeration = factor;
      fixes.setExaggeration(factor);
      drawFootprints();
    },
    highlight(ids) {
      highlighted = ids;
      posed.forEach((k, i) => cameras.setColorAt(i, ids.has(k.id) ? strong : plain));
      cameras.instanceColor.needsUpdate = true;
      drawChosen();
    },
    dispose() {
      links.dispose();
      fixes.dispose();
      for (const node of [casing, line, cameras, footprints, chosen, ellipsoids]) {
        node?.geometry.dispose();
        node?.material.dispose();
      }
    },
  });
}

function wideLine(points, color, linewidth, opacity) {
  const geometry = new LineGeometry().setPositions(points.flatMap((p) => p.toArray()));
  const line = new Line2(geometry, new LineMaterial({ color, linewidth, opacity, transparent: true, depthWrite: false }));
  line.frustumCulled = false;
  line.visible = points.length > 1;
  return line;
}

function cameraMatrix(keyframe, centre, size) {
  const r = rotationOf(keyframe);  // its rows are the camera's axes in the world
  return new THREE.Matrix4()
    .makeBasis(new THREE.Vector3(r[0], r[1], r[2]), new THREE.Vector3(r[3], r[4], r[5]), new THREE.Vector3(r[6], r[7], r[8]))
    .scale(new THREE.Vector3(size, size, size))
    .setPosition(centre);
}

// One sigma, enlarged by a round number until the largest can be seen.
function makeEllipsoids(posed, centres, size) {
  const shapes = posed.map((k) => eigenOf(k.pose.covariance));
  const largest = Math.max(...shapes.map((s) => s.radii[0]));
  if (!(largest > 0)) return { mesh: null, enlarged: 0 };
  const wanted = (2 * size) / largest;
  const decade = 10 ** Math.floor(Math.log10(Math.max(wanted, 1)));
  const enlarged = Math.max(1, decade * (wanted >= 5 * decade ? 5 : wanted >= 2 * decade ? 2 : 1));
  const material = new THREE.MeshBasicMaterial({ color: 0x62c6ff, transparent: true, opacity: 0.42, depthWrite: false });
  const mesh = new THREE.InstancedMesh(new THREE.SphereGeometry(1, 20, 12), material, posed.length);
  shapes.forEach(({ radii, axes }, i) => {
    const [a, b, c] = axes.map((v) => new THREE.Vector3(...v));
    const least = 1e-3 * size;
    mesh.setMatrixAt(i, new THREE.Matrix4().makeBasis(a, b, c)
      .scale(new THREE.Vector3(...radii.map((r) => Math.max(r * enlarged, least)))).setPosition(centres[i]));
  });
  mesh.frustumCulled = false;
  return { mesh, enlarged };
}
