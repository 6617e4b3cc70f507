// Marks on the ground: the chosen place, the keyboard's cursor, the measured line.

import * as THREE from 'three';
import { Line2 } from 'three/addons/lines/Line2.js';
import { LineGeometry } from 'three/addons/lines/LineGeometry.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';

function pin(colour, extent, length) {
  const group = new THREE.Group();
  const material = new THREE.MeshBasicMaterial({ color: colour, depthTest: false });
  const head = new THREE.Mesh(new THREE.SphereGeometry(0.006 * extent, 16, 10), material);
  head.position.z = length * extent;
  const stem = new THREE.Mesh(new THREE.CylinderGeometry(0.0012 * extent, 0.0012 * extent, length * extent, 6), material);
  stem.rotation.x = Math.PI / 2;
  stem.position.z = 0.5 * length * extent;
  const foot = new THREE.Mesh(new THREE.RingGeometry(0.005 * extent, 0.0075 * extent, 24), material);
  group.add(head, stem, foot);
  group.renderOrder = 3;
  group.visible = false;
  return group;
}

export function makeMarks(extent) {
  const place = pin(0xff5d5d, extent, 0.035);
  const cursor = pin(0x7fe0ff, extent, 0.02);
  const a = pin(0xffe27a, extent, 0.025);
  const b = pin(0xffe27a, extent, 0.025);
  const line = new Line2(new LineGeometry(), new LineMaterial({ color: 0xffe27a, linewidth: 3, depthTest: false, transparent: true }));
  line.renderOrder = 3;
  line.visible = line.frustumCulled = false;
  const group = new THREE.Group();
  group.add(place, cursor, a, b, line);
  const put = (mark, at) => {
    mark.visible = at !== null;
    if (at) mark.position.copy(at);
  };
  return {
    group,
    line,
    place(at, cursorAt, from, to, between) {
      put(place, at);
      put(cursor, cursorAt);
      put(a, from);
      put(b, to);
      line.visible = false;
      if (!from || !to) return;
      const points = [];
      for (let i = 0; i <= 200; ++i) {
        const p = between(i / 200);
        if (p) points.push(...p.toArray());
      }
      if (points.length < 6) return;
      line.geometry.dispose();
      line.geometry = new LineGeometry().setPositions(points);
      line.visible = true;
    },
    dispose() {
      group.traverse((node) => {
        node.geometry?.dispose();
        node.material?.dispose();
      });
    },
  };
}
