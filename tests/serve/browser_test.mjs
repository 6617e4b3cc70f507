// What the pages promise, asked of a real browser: browser_test.mjs VIEWER_BUILD_DIR ILP_GROUND WORK ILP_SIL

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { copyFileSync, mkdirSync, readdirSync, renameSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { dirname } from 'node:path';
import { fileURLToPath } from 'node:url';

const [build, ground, work, sil] = process.argv.slice(2);
const { chromium } = createRequire(`${build}/node/`)('playwright-core');
const sandbox = process.getuid() === 0 ? ['--no-sandbox'] : [];
const patience = { timeout: 120000 };
const title = 'Valley <b>of</b> <img src=x onerror="document.title=1">';

function serve(box, listen) {
  const options = ['serve', box, '--listen', listen, '--title', title];
  const process_ = spawn(ground, options, { stdio: ['ignore', 'pipe', 'inherit'] });
  programs.push(process_);
  return new Promise((resolve, reject) => {
    process_.on('exit', (code) => reject(new Error(`ilp-ground serve ended with ${code}`)));
    process_.stdout.on('data', (text) => resolve({ url: String(text).match(/http:\/\/\S+/)[0], end: () => end(process_) }));
  });
}

function end(process_) {
  return new Promise((resolve) => {
    process_.removeAllListeners('exit');
    process_.on('exit', resolve);
    process_.kill('SIGKILL');
  });
}

function deliver(source, box, chosen = () => true) {
  mkdirSync(box, { recursive: true });
  for (const name of readdirSync(`${work}/${source}`)) {
    if (!chosen(name)) continue;
    copyFileSync(`${work}/${source}/${name}`, `${box}/.part`);
    renameSync(`${box}/.part`, `${box}/${name}`);
  }
}
const upTo = (last) => (name) => !name.startsWith('events') && Number(name.split('-')[1].slice(0, 6)) <= last;

const tile = (page, name) => page.locator('.tile', { hasText: name }).locator('.value');
const rows = (page) => page.locator('.keyframes tr');
const dots = (page, title) => page.locator(`svg[aria-label="${title}"] .dot`).count();
const posed = (page, count) => page.waitForFunction((n) => window.ilpLive?.get('totals')?.final_poses === n, count, patience);
const merged = (page) => page.waitForFunction(() => window.ilpLive?.get('run')?.state === 'waiting', null, patience);
const drawn = (page) => page.evaluate(() => new Promise((done) => {
  requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 300)));
}));
const picture = (page, name) => page.screenshot({ path: `${work}/pictures/${name}.png`, fullPage: true });
// The orthoimage: its keyframes, what is shown of it, and whether its picture is there.
const seen = (page) => page.evaluate(async () => {
  const map = document.querySelector('svg.map');
  const image = new Image();
  image.src = map.querySelector('image').href.baseVal;
  await image.decode();
  const view = JSON.parse(map.dataset.view);
  return {
    keyframes: map.querySelectorAll('.stop').length, box: map.getAttribute('viewBox').split(' ').map(Number), scale: map.querySelector('.scale').textContent,
    whole: image.naturalWidth === view.width && image.naturalHeight === view.height, number: map.querySelector('.number').getBoundingClientRect().height,
  };
});

// The least contrast of a text with what lies behind it, by WCAG 2.
const leastContrast = (page) => page.evaluate(() => {
  const numbers = (colour) => colour.match(/[\d.]+/g).map(Number);
  const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  const light = (rgb) => rgb.slice(0, 3).map((c) => linear(c / 255))
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const behind = (element) => {
    for (let e = element; e; e = e.parentElement) {
      const colour = numbers(getComputedStyle(e).backgroundColor);
      if (colour.length < 4 || colour[3] > 0) return colour;
    }
    return [255, 255, 255];
  };
  let least = [99, ''];
  for (const element of document.querySelectorAll('body *')) {
    const hasText = [...element.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
    if (!hasText || !element.checkVisibility()) continue;
    const [a, b] = [light(numbers(getComputedStyle(element).color)), light(behind(element))].sort((x, y) => y - x);
    const contrast = (a + 0.05) / (b + 0.05);
    if (contrast < least[0]) least = [contrast, element.outerHTML.slice(0, 80)];
  }
  return least;
});

async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, ...options });
  const page = await context.newPage();
  const complaints = [], requests = [];
  page.on('pageerror', (e) => complaints.push(e.message));
  page.on('console', (m) => {
    // A browser reports the lost connection itself.
    if (m.type() === 'error' && !/ERR_|Failed to load resource/.test(m.text())) complaints.push(m.text());
  });
  page.on('request', (r) => requests.push(r.url()));
  await page.goto(url);
  return { page, complaints, requests, context };
}

