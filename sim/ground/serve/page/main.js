// The page of the report, of what has come so far. It is drawn at most once per frame of the screen.
import { Connection } from './connection.js';
import { sections } from './sections.js';
import { html } from './text.js';
import { showAgain, whatIsShown } from './zoom.js';

const part = (name) => document.getElementById(name);
const shown = [];  // of each section: its element, and its text
let [waiting, connection] = [false, ''];

const flight = new Connection(() => {
  if (!waiting) requestAnimationFrame(draw);
  waiting = true;
}, (text, kind) => {
  connection = text;
  part('connection').className = kind;
  tell();
});

function tell() {
  const { state, updates, utc_ms: time } = flight.get('run') ?? {};
  const run = state === 'merging' ? '; merging …' : updates > 0 ? `; latest run at ${new Date(time).toLocaleTimeString()}` : '';
  part('connection').textContent = connection + run;
}

function draw() {
  waiting = false;
  const report = flight.report();
  const { run = {}, title, totals } = report;
  tell();
  // What fails is tried again with the next update.
  if (report.commands) import('./commands.js').catch(() => {});
  part('problem').hidden = !run.problem;
  part('problem').textContent = run.problem ? `The files that have come cannot be merged yet: ${run.problem}` : '';
  part('waiting').hidden = Boolean(totals || run.problem || run.state === 'merging');
  if (!totals) return;
  document.title = `${title} – live flight`;
  const keyframes = Object.fromEntries(report.keyframes.map((k) => [k.id, picturesOf(k)]));
  [...sections(report, { figures: flight.figures(), keyframes }), results(report)].forEach(put);
}

const results = ({ results: names }) => html`<h2>Files</h2>
<ul class="files">${names.map((name) => html`<li><a href="${name.split('/').map(encodeURIComponent).join('/')}">${name}</a></li>`)}</ul>`;

// A new number of bytes makes another address, so that the browser does not keep the picture before.
function picturesOf({ id, pictures, image_product: image, depth_product: depth }) {
  const bytes = (image?.bytes ?? 0) + (depth?.bytes ?? 0);
  return Object.fromEntries(pictures.map((name) => [name, `keyframes/${String(id).padStart(6, '0')}-${name}.png?${bytes}`]));
}

const mapsIn = (place) => [...place.querySelectorAll('svg.map')].map((map) => [map.getAttribute('aria-label'), map]);

// What the reader has opened, closed or brought closer stays so. Files lie elsewhere than beside the report.
function put(section, i) {
  const text = html`${section}`.toString().replace(/<a href="/g, '<a target="_blank" rel="noopener" href="/files/').replace(/ src="/g, ' src="/files/');
  shown[i] ??= { place: i === 0 ? part('overview') : part('sections').appendChild(document.createElement('div')) };
  if (shown[i].text === text) return;
  const { place } = shown[i];
  const open = [...place.querySelectorAll('details')].map((d) => d.open);
  const seen = new Map(mapsIn(place).map(([label, map]) => [label, whatIsShown(map)]));
  place.innerHTML = text;
  place.querySelectorAll('details').forEach((d, j) => { d.open = open[j] ?? d.open; });
  for (const [label, map] of mapsIn(place)) if (seen.has(label)) showAgain(map, seen.get(label));
  shown[i].text = text;
}

// For tests and the curious: what has come, and how much.
window.ilpLive = flight;
