// The flight as the page carries it, with its arrays decoded.

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const array = (Type, text) => new Type(bytes(text).buffer);

// Arrays over all cells of a surface; NaN and 0 where no height was measured. laid_of: interpolated heights of ground that
// images show there, NaN elsewhere; only the picture uses them.
function decodeGrid(grid, landing) {
  const cells = grid.width * grid.height;
  const cover = bytes(grid.cover);
  const told = {
    height: array(Float32Array, grid.heights),
    sigma: array(Float32Array, grid.sigma),
    count: bytes(grid.count),
    source: array(Uint16Array, grid.source),
    safe: landing ? bytes(landing.safe) : null,
  };
  const out = {
    ...grid,
    height_of: new Float32Array(cells).fill(NaN),
    laid_of: new Float32Array(cells).fill(NaN),
    sigma_of: new Float32Array(cells).fill(NaN),
    count_of: new Uint8Array(cells),
    source_of: new Uint16Array(cells),
    safe_of: landing ? new Uint8Array(cells).fill(255) : null,
    covered: told.height.length,
  };
  const laid = bytes(grid.laid_cover);
  const laidHeights = array(Float32Array, grid.laid_heights);
  for (let cell = 0, next = 0; cell < cells; ++cell) {
    if ((laid[cell >> 3] >> (cell & 7)) & 1) out.laid_of[cell] = laidHeights[next++];
  }
  out.laid = laidHeights.length;
  for (let cell = 0, next = 0; cell < cells; ++cell) {
    if (!((cover[cell >> 3] >> (cell & 7)) & 1)) continue;
    out.height_of[cell] = told.height[next];
    out.sigma_of[cell] = told.sigma[next];
    out.count_of[cell] = told.count[next];
    out.source_of[cell] = told.source[next];
    if (landing) out.safe_of[cell] = told.safe[next];
    ++next;
  }
  return out;
}

// A keyframe whose record was lost stands between its neighbours in time.
function fillTimes(keyframes) {
  const known = keyframes.filter((k) => Number.isFinite(k.time_s));
  for (const k of keyframes) {
    if (Number.isFinite(k.time_s)) continue;
    const before = known.filter((other) => other.id < k.id).pop();
    const after = known.find((other) => other.id > k.id);
    if (before && after) {
      k.time_s = before.time_s + ((k.id - before.id) / (after.id - before.id)) * (after.time_s - before.time_s);
    } else {
      k.time_s = (before ?? after)?.time_s ?? k.id;
    }
    k.time_guessed = true;
  }
}

export function readFlight() {
  const flight = JSON.parse(document.getElementById('flight').textContent);
  if (flight.nothing) return flight;
  fillTimes(flight.keyframes);
  flight.byId = new Map(flight.keyframes.map((k) => [k.id, k]));
  for (const strip of flight.strips) {
    if (strip.grid) strip.grid = decodeGrid(strip.grid, strip.landing);
    strip.members = strip.keyframes.map((id) => flight.byId.get(id)).filter(Boolean);
    const inside = new Set(strip.keyframes);
    strip.links = flight.links.filter((l) => inside.has(l.keyframe) && inside.has(l.place));
    strip.fixes = flight.fixes.filter((f) => inside.has(f.keyframe));
  }
  return flight;
}
