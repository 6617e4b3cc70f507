// Fixes on the map of an orbiter: a cross where the ground of each lies on the map, with its error ellipse.

import * as THREE from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import { planeAt } from './grid.js';

export const looks = [
  { used: false, name: 'contradict the others', colour: 0xff4f7b },
  { used: true, name: 'agree', colour: 0x8fe04a },
];
const corners = 32;

/// A round number by which ellipses are enlarged, so that the middle one can be seen.
function enlargementOf(fixes, size) {
  const sorted = fixes.map((f) => f.radii[0]).sort((p, q) => p - q);
  const wanted = (0.8 * size) / (sorted[sorted.length >> 1] || Infinity);
  const decade = 10 ** Math.floor(Math.log10(Math.max(wanted, 1)));
  return Math.max(1, decade * (wanted >= 5 * decade ? 5 : wanted >= 2 * decade ? 2 : 1));
}

/// In the coordinates of the strip, which stands on the map.
export function makeFixes(strip, origin, size) {
  const group = new THREE.Group();
  const { fixes } = strip;
  const enlarged = fixes.length ? enlargementOf(fixes, size) : 1;
  const count = (look) => fixes.filter((f) => f.used === look.used).length;
  const made = [];

  function clear() {
    for (const lines of made.splice(0)) {
      group.remove(lines);
      lines.geometry.dispose();
      lines.material.dispose();
    }
  }
  function outline({ ground: [x, y, z], radii, direction_rad: turn }, exaggeration) {
    const height = (z - planeAt(strip, x, y)) * exaggeration + 0.04 * size;
    const at = (u, v) => [x - origin[0] + u * Math.cos(turn) - v * Math.sin(turn), y - origin[1] + u * Math.sin(turn) + v * Math.cos(turn), height];
    const ring = Array.from({ length: corners }, (_, i) => at(enlarged * radii[0] * Math.cos((2 * Math.PI * i) / corners), enlarged * radii[1] * Math.sin((2 * Math.PI * i) / corners)));
    const cross = 0.12 * size;
    return [...ring.flatMap((p, i) => [...p, ...ring[(i + 1) % corners]]), ...at(-cross, 0), ...at(cross, 0), ...at(0, -cross), ...at(0, cross)];
  }
  return {
    group,
    enlarged,
    keys: looks.map((look) => ({ ...look, count: count(look) })).filter((look) => look.count),
    setExaggeration(factor) {
      clear();
      looks.forEach((look, order) => {
        const some = fixes.filter((f) => f.used === look.used);
        if (!some.length) return;
        const geometry = new LineSegmentsGeometry().setPositions(some.flatMap((f) => outline(f, factor)));
        const lines = new LineSegments2(geometry, new LineMaterial({ color: look.colour, linewidth: 2 }));
        lines.frustumCulled = false;
        lines.renderOrder = 6 - order;
        made.push(lines);
        group.add(lines);
      });
    },
    dispose: clear,
  };
}
