// The layers by which the surface can be coloured, each with its colours over the cells, its legend and its meaning.

import { viridis, magma, distinct, gradient, css } from './colours.js';
import { planeAt, rangeOf, centreOf } from './grid.js';
import { brief } from './text.js';

const ramp = (map, [low, high], unit) => ({ kind: 'ramp', gradient: gradient(map), low: brief(low), high: `${brief(high)} ${unit}`.trim() });

// Per cell, a value through a colour map.
function mapped(strip, value, map, range, unit, about) {
  const span = range[1] - range[0] || 1;
  return {
    colour: (cell) => { const v = value(cell); return Number.isFinite(v) ? map((v - range[0]) / span) : null; },
    legend: ramp(map, range, unit),
    about,
  };
}

function reliefOf(strip) {
  const { grid } = strip;
  if (!grid.relief_of) {
    grid.relief_of = new Float32Array(grid.height_of.length);
    for (let cell = 0, j = 0; j < grid.height; ++j) {
      for (let i = 0; i < grid.width; ++i, ++cell) {
        grid.relief_of[cell] = grid.height_of[cell] - planeAt(strip, grid.x0 + i * grid.cell, grid.y0 - j * grid.cell);
      }
    }
  }
  return grid.relief_of;
}

function heightLayer(strip) {
  const relief = reliefOf(strip);
  return { ...mapped(strip, (c) => relief[c], viridis, rangeOf(relief), strip.unit, 'Height above the mean plane of the strip.'), smooth: true };
}

function sigmaLayer(strip) {
  const sigma = strip.grid.sigma_of;
  return { ...mapped(strip, (c) => sigma[c], magma, rangeOf(sigma), strip.unit, 'One sigma of the height, from matching. Grey: not told.'), smooth: true };
}

function countLayer(strip) {
  const count = strip.grid.count_of;
  const most = Math.max(1, count.reduce((m, v) => Math.max(m, v), 0));
  const colour = (n) => (n === 0 ? [96, 100, 106] : viridis(most === 1 ? 0.6 : (n - 1) / (most - 1)));
  return {
    colour: (cell) => colour(count[cell]),
    legend: { kind: 'keys', keys: [[css(colour(0)), '0: closed seam'], ...Array.from({ length: Math.min(most, 5) }, (_, i) => [css(colour(i + 1)), `${i + 1}${i === 4 && most > 5 ? '…' : ''}`])] },
    about: 'Keyframes that measured the cell; 0: between two pieces, none did.',
  };
}

function maskLayer(strip, view) {
  const { source_of: source, count_of: count } = strip.grid;
  const chosen = view.chosen();
  const places = new Set(strip.keyframes.flatMap((id, place) => (chosen.has(id) ? [place + 1] : [])));
  const strong = [242, 153, 74];
  const seen = chosen.size ? [92, 106, 122] : [86, 156, 190];
  const closed = [58, 62, 68];
  return {
    colour: (cell) => (places.has(source[cell]) ? strong : count[cell] ? seen : closed),
    legend: { kind: 'keys', keys: [...(chosen.size ? [[css(strong), chosen.size === 1 ? `newly seen in keyframe ${[...chosen][0]}` : `newly seen in ${chosen.size} keyframes`]] : []), [css(seen), chosen.size ? 'in others' : 'newly seen when it came down'], [css(closed), 'closed seam']] },
    about: 'Ground is sent once, by the keyframe that saw it first. Choose a keyframe or a span of time to see its part.',
  };
}

function richnessLayer(strip) {
  const values = strip.members.map((k) => k.richness).filter(Number.isFinite);
  const range = values.length ? [Math.min(...values), Math.max(...values)] : [0, 1];
  const bySource = [NaN, ...strip.keyframes.map((id) => strip.members.find((k) => k.id === id)?.richness ?? NaN)];
  const source = strip.grid.source_of;
  return mapped(strip, (c) => bySource[source[c]], viridis, range, '', 'Image Richness Index of the keyframe that the cell comes from. Grey: not told.');
}

function sourceLayer(strip) {
  const source = strip.grid.source_of;
  const colours = [[96, 100, 106], ...strip.keyframes.map((_, i) => distinct(i))];
  const some = strip.keyframes.slice(0, 6).map((id, i) => [css(colours[i + 1]), `${id}`]);
  return {
    colour: (cell) => colours[source[cell]],
    legend: { kind: 'keys', keys: strip.keyframes.length > 6 ? [...some, ['transparent', `… ${strip.keyframes.at(-1)}`]] : some },
    about: 'The keyframe that each cell comes from.',
  };
}

// Sites are rings as wide as the lander's footprint; a ring is at least a cell wide.
function landingLayer(strip) {
  const { grid, landing } = strip;
  const ring = [242, 153, 74];
  if (!landing) return { colour: () => null, legend: null, about: 'No landing sites: run ilp-ground with --landing-sites, on a strip in metres that knows what is up.' };
  const radius = landing.footprint / 2;
  const onRing = (cell) => {
    const [x, y] = centreOf(grid, cell);
    return landing.sites.some((s) => Math.abs(Math.hypot(x - s.x, y - s.y) - radius) < Math.max(0.12 * radius, 0.7 * grid.cell));
  };
  return {
    colour: (cell) => (onRing(cell) ? ring : grid.safe_of[cell] === 255 ? null : viridis(grid.safe_of[cell] / 100)),
    legend: { kind: 'ramp', gradient: gradient(viridis), low: '0', high: '1 safe' },
    about: 'Probability that a lander is safe with its footprint there. Rings: the best sites. Grey: the footprint is not covered.',
  };
}

const all = [
  { id: 'ortho', name: 'Orthoimage', make: () => ({ legend: null, about: 'Exposures matched where pieces meet, contrast stretched.' }) },
  { id: 'height', name: 'Height', make: heightLayer },
  { id: 'sigma', name: 'Sigma', make: sigmaLayer },
  { id: 'count', name: 'Count', make: countLayer },
  { id: 'mask', name: 'Newly seen', make: maskLayer },
  { id: 'richness', name: 'Richness', make: richnessLayer },
  { id: 'source', name: 'Source', make: sourceLayer },
];
/// Those that the flight has something for.
export const layersOf = (flight) => (flight.strips.some((s) => s.landing) ? [...all, { id: 'landing', name: 'Landing', make: landingLayer }] : all);
export { reliefOf };
