// Links between keyframes that show the same ground: a line from camera to camera for each, and what each verdict
// means.

import * as THREE from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';

/// Where a strip has links of two verdicts, those of the later row lie above the others.
export const verdicts = [
  { id: 'images_only', name: 'images only', colour: 0xb9a7ff, width: 1.6, dashed: true },
  { id: 'linked', name: 'linked', colour: 0x35d0a5, width: 2, dashed: false },
  { id: 'contradicts_poses', name: 'contradicts the poses of the flight', colour: 0xff4f7b, width: 3, dashed: false },
];
export const verdictOf = (link) => verdicts.find((v) => v.id === link.verdict);

function segments({ colour, width, dashed }, positions, size) {
  const geometry = new LineSegmentsGeometry().setPositions(positions);
  const lines = new LineSegments2(geometry, new LineMaterial({ color: colour, linewidth: width, dashed, dashSize: 0.5 * size, gapSize: 0.4 * size }));
  if (dashed) lines.computeLineDistances();
  lines.frustumCulled = false;
  return lines;
}

/// Lines between the camera centres of a strip. A link to a keyframe that stands in another strip has no line, because
/// strips that are not joined have no common coordinates.
export function makeLinks(strip, posed, centres, size) {
  const group = new THREE.Group();
  const centreOf = new Map(posed.map((k, i) => [k.id, centres[i]]));
  const drawn = strip.links.filter((l) => centreOf.has(l.keyframe) && centreOf.has(l.place));
  const count = {};
  verdicts.forEach((verdict, order) => {
    const some = drawn.filter((l) => l.verdict === verdict.id);
    count[verdict.id] = some.length;
    if (!some.length) return;
    const lines = segments(verdict, some.flatMap((l) => [...centreOf.get(l.place).toArray(), ...centreOf.get(l.keyframe).toArray()]), size);
    lines.renderOrder = 3 + order;
    group.add(lines);
  });
  return {
    group,
    count,
    dispose() {
      for (const lines of group.children) {
        lines.geometry.dispose();
        lines.material.dispose();
      }
    },
  };
}
