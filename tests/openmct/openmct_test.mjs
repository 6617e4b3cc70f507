// Open MCT with the project's plugin, while files of a flight arrive: openmct_test.mjs BUILD_DIR ILP_GROUND SERVE OUTBOX

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readdirSync, renameSync } from 'node:fs';
import http from 'node:http';
import { createRequire } from 'node:module';

const [build, ground, serve, outbox] = process.argv.slice(2);
const { chromium } = createRequire(`${build}/node/`)('playwright-core');
const started = [];

// A program that prints its address first.
function start(program, ...options) {
  const child = spawn(program, options, { stdio: ['ignore', 'pipe', 'inherit'] });
  started.push(child);
  return new Promise((resolve, reject) => {
    child.on('exit', (code) => reject(new Error(`${program} ended with ${code}`)));
    child.stdout.on('data', (text) => { child.removeAllListeners('exit'); resolve(String(text).match(/http:\/\/(\S+)/)[1]); });
  });
}

const endOf = (child) => new Promise((done) => {
  child.on('exit', done);
  child.kill('SIGKILL');
});

// Records come last, as the order of names has it: with them a keyframe is there, and then it is whole.
const keyframes = 10;
function deliver(first, last, box = `${build}/box`) {
  for (const name of readdirSync(outbox)) {
    const number = Number(name.split('-')[1]?.slice(0, 6));
    if (name.startsWith('events') ? last < keyframes : !(number >= first && number <= last)) continue;
    copyFileSync(`${outbox}/${name}`, `${box}/.part`);
    renameSync(`${box}/.part`, `${box}/${name}`);
  }
}

mkdirSync(`${build}/box`);
let browser;
try {
  const flight = await start(ground, 'serve', `${build}/box`, '--listen', '127.0.0.1:0');
  const [server] = started;
  const address = await start(process.execPath, serve, '--flight', flight, '--listen', '127.0.0.1:0', '--openmct', `${build}/node/node_modules/openmct/dist`);
  deliver(1, 4);
  const state = async () => (await (await fetch(`http://${flight}/state`)).json()).set;
  const until = async (what, condition) => {
    for (let i = 0; i < 1200; ++i) {
      if (await condition()) return;
      await new Promise((done) => setTimeout(done, 100));
    }
    throw new Error(`waited in vain until ${what}`);
  };
  const posed = (count) => until(`${count} keyframes are posed`, async () => (await state()).totals?.final_poses === count);
  await posed(4);
  browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: process.getuid() === 0 ? ['--no-sandbox'] : [] });
  const page = await browser.newPage({ viewport: { width: 1366, height: 768 } });
  page.setDefaultTimeout(120000);
  const complaints = [];
  page.on('pageerror', (e) => complaints.push(e.message));
  page.on('request', (r) => { if (!r.url().startsWith(`http://${address}/`) && !/^(data|blob):/.test(r.url())) complaints.push(r.url()); });
  await page.goto(`http://${address}/#/browse/ilp:flight/ilp:keyframes?view=table`);
  // The table has the values that the server states, as a user sees them.
  const rows = (count) => page.waitForFunction((n) => document.querySelectorAll('.js-telemetry-table__content tr').length === n, count);
  await rows(4);
  const request = (key, bounds = {}) => page.evaluate(async ([name, start, end]) => {
    const object = await openmct.objects.get({ namespace: 'ilp', key: name });
    return openmct.telemetry.request(object, { start, end });
  }, [key, bounds.start ?? 0, bounds.end ?? 86400]);
  const numbers = (rows_) => rows_.map((row) => row.keyframe);
  const same = async (count) => {
    const told = await state();
    const found = await request('keyframes');
    assert.deepEqual(numbers(found), Array.from({ length: count }, (_, i) => i + 1), 'in the order of time');
    for (const row of found) {
      const k = told[`keyframes/${row.keyframe}`];
      assert.deepEqual([row.t, row.strip, row.overlap, row.richness, row.error],
        [k.time_ns / 1e9, k.strip, k.id === 1 ? undefined : k.overlap_with_previous, k.richness.index, k.pose.rms_px]);
      assert.deepEqual([row.x, row.y, row.z, row.image_bytes, row.depth_bytes], [...k.pose.centre, k.image_product.bytes, k.depth_product?.bytes]);
    }
    return told;
  };
  await same(4);
  // What comes later appears by itself.
  deliver(5, 7);
  await posed(7);
  await rows(7);
  await same(7);
  const shown = await page.locator('.c-telemetry-table').first().innerText();
  for (const name of ['Keyframe', 'Overlap', 'Reprojection error']) assert.ok(shown.includes(name), `${name} is no column of ${shown}`);
  // The server starts again, and the page finds it and what has come meanwhile.
  await endOf(server);
  deliver(8, keyframes);
  await start(ground, 'serve', `${build}/box`, '--listen', flight);
  const again = started.at(-1);
  await posed(keyframes);
  await rows(keyframes);
  const told = await same(keyframes);
  const events = Object.entries(told).filter(([name]) => name.startsWith('events/'));
  assert.ok(events.length > 0, 'the flight has events');
  const foundEvents = await request('events');
  assert.equal(foundEvents.length, events.length);
  for (const [name, e] of events) {
    const row = foundEvents.find((one) => `events/${one.event}` === name);
    assert.deepEqual([row.t, row.level, row.severity, row.name, row.component, row.text, row.advice],
      [e.time_ns / 1e9, e.level, e.severity, e.name, e.component, e.text, e.advice]);
  }
  // The storage has the time of the newest keyframe.
  const storage = await request('storage');
  assert.equal(storage.at(-1).t, told[`keyframes/${keyframes}`].time_ns / 1e9);
  for (const name of ['frame_bytes', 'depth_bytes', 'structure_bytes', 'product_bytes', 'budget_bytes', 'database_bytes', 'products_held',
    'products_acknowledged', 'products_dropped']) {
    assert.equal(storage.at(-1)[name], told.storage[name], name);
  }
  // Bounds are kept, as the conductor sets them.
  const [fourth, seventh] = [4, 7].map((id) => told[`keyframes/${id}`].time_ns / 1e9);
  assert.deepEqual(numbers(await request('keyframes', { start: fourth, end: seventh })), [4, 5, 6, 7]);
  // Of another flight at this address nothing is mixed with the one before.
  mkdirSync(`${build}/other-box`);
  deliver(1, 3, `${build}/other-box`);
  await endOf(again);
  await start(ground, 'serve', `${build}/other-box`, '--listen', flight);
  await posed(3);
  await until('three keyframes are left', async () => (await request('keyframes')).length === 3);
  await same(3);
  // Of the computer's files only those of Open MCT are given.
  assert.ok(existsSync(`${build}/node/package.json`));
  const status = (path) => new Promise((done) => {
    const [host, port] = address.split(':');
    http.get({ host, port, path }, (answer) => { answer.resume(); done(answer.statusCode); });
  });
  assert.deepEqual([await status('/openmct/openmct.js'), await status('/openmct/../../../package.json')], [200, 404]);
  assert.deepEqual(complaints, [], 'no error, and nothing from elsewhere');
  console.log(`${keyframes} keyframes, ${events.length} events and the storage in Open MCT are those of ilp-ground serve`);
} finally {
  await browser?.close();
  for (const child of started) child.kill('SIGKILL');
}
