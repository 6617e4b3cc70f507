// Heights of a strip's surface at places, and along lines.

export function planeAt(strip, x, y) {
  const [a, b, c] = strip.plane;
  return a * x + b * y + c;
}

/// The cell nearest to a place, or -1 outside or where nothing was seen.
export function cellAt(grid, x, y) {
  const i = Math.round((x - grid.x0) / grid.cell);
  const j = Math.round((grid.y0 - y) / grid.cell);
  if (!(i >= 0 && j >= 0 && i < grid.width && j < grid.height)) return -1;
  const cell = j * grid.width + i;
  return Number.isNaN(grid.height_of[cell]) ? -1 : cell;
}

export function centreOf(grid, cell) {
  const i = cell % grid.width;
  return [grid.x0 + i * grid.cell, grid.y0 - ((cell - i) / grid.width) * grid.cell];
}

// Between four cells that are all covered; else of the nearest one.
function between(grid, values, x, y) {
  const u = (x - grid.x0) / grid.cell;
  const v = (grid.y0 - y) / grid.cell;
  const i = Math.min(Math.max(Math.floor(u), 0), grid.width - 2);
  const j = Math.min(Math.max(Math.floor(v), 0), grid.height - 2);
  const cell = j * grid.width + i;
  const [a, b, c, d] = [values[cell], values[cell + 1], values[cell + grid.width], values[cell + grid.width + 1]];
  const s = u - i;
  const t = v - j;
  const inside = s >= 0 && s <= 1 && t >= 0 && t <= 1;
  const value = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d);
  if (inside && !Number.isNaN(value)) return value;
  const nearest = cellAt(grid, x, y);
  return nearest < 0 ? NaN : values[nearest];
}

export const heightAt = (grid, x, y) => between(grid, grid.height_of, x, y);
export const sigmaAt = (grid, x, y) => between(grid, grid.sigma_of, x, y);

/// Heights from a to b, a cell apart, ends included.
export function profileOf(grid, a, b) {
  const distance = Math.hypot(b.x - a.x, b.y - a.y);
  const steps = Math.max(1, Math.min(4000, Math.round(distance / grid.cell)));
  const points = [];
  for (let i = 0; i <= steps; ++i) {
    const t = i / steps;
    const x = a.x + t * (b.x - a.x);
    const y = a.y + t * (b.y - a.y);
    points.push({ distance: t * distance, x, y, height: heightAt(grid, x, y), sigma: sigmaAt(grid, x, y) });
  }
  return { points, distance, drop: heightAt(grid, a.x, a.y) - heightAt(grid, b.x, b.y) };
}

export function profileCsv(profile, unit) {
  const number = (v, digits) => (Number.isFinite(v) ? v.toFixed(digits) : '');
  const rows = profile.points.map((p) =>
    [number(p.distance, 4), number(p.x, 4), number(p.y, 4), number(p.height, 5), number(p.sigma, 5)].join(','));
  return `distance_${unit},x_${unit},y_${unit},height_${unit},sigma_${unit}\n${rows.join('\n')}\n`;
}

/// Percentiles of the finite values among at most some 50 000 of them.
export function rangeOf(values, low = 0.02, high = 0.98) {
  const step = Math.max(1, Math.floor(values.length / 50000));
  const some = [];
  for (let i = 0; i < values.length; i += step) if (Number.isFinite(values[i])) some.push(values[i]);
  if (some.length === 0) return [0, 1];
  some.sort((p, q) => p - q);
  const at = (f) => some[Math.min(some.length - 1, Math.floor(f * some.length))];
  return [at(low), at(high)];
}
