// Draws what has changed, at most once per frame of the screen.
import { Connection } from './connection.js';
import { StripMap } from './map.js';
import { Plot } from './plots.js';
import { KeyframeTable, bytes, facts, link, milliseconds, showComponents, showEvents, showList } from './tables.js';

const part = (name) => document.getElementById(name);
const map = new StripMap(part('map'), part('map-note'), part('legend'));
const table = new KeyframeTable(part('keyframes'), part('more'));
const plots = {
  overlap: new Plot(part('plots'), 'Overlap of a keyframe with the one before', { unit: '%', values: [0, 100] }),
  error: new Plot(part('plots'), 'Reprojection error of poses', { unit: 'px', zero: true }),
  richness: new Plot(part('plots'), 'Richness index', { unit: '0 to 1', zero: true }),
  received: new Plot(part('plots'), 'Products received, by the time of their keyframe', { unit: 'kB', zero: true, line: true }),
};
let waiting = null;  // names that have changed since the page was drawn

const flight = new Connection((names) => {
  if (!waiting) requestAnimationFrame(draw);
  waiting = new Set([...(waiting ?? []), ...names]);
}, (text, kind) => {
  part('connection').textContent = text;
  part('connection').className = kind;
});

function draw() {
  const names = waiting ?? new Set();
  waiting = null;
  const kinds = new Set([...names].map((name) => name.split('/')[0]));
  if (kinds.has('summary') || kinds.has('run')) drawSummary();
  if (kinds.has('k') || kinds.has('strip')) drawFlight();
  if (kinds.has('e')) drawEvents();
  if (['storage', 'timing', 'c'].some((kind) => kinds.has(kind))) drawTelemetry();
  if (kinds.has('missing')) drawMissing();
  if (kinds.has('files')) showList(part('files'), (flight.get('files') ?? []).map(link), 'No file yet.');
}

function drawSummary() {
  const run = flight.get('run') ?? {};
  part('problem').hidden = !run.problem;
  part('problem').textContent = run.problem ? `The files that have come cannot be merged yet: ${run.problem}` : '';
  const s = flight.get('summary');
  part('waiting').hidden = Boolean(s || run.problem || run.state === 'merging');
  if (!s) return;
  part('title').textContent = s.title;
  document.title = `${s.title} – live flight`;
  part('viewer').hidden = !s.viewer;
  facts(part('tiles'), [
    ['keyframes', String(s.keyframes)], ['posed', String(s.posed)], ['with depth', String(s.with_depth)],
    ['products', `${s.products}, ${bytes(s.product_bytes)}`],
    ['files received', `${s.files_used}, ${bytes(s.received_bytes)}`],
    ['files not usable', String(s.files_skipped), s.files_skipped ? 'warn' : ''],
    ['events medium / high', `${s.medium} / ${s.high}`, s.high ? 'bad' : s.medium ? 'warn' : ''],
    ['missing', String(s.missing), s.missing ? 'warn' : ''],
    ['merged', run.state === 'merging' ? 'merging …' : new Date(run.utc_ms ?? 0).toLocaleTimeString()],
  ]);
}

function chooseStrip(strips) {
  const select = part('strip');
  const known = [...select.options].map((o) => o.value).join();
  const wanted = strips.map(([id]) => String(id));
  if (known !== wanted.join()) {
    // The newest strip is shown until the reader chooses another one.
    const chosen = select.dataset.chosen;
    select.replaceChildren(...wanted.map((id) => new Option(id, id)));
    select.value = wanted.includes(chosen) ? chosen : wanted.at(-1) ?? '';
  }
  return Number(select.value);
}

function drawMap(keyframes = flight.all('k')) {
  const id = chooseStrip(flight.all('strip'));
  map.show(flight.get(`strip/${id}`), keyframes.filter(([, k]) => k.s === id), part('picture').value);
}

function drawFlight() {
  const keyframes = flight.all('k');
  drawMap(keyframes);
  table.show(keyframes);
  plots.overlap.show(keyframes.map(([, k]) => [k.t, 100 * k.o]));
  plots.error.show(keyframes.map(([, k]) => [k.t, k.e]));
  plots.richness.show(keyframes.map(([, k]) => [k.t, k.r]));
  let sum = 0;
  plots.received.show(keyframes.map(([, k]) => [k.t, sum += ((k.i?.[0] ?? 0) + (k.d?.[0] ?? 0)) / 1000]));
}

function drawEvents() {
  showEvents(part('events'), flight.all('e'), Number(part('severity').value));
}

function drawTelemetry() {
  const s = flight.get('storage');
  const t = flight.get('timing');
  const lines = [];
  if (s) {
    const held = s.frames + s.depth + s.structure + s.products;
    lines.push(
      ['held on board', `${bytes(held)} of ${bytes(s.budget)}`],
      ['of it products', `${bytes(s.products)}, ${s.products_held}`],
      ['products confirmed', String(s.acknowledged)],
      ['products dropped', String(s.dropped), s.dropped ? 'bad' : ''],
      ['layers cut', String(s.layers_cut)],
      ['database', bytes(s.database)],
      ['times full', String(s.times_full), s.times_full ? 'warn' : '']);
  }
  if (t) {
    lines.push(
      ['minor frames', String(t.frames)],
      ['of them too late', String(t.overruns)],
      ['longest minor frame', milliseconds(t.longest_s)]);
  }
  facts(part('telemetry'), lines.length ? lines : [['telemetry', 'nothing has come down yet']]);
  showComponents(part('components'), flight.all('c'));
}

function drawMissing() {
  const { all = 0, list = [] } = flight.get('missing') ?? {};
  const lines = list.map(([id, what]) => `keyframe ${id}: ${what}`);
  if (all > list.length) lines.push(`and ${all - list.length} more: see report.html`);
  showList(part('missing'), lines, 'Nothing is missing.');
}

part('strip').addEventListener('change', () => { part('strip').dataset.chosen = part('strip').value; drawMap(); });
part('picture').addEventListener('change', () => drawMap());
part('severity').addEventListener('change', drawEvents);
part('closer').addEventListener('click', () => map.closer(1.5));
part('farther').addEventListener('click', () => map.closer(1 / 1.5));
part('whole').addEventListener('click', () => map.whole());
drawTelemetry();
drawMissing();
drawEvents();
for (const plot of Object.values(plots)) plot.show([]);
// For tests and the curious: what has come, and how much.
window.ilpLive = flight;