async function grows(browser) {
  const box = `${work}/box`;
  mkdirSync(box);
  let server = await serve(box, '127.0.0.1:0');
  const { page, complaints, requests } = await open(browser, server.url);
  await page.locator('#waiting', { hasText: 'Waiting for the first file' }).waitFor(patience);
  assert.equal(await page.locator('#problem').isHidden(), true, 'nothing is wrong yet');
  const tracks = [];
  for (const last of [2, 5]) {
    deliver('downlink', box, upTo(last));
    await posed(page, last);
    await drawn(page);
    assert.equal(await tile(page, 'Keyframes with final pose').textContent(), `${last} of ${last}`);
    assert.equal(await rows(page).count(), last + 1, 'a row each, and the head');
    tracks.push((await seen(page)).keyframes);
  }
  assert.deepEqual(tracks, [2, 5], 'the track grows with the map');
  await merged(page);
  await drawn(page);
  assert.ok((await seen(page)).whole, 'the orthoimage is there, at its size');
  assert.equal(await page.locator('#problem').isHidden(), true);
  assert.equal(await page.locator('#waiting').isHidden(), true);
  assert.match(await rows(page).nth(2).locator('td').nth(3).textContent(), /^\d+\.\d %$/, 'overlap in per cent');
  const drawnDots = [await dots(page, 'Overlap with the latest keyframe'), await dots(page, 'Reprojection error of the adjustment window')];
  assert.deepEqual(drawnDots, [4, 5], 'a dot of each keyframe that has the value');
  assert.ok(await page.locator('.frame img').evaluateAll((all) => all.length > 0 && Promise.all(all.map((image) => {
    image.loading = 'eager';
    return image.decode().then(() => image.naturalWidth > 0);
  }))), 'the pictures of the keyframes come');
  await page.locator('svg.map[aria-label="heights of strip 1"]', { hasText: 'Height above the mean plane' }).waitFor(patience);
  assert.equal(await page.locator('h1').textContent(), title, 'what is given is text');
  assert.equal(await page.locator('h1 *').count(), 0);
  assert.deepEqual([await page.locator('h2', { hasText: /^Files$/ }).count(), await page.locator('text=undefined').count()], [1, 0]);

  const before = await seen(page);
  const map = page.locator('svg.map').first();
  const under = (x, y) => map.evaluate((m, p) => { const { x: u, y: v } = new DOMPoint(...p).matrixTransform(m.getScreenCTM().inverse()); return [u, v]; }, [x, y]);
  await map.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await map.boundingBox();
  const [px, py] = [Math.round(x + 0.3 * width), Math.round(y + 0.6 * height)];
  const pointed = await under(px, py);
  await page.mouse.dblclick(px, py);
  const still = await under(px, py);
  assert.ok(Math.hypot(still[0] - pointed[0], still[1] - pointed[1]) < 0.5, `what is pointed at stays: ${pointed}, ${still}`);
  await page.keyboard.press('+');
  const near = await seen(page);
  assert.ok(Math.abs(near.box[2] - before.box[2] / 3) < 1e-6, `three times closer: ${near.box}`);
  assert.notEqual(near.scale, before.scale);
  assert.ok(Math.abs(near.number - before.number) < 1, 'a number keeps its size on the screen');
  const [left, top] = near.box;
  await page.mouse.move(640, 400);
  await page.keyboard.press('ArrowRight');
  const moved = await seen(page);
  assert.ok(moved.box[0] > left && moved.box[1] === top, `it moves: ${moved.box}`);
  deliver('downlink', box, upTo(6));
  await posed(page, 6);
  await merged(page);
  await drawn(page);
  const later = await seen(page);
  assert.equal(later.keyframes, 6);
  assert.ok(later.box[2] < before.box[2] / 2, 'what comes later leaves the figure as near as it is');
  await page.keyboard.press('-');
  assert.ok((await seen(page)).box[2] > later.box[2], 'and the focus where it is');

  await page.reload();
  await posed(page, 6);
  await drawn(page);
  assert.equal(await rows(page).count(), 7, 'a reload loses nothing');

  await server.end();
  await page.locator('#connection', { hasText: 'not connected since' }).waitFor(patience);
  assert.equal(await tile(page, 'Keyframes with final pose').textContent(), '6 of 6', 'what has come stays on the page');
  await picture(page, 'not-connected');
  deliver('downlink', box);
  server = await serve(box, server.url.split('//')[1]);
  await posed(page, 10);
  await page.locator('#connection.good', { hasText: 'connected' }).waitFor(patience);
  await merged(page);
  await drawn(page);
  assert.equal(await tile(page, 'Keyframes with final pose').textContent(), '10 of 10', 'a restart of the server loses nothing');
  await picture(page, 'wide');

  // What comes later leaves open what the reader has opened, and is text.
  await page.locator('summary', { hasText: 'in order' }).click();
  await page.evaluate(() => {
    ilpLive.all('events')[0][1].text = 'What <img src="x"> <a href="y">says</a>';
    ilpLive.changed(new Set());
  });
  await page.locator('details[open] td', { hasText: 'What <img src="x"> <a href="y">says</a>' }).waitFor(patience);
  assert.equal(await page.locator('td img, td a').count(), 0);

  const opened = page.context().waitForEvent('page');
  await page.locator('a[href="/files/viewer.html"]').first().click();
  const viewer = await opened;
  await viewer.waitForLoadState();
  assert.equal(new URL(viewer.url()).pathname, '/files/viewer.html');
  assert.equal(await viewer.evaluate(() => self.origin), 'null', 'a file of the results is a page of no origin');
  assert.equal(await page.locator('#token-form').count(), 0, 'no panel of commands where none was asked for');
  const elsewhere = requests.filter((r) => !r.startsWith(`${server.url}/`) && !r.startsWith('data:'));
  assert.deepEqual(elsewhere, [], 'nothing from elsewhere');
  assert.deepEqual(complaints, []);
  return server;
}

