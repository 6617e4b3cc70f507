// The flight as the page carries it: report.json, what the viewer has besides, and its arrays decoded.

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

const [mostFrames, mostEvents] = [20000, 4000];
const seconds = (time_ns) => (time_ns === null ? undefined : time_ns / 1e9);

function keyframeOf(told, more) {
  const { index, pose, richness, newly_seen_px: seen } = told;
  const product = (kind) => (told[`${kind}_product`] || more[kind] ? { ...told[`${kind}_product`], ...more[kind] } : null);
  return {
    ...told, ...more, image: product('image'), depth: product('depth'), time_s: seconds(told.time_ns), richness: richness?.index,
    overlap: index > 0 ? told.overlap_with_previous : undefined, newly_seen: seen === null ? undefined : seen / (told.width * told.height),
    pose: pose?.state === 'final' ? { ...pose, q: pose.q_cam_from_world, covariance: more.covariance } : undefined,
  };
}

function stripOf(told, more, landing) {
  const sites = landing?.find((l) => l.strip === told.id)?.sites.map((s) => ({ ...s, x: s.place[0], y: s.place[1] }));
  return { ...told, ...more, end: told.end ?? 'no record received', covered_area: told.grid?.covered_area, landing: more.landing && { ...more.landing, sites } };
}

// Those whose points the joined model holds have the number of points and their median error in it.
function linksOf({ joined }, links) {
  const pair = (l) => `${l.keyframe} ${l.place}`;
  const inModel = new Map((joined?.models ?? []).flatMap((m) => m.links).map((l) => [pair(l), l]));
  return links.map((l) => ({ ...l, points: inModel.get(pair(l))?.points, error_px: inModel.get(pair(l))?.error_px }));
}

// Of strips that stand on a map, whose coordinates are those of the fixes.
function fixesOf({ joined, fixes }) {
  const records = new Map((fixes?.strips ?? []).flatMap((s) => s.keyframes).map((f) => [f.keyframe, f]));
  return (joined?.models ?? []).flatMap((m) => m.on_map?.fixes ?? []).filter((f) => records.get(f.keyframe)?.ground_m).map(({ keyframe, used }) => {
    const { ground_m: ground, sigma_major_m: major, sigma_minor_m: minor, ground_covariance_m2: [xx, xy, yy] } = records.get(keyframe);
    return { keyframe, used, ground, radii: [major, minor], direction_rad: 0.5 * Math.atan2(xy, 0.5 * (xx - yy)) };
  });
}

// When there are too many, the least severe events go first, and frames are left out evenly.
function timelineOf({ events, frames, storage }, link) {
  const list = events.length > mostEvents ? [...events].sort((p, q) => q.level - p.level).slice(0, mostEvents) : events;
  const related = frames.filter((f) => f.keyframe > 0 && f.verdict === 'ok' && f.time_ns !== null);
  const step = Math.floor(related.length / mostFrames) + 1;
  return {
    events: { list: list.map((e) => ({ ...e, time_s: e.time_ns / 1e9, severity: e.level, severity_name: e.severity })), all: events.length },
    overlaps: related.filter((_, i) => i % step === 0).map((f) => [f.time_ns / 1e9, f.overlap]), link, storage,
  };
}

export function readFlight() {
  const [report, more] = ['report', 'flight'].map((id) => JSON.parse(document.getElementById(id).textContent));
  if (more.nothing) return more;
  const flight = {
    ...report, links: linksOf(report, more.links), fixes: fixesOf(report), timeline: timelineOf(report, more.downlink),
    keyframes: report.keyframes.map((k, i) => keyframeOf(k, more.keyframes[i])),
    strips: report.strips.map((s, i) => stripOf(s, more.strips[i], report.landing)),
  };
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
