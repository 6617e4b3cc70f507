// Lines that lie on the surface.

import { heightAt } from './grid.js';

// A longer side is drawn with longer steps.
const mostSteps = 400;

// The surface's height, or that of the line where nothing was seen.
function onGround(grid, [x, y, z]) {
  const ground = grid ? heightAt(grid, x, y) : NaN;
  return [x, y, Number.isNaN(ground) ? z : ground];
}

/// A closed line through points [x, y, z], a cell of the grid apart, each at the height of the surface. A strip without
/// a grid keeps its points. `corners` has the places of the points given in the points returned.
export function draped(grid, points) {
  const line = [];
  const corners = [];
  points.forEach((from, i) => {
    const to = points[(i + 1) % points.length];
    const steps = grid ? Math.min(mostSteps, Math.max(1, Math.ceil(Math.hypot(to[0] - from[0], to[1] - from[1]) / grid.cell))) : 1;
    corners.push(line.length);
    for (let k = 0; k < steps; ++k) line.push(onGround(grid, from.map((v, n) => v + (k / steps) * (to[n] - v))));
  });
  return { line, corners };
}