async function isLegible(browser, url) {
  for (const colorScheme of ['light', 'dark']) {
    for (const width of [420, 1280]) {
      const { page, context } = await open(browser, url, { viewport: { width, height: 800 }, colorScheme });
      await posed(page, 10);
      await drawn(page);
      const fits = await page.evaluate(() => document.scrollingElement.scrollWidth <= innerWidth);
      assert.ok(fits, `nothing is cut at ${width} px`);
      const [contrast, where] = await leastContrast(page);
      assert.ok(contrast >= 4.5, `contrast ${contrast} of ${where}`);
      console.log(`${width} px, ${colorScheme}: least contrast ${contrast.toFixed(2)}`);
      await picture(page, `${width}-${colorScheme}`);
      await context.close();
    }
  }
}

async function thousandKeyframes(browser) {
  const box = `${work}/long-box`;
  deliver('long', box, upTo(999));
  const server = await serve(box, '127.0.0.1:0');
  const { page, complaints } = await open(browser, server.url);
  await posed(page, 999);
  await merged(page);
  const before = await page.evaluate(() => ({ bytes: ilpLive.bytes, updates: ilpLive.updates }));
  deliver('long', box, (name) => name.includes('001000'));
  await posed(page, 1000);
  await merged(page);
  const after = await page.evaluate(() => ({ bytes: ilpLive.bytes, updates: ilpLive.updates }));
  const sent = after.bytes - before.bytes;
  const frame_ms = await page.evaluate(async () => {
    const times = [];
    for (let i = 0; i < 60; ++i) {
      ilpLive.get('keyframes/1000').pose.rms_px += 0.01;
      ilpLive.changed(new Set(['keyframes/1000']));
      times.push(await new Promise(requestAnimationFrame));
    }
    return (times.at(-1) - times[0]) / (times.length - 1);
  });
  console.log(`keyframe 1000: ${sent} bytes in ${after.updates - before.updates} updates`);
  console.log(`the first 999: ${before.bytes} bytes`);
  console.log(`${frame_ms.toFixed(1)} ms per frame while everything is drawn again`);
  assert.ok(sent < before.bytes / 20, `only what has changed is sent: ${sent} bytes`);
  const paths = await page.locator('.plots .dots').count();
  assert.deepEqual([await dots(page, 'Image Richness Index and novelty'), paths > 2], [0, true], 'many dots are one path');
  assert.equal(await rows(page).count(), 1001);
  assert.deepEqual(complaints, []);
  await server.end();
}

const token = 'only-for-this-test-7c1f9a';

// The first line of what a program says that has this form. The program ends with the test.
const programs = [];
process.on('exit', () => programs.forEach((one) => one.kill('SIGTERM')));
function started(program, args, environment, form) {
  const process_ = spawn(program, args, { stdio: ['ignore', 'pipe', 'inherit'], env: { ...process.env, ...environment } });
  programs.push(process_);
  let said = '';
  return new Promise((resolve, reject) => {
    process_.on('exit', (code) => reject(new Error(`${program} ended with ${code}`)));
    process_.stdout.on('data', (text) => {
      said += text;
      const found = said.match(form);
      if (found) resolve({ found: found[1], process: process_ });
    });
  });
}

