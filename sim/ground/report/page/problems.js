// Events and what to do about them, what has not come, and the files.

import { html, table, bulleted, paragraph, aside, fixed, brief, bytesText, counted } from './text.js';

const severityKind = (level) => (level >= 3 ? 'bad' : level === 2 ? 'warn' : 'sub');
const missionTime = (ns) => `${fixed(ns / 1e9, 1)} s`;

/// By kind, most severe first.
function groupsOf(events) {
  const groups = new Map();
  for (const event of events) {
    const key = `${event.level} ${event.code}`;
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(event);
  }
  return [...groups.values()].sort(([a], [b]) => b.level - a.level || a.code - b.code);
}

function groupRow(events) {
  const [first] = events;
  return [
    html`<span class="chip ${severityKind(first.level)}">${first.severity}</span>`, events.length,
    missionTime(first.time_ns), first.component,
    [first.text, events.length > 1 && aside(`(the first of ${events.length})`)], first.advice,
  ];
}

const everyEvent = (events) => html`<details><summary>${counted(events.length, 'event')} in order</summary>${
  table(['time', ['severity', 't'], ['component', 't'], ['event', 't w']],
    events.map((e) => [missionTime(e.time_ns), e.severity, e.component, [e.text, e.place && aside(e.place)]]))}</details>\n`;

function eventTables(events) {
  if (events.length === 0) return paragraph('No events came down.', 'note');
  return [table([['severity', 't'], 'times', 'first', ['component', 't'], ['what happened', 't w'], ['what to do', 't w']],
    groupsOf(events).map(groupRow)), everyEvent(events)];
}

function placeOf(report, missing) {
  if (!missing.centre) return '–';
  const strip = report.strips.find((s) => s.id === missing.strip);
  return `strip ${missing.strip}, x ${brief(missing.centre[0])}, y ${brief(missing.centre[1])}${strip ? ` ${strip.unit}` : ''}`;
}

function missingList(report) {
  const { missing } = report;
  if (missing.length === 0) return '';
  return html`<h3>What has not come down</h3>
<details${missing.length <= 12 && html` open`}><summary>${counted(missing.length, 'thing')}</summary>${
  table(['keyframe', ['missing', 't'], ['where', 't']], missing.map((m) => [m.keyframe, m.what, placeOf(report, m)]))}</details>
<p class="note">It may still be on its way, or have been abandoned on board. The same products again make the map more complete: run this command again.</p>\n`;
}

export function problems(report) {
  const notes = report.flight?.notes ?? [];
  return html`<h2>What went wrong, and what to do</h2>
${notes.length > 0 && html`<h3>What was said of the images and measurements before the flight</h3>\n${bulleted(notes)}`}${
  eventTables(report.events)}${missingList(report)}${
  report.remarks.length > 0 && html`<h3>Found on the ground</h3>${bulleted(report.remarks)}`}`;
}

export function files(report) {
  const t = report.totals;
  const skipped = report.files.filter((f) => f.fault !== null);
  return html`<h2>Files received</h2>
<p>${counted(t.files_used, 'file')} with ${bytesText(t.received_bytes)} used, ${t.files_skipped} skipped.</p>
${skipped.length > 0 && table([['skipped', 't w'], 'size', ['why', 't w']], skipped.map((f) => [f.name, bytesText(f.bytes), f.fault]))}`;
}
