// Open MCT with the project's plugin, while files arrive: openmct_test.mjs BUILD_DIR ILP_GROUND SERVE

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { copyFileSync, mkdirSync, readdirSync, renameSync } from 'node:fs';
import { createRequire } from 'node:module';

const [build, ground, serve] = process.argv.slice(2);
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

function deliver(first, last) {
  for (const name of readdirSync(`${build}/downlink`)) {
    const number = Number(name.split('-')[1]?.slice(0, 6));
    if (name.startsWith('events') ? last < 8 : !(number >= first && number <= last)) continue;
    copyFileSync(`${build}/downlink/${name}`, `${build}/box/.part`);
    renameSync(`${build}/box/.part`, `${build}/box/${name}`);
  }
}

mkdirSync(`${build}/box`);
let browser;
try {
  const flight = await start(ground, 'serve', `${build}/box`, '--listen', '127.0.0.1:0');
  const address = await start(process.execPath, serve, '--flight', flight, '--listen', '127.0.0.1:0', '--openmct', `${build}/node/node_modules/openmct/dist`);
  deliver(1, 4);
  const state = async () => (await (await fetch(`http://${flight}/state`)).json()).set;
  const posed = async (count) => {
    for (let i = 0; i < 1200; ++i) {
      if ((await state()).summary?.posed === count) return;
      await new Promise((done) => setTimeout(done, 100));
    }
    throw new Error(`${count} keyframes are not posed`);
  };
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
  const request = (key) => page.evaluate(async (name) => {
    const object = await openmct.objects.get({ namespace: 'ilp', key: name });
    return openmct.telemetry.request(object, { start: 0, end: 86400 });
  }, key);
  const same = async (count) => {
    const told = await state();
    const found = await request('keyframes');
    assert.equal(found.length, count);
    for (const row of found) {
      const k = told[`k/${row.keyframe}`];
      assert.deepEqual([row.t, row.strip, row.x, row.y, row.z, row.error], [k.t, k.s, ...k.c, k.e]);
    }
    assert.deepEqual(found.map((row) => row.t), found.map((row) => row.t).sort((a, b) => a - b));
  };
  await same(4);
  // What comes later appears by itself.
  deliver(5, 8);
  await posed(8);
  await rows(8);
  await same(8);
  const shown = await page.locator('.c-telemetry-table').first().innerText();
  for (const name of ['Keyframe', 'Overlap', 'Reprojection error']) assert.ok(shown.includes(name), `${name} is no column of ${shown}`);
  const told = await state();
  assert.equal((await request('events')).length, Object.keys(told).filter((name) => name.startsWith('e/')).length);
  // Bounds are kept, as the conductor sets them.
  const middle = told['k/4'].t;
  const cut = await page.evaluate(async (end) => openmct.telemetry.request(await openmct.objects.get({ namespace: 'ilp', key: 'keyframes' }), { start: 0, end }), middle);
  assert.deepEqual(cut.map((row) => row.keyframe), [1, 2, 3, 4]);
  assert.deepEqual(complaints, [], 'no error, and nothing from elsewhere');
  console.log(`${(await request('keyframes')).length} keyframes and ${(await request('events')).length} events in Open MCT are those of ilp-ground serve`);
} finally {
  await browser?.close();
  for (const child of started) child.kill('SIGKILL');
}