async function givesCommands(browser) {
  const here = dirname(fileURLToPath(import.meta.url));
  const flight = await started('python3', ['-B', `${here}/flight.py`, sil, `${work}/commanded`], {}, /^(127\.\S+)\n/);
  const box = `${work}/commands-box`;
  mkdirSync(box);
  const server = await started(ground, ['serve', box, '--listen', '127.0.0.1:0', '--commands', flight.found],
    { ILP_COMMAND_TOKEN: token }, /The flight is at (http:\S+)\n/);
  const url = server.found;
  const { page, complaints, requests, context } = await open(browser, url, { viewport: { width: 420, height: 800 } });

  const enter = async (text) => {
    await page.locator('#token').fill(text);
    await page.locator('#token').press('Enter');
  };
  await enter('a-wrong-token-of-somebody');
  await page.locator('#token-problem', { hasText: 'the token is wrong' }).waitFor(patience);
  assert.equal(await page.locator('#desk').isHidden(), true);
  await enter(token);
  await page.locator('#desk').waitFor(patience);
  await page.locator('#panel li', { hasText: 'always in contact' }).waitFor(patience);

  const send = async (line) => {
    await page.locator('#line').fill(line);
    await page.locator('#line').press('Enter');
  };
  const report = (text) => page.locator('#reports li', { hasText: text }).first().waitFor(patience);
  await send('capture +1');
  await report('accepted: capture +1');
  await report('done: capture +1');
  const said = await page.locator('#reports li').allTextContents();
  const line = (text) => said.findIndex((one) => one.includes(text));
  assert.ok(line('accepted: capture +1') < line('done: capture +1'), 'reports are read from top to bottom');
  await page.locator('#panel li', { hasText: '1 frames' }).waitFor(patience);
  await send('set overlap.target_overlap 7');
  await page.locator('#answer.bad', { hasText: 'not a number from 0.5 to 0.98' }).waitFor(patience);
  await send('set <img/src=x> 1');
  await page.locator('#answer.bad', { hasText: 'not <img/src=x>' }).waitFor(patience);
  await page.locator('#line').fill('set overlap.tar');
  await page.waitForFunction(() => [...document.querySelectorAll('#complete option')]
    .some((o) => o.value === 'set overlap.target_overlap'), null, patience);
  const fits = await page.evaluate(() => document.scrollingElement.scrollWidth <= innerWidth);
  assert.ok(fits, 'nothing is cut at 420 px');
  const [contrast, where] = await leastContrast(page);
  assert.ok(contrast >= 4.5, `contrast ${contrast} of ${where}`);
  await picture(page, 'commands');

  const kept = await page.evaluate(() => [document.cookie, JSON.stringify({ ...localStorage }),
    JSON.stringify({ ...sessionStorage }), location.href].join());
  assert.ok(!kept.includes(token), `nothing keeps the token: ${kept}`);
  assert.ok(!requests.some((r) => r.includes(token)), 'no address has the token');
  await page.reload();
  await page.locator('#token').waitFor(patience);
  assert.equal(await page.locator('#desk').isHidden(), true, 'a reload asks for the token again');

  // A page of another site, in the browser of an operator.
  const site = createServer((_, answer) => answer.end('<!doctype html><title>another site</title>')).listen(0, '127.0.0.1');
  await new Promise((done) => { site.on('listening', done); });
  const other = await context.newPage();
  await other.goto(`http://127.0.0.1:${site.address().port}/`);
  const tried = await other.evaluate(async ([to, secret]) => {
    const results = [];
    for (const mode of ['cors', 'no-cors']) {
      const headers = { 'Content-Type': 'application/json', Authorization: `Bearer ${secret}` };
      try {
        const answer = await fetch(`${to}/commands`, { method: 'POST', mode, headers, body: '{"line":"ping"}' });
        results.push(`${answer.type} ${answer.status}`);
      } catch {
        results.push('refused');
      }
    }
    const frame = document.createElement('iframe');
    frame.src = to;
    document.body.append(frame);
    await new Promise((done) => { frame.onload = done; setTimeout(done, 3000); });
    return results;
  }, [url, token]);
  assert.deepEqual(tried, ['refused', 'refused']);
  const titles = await Promise.all(other.frames().map((frame) => frame.title()));
  assert.equal(titles.length, 2, 'the page of the other site and its frame');
  assert.ok(!titles.some((one) => /live flight/i.test(one)), 'no other site shows the page');
  site.close();
  await enter(token);
  await report('done: capture +1');
  assert.equal(await page.locator('#reports li', { hasText: 'ping' }).count(), 0, 'nothing came from the other site');

  server.process.removeAllListeners('exit');
  server.process.kill('SIGKILL');
  await page.locator('#connection.bad', { hasText: 'not connected' }).waitFor(patience);
  flight.process.removeAllListeners('exit');
  flight.process.kill('SIGTERM');
  assert.deepEqual(complaints, []);
  await context.close();
}

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: sandbox });
const servers = [];
try {
  await givesCommands(browser);
  servers.push(await grows(browser));
  await isLegible(browser, servers[0].url);
  await thousandKeyframes(browser);
} finally {
  await browser.close();
  for (const server of servers) await server.end();
}
