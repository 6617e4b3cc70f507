// The flight over time: keyframes, events, overlap against its target, bytes. A drag chooses a span.

import { element, seconds, percent, bytesText } from './text.js';

const gutter = 92;
const lanes = { keyframes: [8, 22], events: [28, 42], overlap: [50, 92], bytes: [100, 138] };
const axisAt = 150;

const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export function makeTimeline(root, state, say) {
  const { flight } = state;
  const { events, overlaps, link } = flight.timeline;
  const canvas = element('canvas', { tabindex: 0, role: 'slider', id: 'timeline', 'aria-label': 'Keyframes over time. Left and right choose a keyframe, with Shift a span.' });
  const tip = element('div', { class: 'tip', hidden: true });
  root.append(canvas, tip);
  const times = [...flight.keyframes.map((k) => k.time_s), ...overlaps.map((o) => o[0])];
  const low = times.reduce((m, t) => Math.min(m, t), Infinity);
  const high = times.reduce((m, t) => Math.max(m, t), -Infinity);
  const [from, to] = Number.isFinite(low) ? [low, high > low ? high : low + 1] : [0, 1];
  let width = 0;
  const x = (t) => gutter + ((t - from) / (to - from)) * (width - gutter - 18);
  const timeAt = (px) => from + ((px - gutter) / (width - gutter - 18)) * (to - from);
  const clamped = (e) => Math.min(to, Math.max(from, e.time_s));
  const nearest = (t) => flight.keyframes.reduce((best, k) => (!best || Math.abs(k.time_s - t) < Math.abs(best.time_s - t) ? k : best), null);

  function draw() {
    width = root.clientWidth;
    const height = root.clientHeight;
    if (!width) return;
    const ratio = Math.min(devicePixelRatio, 2);
    [canvas.width, canvas.height] = [width * ratio, height * ratio];
    const c = canvas.getContext('2d');
    c.scale(ratio, ratio);
    c.font = `11px ${getComputedStyle(document.body).fontFamily}`;
    c.textBaseline = 'middle';
    drawFrame(c);
    drawOverlap(c);
    drawBytes(c);
    drawEvents(c);
    drawKeyframes(c);
    describe();
  }

  function drawFrame(c) {
    if (state.span) {
      c.fillStyle = style('--span');
      c.fillRect(x(state.span[0]), 2, Math.max(2, x(state.span[1]) - x(state.span[0])), axisAt - 4);
    }
    c.fillStyle = style('--muted');
    c.textAlign = 'right';
    for (const [name, [top, bottom]] of Object.entries(lanes)) {
      const label = { keyframes: 'keyframes', events: 'events', overlap: 'overlap', bytes: link.length ? 'bytes, link' : 'bytes' }[name];
      c.fillText(label, gutter - 12, (top + bottom) / 2);
    }
    c.strokeStyle = style('--line');
    c.beginPath();
    c.moveTo(gutter, axisAt + 0.5);
    c.lineTo(width - 18, axisAt + 0.5);
    c.stroke();
    c.textAlign = 'center';
    const raw = (to - from) / 8;
    const decade = 10 ** Math.floor(Math.log10(raw));
    const step = decade * (raw > 5 * decade ? 10 : raw > 2 * decade ? 5 : raw > decade ? 2 : 1);
    for (let t = Math.ceil(from / step) * step; t <= to; t += step) {
      c.fillText(`${Number(t.toPrecision(6))} s`, Math.min(x(t), width - 30), axisAt + 11);
    }
  }

  function drawOverlap(c) {
    const [top, bottom] = lanes.overlap;
    const values = [...overlaps.map((o) => o[1]), flight.target_overlap ?? 1, ...flight.keyframes.map((k) => k.overlap).filter(Number.isFinite)];
    const least = Math.max(0, Math.floor(10 * (values.reduce((m, v) => Math.min(m, v), 1) - 0.02)) / 10);
    const y = (v) => bottom - ((v - least) / (1 - least)) * (bottom - top);
    c.fillStyle = style('--s1');
    for (const [t, v] of overlaps) c.fillRect(x(t) - 1, y(v) - 1, 2, 2);
    c.fillStyle = style('--s2');
    for (const k of flight.keyframes) {
      if (!Number.isFinite(k.overlap)) continue;
      c.beginPath();
      c.arc(x(k.time_s), y(k.overlap), 2.6, 0, 7);
      c.fill();
    }
    if (Number.isFinite(flight.target_overlap)) {
      c.strokeStyle = style('--accent');
      c.setLineDash([5, 4]);
      c.beginPath();
      c.moveTo(gutter, y(flight.target_overlap));
      c.lineTo(width - 18, y(flight.target_overlap));
      c.stroke();
      c.setLineDash([]);
    }
    c.fillStyle = style('--muted');
    c.textAlign = 'left';
    c.fillText(`${(100 * least).toFixed(0)}`, gutter - 11, bottom - 2);
    c.fillText('%', gutter - 11, top + 3);
  }

  function drawBytes(c) {
    const [top, bottom] = lanes.bytes;
    const sizes = flight.keyframes.map((k) => [k.image?.bytes ?? 0, k.depth?.bytes ?? 0]);
    const most = sizes.reduce((m, [a, b]) => Math.max(m, a + b), 1);
    const bar = Math.max(1, Math.min(9, (0.6 * (width - gutter)) / Math.max(1, sizes.length)));
    flight.keyframes.forEach((k, i) => {
      const [a, b] = sizes[i].map((v) => (v / most) * (bottom - top));
      c.fillStyle = style('--s1');
      c.fillRect(x(k.time_s) - bar / 2, bottom - a, bar, a);
      c.fillStyle = style('--s3');
      c.fillRect(x(k.time_s) - bar / 2, bottom - a - b, bar, b);
    });
    drawLink(c, top, bottom);
    c.fillStyle = style('--muted');
    c.textAlign = 'right';
  }

  // What was handed to the link, added up (line), and what of it was confirmed (dashed).
  function drawLink(c, top, bottom) {
    const all = link.reduce((sum, l) => sum + l[1], 0);
    if (!all) return;
    const curve = (pairs, dashes) => {
      c.strokeStyle = style('--s4');
      c.setLineDash(dashes);
      c.beginPath();
      let sum = 0;
      c.moveTo(x(from), bottom);
      for (const [t, n] of pairs.sort((p, q) => p[0] - q[0])) {
        const px = x(Math.min(to, Math.max(from, t)));
        c.lineTo(px, bottom - (sum / all) * (bottom - top));
        sum += n;
        c.lineTo(px, bottom - (sum / all) * (bottom - top));
      }
      c.stroke();
      c.setLineDash([]);
    };
    c.lineWidth = 1.5;
    curve(link.map((l) => [l[0], l[1]]), []);
    curve(link.filter((l) => l[2] >= 0).map((l) => [l[2], l[1]]), [3, 3]);
    c.lineWidth = 1;
  }

  function drawEvents(c) {
    const [top, bottom] = lanes.events;
    const y = (top + bottom) / 2;
    for (const e of [...events.list].sort((p, q) => p.severity - q.severity)) {
      const px = x(clamped(e));
      c.fillStyle = style(['--faint', '--s1', '--warn', '--bad'][e.severity] ?? '--bad');
      c.beginPath();
      if (e.severity <= 1) c.arc(px, y, e.severity ? 3.2 : 2, 0, 7);
      else if (e.severity === 2) [[0, -5], [5, 4], [-5, 4]].forEach(([dx, dy], i) => (i ? c.lineTo(px + dx, y + dy) : c.moveTo(px, y - 5)));
      else [[0, -6], [6, 0], [0, 6], [-6, 0]].forEach(([dx, dy], i) => (i ? c.lineTo(px + dx, y + dy) : c.moveTo(px, y - 6)));
      c.fill();
    }
  }

  function drawKeyframes(c) {
    const [top, bottom] = lanes.keyframes;
    const chosen = state.strip ? state.chosen() : new Set();
    for (const k of flight.keyframes) {
      const strong = chosen.has(k.id);
      c.fillStyle = strong ? style('--accent') : k.pose ? style('--ink') : style('--bad');
      c.globalAlpha = strong ? 1 : k.strip === state.strip?.id ? 0.75 : 0.3;
      const w = strong ? 4 : 2;
      c.fillRect(x(k.time_s) - w / 2, strong ? top - 3 : top, w, bottom - top + (strong ? 6 : 0));
    }
    c.globalAlpha = 1;
  }

  function describe() {
    const k = state.keyframe;
    canvas.setAttribute('aria-valuemin', flight.keyframes[0]?.id ?? 0);
    canvas.setAttribute('aria-valuemax', flight.keyframes.at(-1)?.id ?? 0);
    canvas.setAttribute('aria-valuenow', k?.id ?? flight.keyframes[0]?.id ?? 0);
    canvas.setAttribute('aria-valuetext', k ? `keyframe ${k.id}, ${seconds(k.time_s)}, overlap ${percent(k.overlap)}` : 'no keyframe chosen');
  }

  let drag = null;
  canvas.addEventListener('pointerdown', (e) => {
    drag = { from: e.offsetX, moved: false };
    canvas.setPointerCapture(e.pointerId);
  });
  canvas.addEventListener('pointermove', (e) => {
    if (!drag) return hover(e);
    if (Math.abs(e.offsetX - drag.from) > 4) drag.moved = true;
    if (!drag.moved) return;
    const ends = [drag.from, e.offsetX].map((px) => Math.min(to, Math.max(from, timeAt(px)))).sort((p, q) => p - q);
    state.set({ span: ends });
  });
  canvas.addEventListener('pointerup', (e) => {
    const was = drag;
    drag = null;
    if (!was || was.moved) {
      if (was && state.span) say(`${state.chosen().size} keyframes between ${seconds(state.span[0])} and ${seconds(state.span[1])}`);
      return;
    }
    const k = nearest(timeAt(e.offsetX));
    state.set({ span: null });
    if (k) state.select(k);
  });
  canvas.addEventListener('pointercancel', () => { drag = null; });
  canvas.addEventListener('pointerleave', () => { tip.hidden = true; });

  function hover(e) {
    const lines = tipLines(e.offsetX, e.offsetY);
    tip.hidden = lines.length === 0;
    tip.replaceChildren(...lines.map((l) => element('div', {}, l)));
    tip.style.left = `${Math.min(e.offsetX + 12, width - 330)}px`;
  }
  function tipLines(px, py) {
    if (px < gutter) return [];
    if (py >= lanes.events[0] - 3 && py <= lanes.events[1] + 3) {
      const near = events.list.filter((e) => Math.abs(x(clamped(e)) - px) < 6).sort((p, q) => q.severity - p.severity);
      if (near.length) return [`${seconds(near[0].time_s)} · ${near[0].severity_name} · ${near[0].component}`, near[0].text, near[0].advice, ...(near.length > 1 ? [`and ${near.length - 1} more`] : [])];
    }
    const k = nearest(timeAt(px));
    if (!k || Math.abs(x(k.time_s) - px) > 14) return [seconds(timeAt(px))];
    return [`Keyframe ${k.id} · ${seconds(k.time_s)}`, `overlap ${percent(k.overlap)} · image ${bytesText(k.image?.bytes)} · depth ${bytesText(k.depth?.bytes)}`, k.verdict];
  }

  canvas.addEventListener('keydown', (e) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
    if (!by) return;
    e.preventDefault();
    e.stopPropagation();
    if (!e.shiftKey) {
      state.set({ span: null });
      return state.step(by);
    }
    const all = flight.keyframes;
    const [begin, end] = state.span ?? [state.keyframe?.time_s ?? from, state.keyframe?.time_s ?? from];
    const last = nearest(end);
    const next = all[Math.min(all.length - 1, Math.max(0, all.indexOf(last) + by))];
    if (next && next.time_s >= begin) state.set({ span: [begin, next.time_s] });
  });
  new ResizeObserver(draw).observe(root);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
  return { update: draw, x, canvas };
}
