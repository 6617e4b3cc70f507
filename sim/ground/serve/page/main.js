// Draws what has changed, at most once per frame of the screen.
import { Connection } from './connection.js';
import { StripMap } from './map.js';
import { bytesText, durationText, times } from './text.js';
import { plots } from './plot.js';
import { componentTable } from './costs.js';
import { storageFacts } from './storage.js';
import { eventList, facts, items, keyframeTable, link } from './tables.js';

const part = (name) => document.getElementById(name);
const put = (name, markup) => { part(name).innerHTML = markup || ''; };
const map = new StripMap(part('map'), part('map-note'), part('legend'));
let most = 50;  // rows of keyframes
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
  if (kinds.has('files')) put('files', items((flight.get('files') ?? []).map(link), 'No file yet.'));
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
  put('tiles', facts([
    ['keyframes', String(s.keyframes)], ['posed', String(s.posed)], ['with depth', String(s.with_depth)],
    ['products', `${s.products}, ${bytesText(s.product_bytes)}`],
    ['files received', `${s.files_used}, ${bytesText(s.received_bytes)}`],
    ['files not usable', String(s.files_skipped), s.files_skipped ? 'warn' : ''],
    ['events medium / high', `${s.medium} / ${s.high}`, s.high ? 'bad' : s.medium ? 'warn' : ''],
    ['missing', String(s.missing), s.missing ? 'warn' : ''],
    ['merged', run.state === 'merging' ? 'merging …' : new Date(run.utc_ms ?? 0).toLocaleTimeString()],
  ]));
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
  put('keyframes', keyframeTable(keyframes.slice(-most).reverse()));
  part('more').hidden = keyframes.length <= most;
  const { target_overlap: target } = flight.get('summary') ?? {};
  const overTime = (title, y, name, value, more) => ({
    title, x: 'mission time, s', y, counts: false, series: [{ name, style: 's1', mark: 'dots', points: keyframes.map(([, k]) => [k.t, value(k)]) }], ...more,
  });
  const received = overTime('Products received, by the time of their keyframe', 'kB', 'received', (k) => ((k.i?.[0] ?? 0) + (k.d?.[0] ?? 0)) / 1000);
  let sum = 0;
  received.series[0] = { ...received.series[0], mark: 'curve', points: received.series[0].points.map(([t, kilobytes]) => [t, sum += kilobytes]) };
  put('plots', plots([
    overTime('Overlap of a keyframe with the one before', '%', 'overlap', (k) => times(100, k.o), { fromZero: false, target: target == null ? null : 100 * target, targetName: 'target' }),
    overTime('Reprojection error of poses', 'px', 'error', (k) => k.e),
    overTime('Richness index', '0 to 1', 'richness', (k) => k.r),
    received,
  ]));
}

const drawEvents = () => put('events', eventList(flight.all('e'), Number(part('severity').value)));

function drawTelemetry() {
  const s = flight.get('storage');
  const t = flight.get('timing');
  const lines = storageFacts(s);
  if (t) {
    lines.push(['Minor frames', t.frames], ['Of them too late', t.overruns], ['Longest minor frame', durationText(t.longest_s)]);
  }
  put('telemetry', facts(lines.length > 0 ? lines : [['telemetry', 'nothing has come down yet']]));
  const components = flight.all('c').map(([, c]) => c);
  put('components', components.length > 0 && componentTable({ components, keyframes: flight.all('k') }));
}

function drawMissing() {
  const { all = 0, list = [] } = flight.get('missing') ?? {};
  const lines = list.map(([id, what]) => `keyframe ${id}: ${what}`);
  if (all > list.length) lines.push(`and ${all - list.length} more: see report.html`);
  put('missing', items(lines, 'Nothing is missing.'));
}

part('strip').addEventListener('change', () => { part('strip').dataset.chosen = part('strip').value; drawMap(); });
part('picture').addEventListener('change', () => drawMap());
part('severity').addEventListener('change', drawEvents);
part('more').addEventListener('click', () => { most += 200; drawFlight(); });
part('closer').addEventListener('click', () => map.closer(1.5));
part('farther').addEventListener('click', () => map.closer(1 / 1.5));
part('whole').addEventListener('click', () => map.whole());
drawTelemetry();
drawMissing();
drawEvents();
drawFlight();
// For tests and the curious: what has come, and how much.
window.ilpLive = flight;
