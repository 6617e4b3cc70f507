// What the viewer promises, asked of a real browser: viewer_test.mjs BUILD_DIR. Heights are compared with the grid that
// ilp-ground wrote beside the page, read here on its own.

import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { readFileSync, writeFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { Grid } from './grid_file.mjs';

const build = process.argv[2];
const { chromium } = createRequire(`${build}/node/`)('playwright-core');
const software = ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'];
const noWebgl = ['--disable-3d-apis'];
const sandbox = process.getuid() === 0 ? ['--no-sandbox'] : [];

async function browse(file, args, look, options = {}) {
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: [...args, ...sandbox] });
  try {
    const context = await browser.newContext({ viewport: { width: 1366, height: 768 }, colorScheme: 'dark', ...options });
    const page = await context.newPage();
    page.setDefaultTimeout(patienceMs);
    const complaints = [];
    const requests = [];
    page.on('console', (m) => { if (['error', 'warning'].includes(m.type())) complaints.push(m.text()); });
    page.on('pageerror', (e) => complaints.push(e.message));
    page.on('request', (r) => requests.push(r.url()));
    const url = pathToFileURL(file).href;
    await page.goto(url);
    await page.waitForSelector('html[data-ready]');
    await look(page);
    assert.deepEqual(requests.filter((r) => r !== url && !/^(data|blob):/.test(r)), [], 'the page asks for nothing');
    // Software rendering warns of itself; a browser without WebGL is asked for one and says so.
    const real = complaints.filter((c) => !/GPU stall due to ReadPixels|swiftshader/i.test(c) && !(args === noWebgl && /WebGL/.test(c)));
    assert.deepEqual(real, [], 'nothing on the console');
  } finally {
    await browser.close();
  }
}

const picture = (page, name) => page.screenshot({ path: `${build}/pictures/${name}.png` });
// Until a condition holds; how long that takes depends on the machine and decides nothing.
const patienceMs = 120000;
async function until(what, condition) {
  const end = Date.now() + patienceMs;
  for (;;) {
    const found = await condition();
    if (found) return found;
    assert.ok(Date.now() < end, `waited in vain until ${what}`);
    await new Promise((done) => setTimeout(done, 50));
  }
}
// The scene has been drawn after this call.
async function drawn(page) {
  const before = await page.evaluate(() => { const { frames } = ilpViewer.scene; ilpViewer.scene.request(); return frames; });
  await page.waitForFunction((frames) => ilpViewer.scene.frames > frames, before);
}
// The view without what lies over it, in full detail: while it turns on a slow machine it is drawn coarsely. What is drawn
// reaches the screen some time later: until two pictures in a row are the same.
async function stage(page) {
  await until('the view is drawn in full detail', async () => {
    await drawn(page);
    return page.evaluate(() => ilpViewer.scene.renderer.getPixelRatio() === Math.min(devicePixelRatio, 2));
  });
  const take = () => page.locator('.stage').screenshot({ style: '.legend,.scale,.views,.hint{visibility:hidden}' });
  let before = await take();
  return until('the view stands still', async () => {
    const now = await take();
    const same = now.equals(before);
    before = now;
    return same && now;
  });
}
// Two pictures in a row may both be those of before.
const shows = (page, what, expected) => until(what, async () => { const now = await stage(page); return (await expected(now)) && now; });
const differs = (page, before, what) => shows(page, what, (now) => !now.equals(before));
// Distinct colours of a screenshot, read by the browser itself.
const colours = (page, png) => page.evaluate(async (data) => {
  const image = new Image();
  image.src = `data:image/png;base64,${data}`;
  await image.decode();
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [image.width, image.height];
  const context = canvas.getContext('2d');
  context.drawImage(image, 0, 0);
  return new Set(new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer)).size;
}, png.toString('base64'));
const fact = (page, name) => page.locator('.facts dt', { hasText: new RegExp(`^${name}$`) }).first().evaluate((dt) => dt.nextElementSibling.textContent);
const near = (a, b, tolerance, what) => assert.ok(Math.abs(a - b) <= tolerance, `${what}: ${a} and ${b}`);

const flightFile = `${build}/flight/viewer.html`;
const grid = new Grid(`${build}/flight`);
const report = JSON.parse(readFileSync(`${build}/flight/report.json`, 'utf8'));

const tests = {
  'terrain, track and keyframes are all there': async (page) => {
    await picture(page, 'first-view');
    const { vertices, cameras, posed, calls } = await page.evaluate(() => ({
      vertices: ilpViewer.scene.terrain.vertices, cameras: ilpViewer.scene.track.cameras.count,
      posed: ilpViewer.flight.totals.final_poses, calls: ilpViewer.scene.calls,
    }));
    const stride = await page.evaluate(() => ilpViewer.state.strip.grid.stride);
    assert.equal(vertices, grid.covered(stride));
    assert.equal(cameras, posed);
    assert.equal(posed, report.keyframes.filter((k) => k.pose?.state === 'final').length);
    assert.ok(calls <= 12, `${calls} draw calls`);
    const show = (on) => page.evaluate((visible) => { ilpViewer.scene.terrain.mesh.visible = visible; }, on);
    const with_ = await stage(page);
    await show(false);
    const without = await colours(page, await differs(page, with_, 'the surface is hidden'));
    await show(true);
    await shows(page, `the surface has 150 colours more than the view without it, ${without}`, async (now) => (await colours(page, now)) > without + 150);
  },
  'the whole page fits a laptop': async (page) => {
    const over = await page.evaluate(() => [...document.querySelectorAll('header *, .tools *, .tabs *, .timeline, .legend, .scale')].filter((n) => {
      const r = n.getBoundingClientRect();
      return r.width && (r.right > innerWidth + 1 || r.bottom > innerHeight + 1 || r.left < -1);
    }).filter((n) => !n.matches('option')).map((n) => n.outerHTML.slice(0, 80)));
    assert.deepEqual(over, []);
    assert.ok(await page.evaluate(() => document.documentElement.scrollHeight <= innerHeight));
  },
  'every colour and every switch changes the picture': async (page) => {
    const seen = [];
    for (const key of ['1', '2', '3', '4', '5', '6', '7']) {
      await page.keyboard.press(key);
      seen.push(await shows(page, `colour ${key} is unlike those before`, (now) => seen.every((other) => !now.equals(other))));
      await picture(page, `layer-${key}`);
    }
    await page.keyboard.press('2');
    await shows(page, 'colour 2 is back', (now) => now.equals(seen[1]));
    for (const key of ['t', 'f', 'u']) {
      await page.keyboard.press(key);
      await differs(page, seen[1], `${key} changes the picture`);
      await page.keyboard.press(key);
      await shows(page, `${key} twice changes nothing`, (now) => now.equals(seen[1]));
    }
    await page.keyboard.press('1');
  },
  'footprints lie on the surface': async (page) => {
    // Without exaggeration; the lines are drawn a little above the ground so that it does not hide them.
    const points = await page.evaluate(() => {
      const { scene, state } = ilpViewer;
      const before = state.exaggeration;
      scene.track.setExaggeration(1);
      const at = [...scene.track.footprints.geometry.attributes.position.array];
      scene.track.setExaggeration(before);
      const [a, b, c] = state.strip.plane;
      const g = state.strip.grid;
      const [ox, oy] = [g.x0 + 0.5 * g.width * g.cell, g.y0 - 0.5 * g.height * g.cell];
      const points = [];
      for (let i = 0; i < at.length; i += 3) points.push([at[i] + ox, at[i + 1] + oy, at[i + 2] + a * (at[i] + ox) + b * (at[i + 1] + oy) + c]);
      return points;
    });
    const over = points.filter(([x, y]) => grid.surrounded(x, y)).map(([x, y, z]) => z - grid.height(x, y)).sort((p, q) => p - q);
    assert.ok(over.length > 100, `${over.length} points of footprints are over what was seen`);
    // The page's grid may be coarser than the file: nearly all, not all.
    const [low, high] = [over[Math.floor(0.02 * over.length)], over[Math.floor(0.98 * over.length)]];
    const height = await page.evaluate(() => ilpViewer.state.strip.flying_height);
    assert.ok(high - low < 0.01 * height, `from ${low} to ${high} above the surface, flown at ${height}`);
  },
  'a flight without links has their switch off': async (page) => {
    const links = page.locator('[data-show=links]');
    assert.equal(report.joined, undefined);
    assert.ok(await links.isDisabled());
    assert.equal(await links.getAttribute('aria-pressed'), 'false');
    await page.keyboard.press('l');
    assert.equal(await links.getAttribute('aria-pressed'), 'false');
    assert.equal(await page.locator('.legend .links').count(), 0);
  },
  'relief is exaggerated': async (page) => {
    const before = await stage(page);
    await page.keyboard.press('x');
    await page.keyboard.press('x');
    await differs(page, before, 'the relief is higher');
    await page.keyboard.press('X');
    await page.keyboard.press('X');
    await shows(page, 'the relief is as before', (now) => now.equals(before));
  },
  'nothing is drawn while nothing changes': async (page) => {
    await drawn(page);
    // In forty frames of the browser. What was asked for before may still be drawn.
    await until('the scene is not drawn again', () => page.evaluate(() => new Promise((done) => {
      const { frames } = ilpViewer.scene;
      const wait = (n) => (n === 0 ? done(ilpViewer.scene.frames === frames) : requestAnimationFrame(() => wait(n - 1)));
      wait(40);
    })));
  },
  'a click tells the height of the grid, and who saw the place': async (page) => {
    for (const share of [0.3, 0.5, 0.7]) {
      const [x, y] = grid.somePlace(share);
      const [px, py] = await page.evaluate(([u, v]) => ilpViewer.scene.screenOf(u, v), [x, y]);
      const box = await page.locator('#view').boundingBox();
      await page.mouse.click(box.x + px, box.y + py);
      const place = await page.evaluate(() => ilpViewer.state.place);
      assert.ok(place, 'there is a place under the pointer');
      const told = Number.parseFloat(await fact(page, 'Height'));
      near(told, grid.height(place.x, place.y), 0.0006, 'height');
    }
    assert.ok((await page.locator('.sighting').count()) > 0);
    await picture(page, 'place');
    const id = Number(await page.locator('.sighting').first().textContent().then((t) => t.trim().split(' ')[0]));
    await page.locator('.sighting').first().click();
    assert.equal(await page.evaluate(() => ilpViewer.state.keyframe.id), id);
    assert.ok((await page.locator('.pictures img').count()) >= 1);
    await picture(page, 'keyframe');
  },
  'a profile is that of the grid, on the page and in its table': async (page) => {
    const ends = [grid.somePlace(0.25), grid.somePlace(0.75)];
    await page.keyboard.press('Escape');
    await page.keyboard.press('p');
    const box = await page.locator('#view').boundingBox();
    for (const end of ends) {
      const [px, py] = await page.evaluate((e) => ilpViewer.scene.screenOf(...e), end);
      await page.mouse.click(box.x + px, box.y + py);
    }
    const { a, b } = await page.evaluate(() => ilpViewer.state.profile);
    near(Number.parseFloat(await fact(page, 'Distance')), Math.hypot(b.x - a.x, b.y - a.y), 0.0006, 'distance');
    near(Number.parseFloat(await fact(page, 'Drop')), grid.height(a.x, a.y) - grid.height(b.x, b.y), 0.0012, 'drop');
    await picture(page, 'profile');
    const withLine = await stage(page);
    await page.evaluate(() => { ilpViewer.scene.marks.line.visible = false; });
    await differs(page, withLine, 'the line is gone that was drawn');
    const [download] = await Promise.all([page.waitForEvent('download'), page.locator('#csv').click()]);
    const rows = readFileSync(await download.path(), 'utf8').trim().split('\n').slice(1).map((r) => r.split(','));
    assert.ok(rows.length > 20);
    for (const [, x, y, z] of rows) {
      const expected = grid.height(Number(x), Number(y));
      if (z === '') assert.ok(Number.isNaN(expected) || !grid.surrounded(Number(x), Number(y)));
      else if (grid.surrounded(Number(x), Number(y))) near(Number(z), expected, 0.0006, `height at ${x}, ${y}`);
    }
  },
  'the timeline chooses keyframes by a drag and by keys': async (page) => {
    await page.keyboard.press('Escape');
    const box = await page.locator('#timeline').boundingBox();
    await page.mouse.move(box.x + 0.3 * box.width, box.y + 30);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.7 * box.width, box.y + 30, { steps: 5 });
    await page.mouse.up();
    const { span, chosen, expected } = await page.evaluate(() => ({
      span: ilpViewer.state.span, chosen: ilpViewer.state.chosen().size,
      expected: ilpViewer.flight.keyframes.filter((k) => k.time_s >= ilpViewer.state.span[0] && k.time_s <= ilpViewer.state.span[1]).length,
    }));
    assert.ok(span[1] > span[0] && chosen > 1);
    assert.equal(chosen, expected);
    await page.keyboard.press('5');
    await drawn(page);
    await picture(page, 'span');
    await page.keyboard.press('Escape');
    await page.locator('#timeline').focus();
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('ArrowRight');
    assert.equal(await page.evaluate(() => ilpViewer.state.keyframe === ilpViewer.flight.keyframes[1]), true);
    await page.keyboard.press('1');
  },
  'all of it by keyboard': async (page) => {
    await page.keyboard.press('Escape');
    await page.evaluate(() => document.activeElement?.blur());
    let found = false;
    for (let i = 0; i < 30 && !found; ++i) {
      await page.keyboard.press('Tab');
      found = await page.evaluate(() => document.activeElement.id === 'view');
    }
    assert.ok(found, 'the view is reached by Tab');
    await page.keyboard.press('ArrowUp');
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('Enter');
    const place = await page.evaluate(() => ilpViewer.state.place);
    near(Number.parseFloat(await fact(page, 'Height')), grid.height(place.x, place.y), 0.0006, 'height at the cursor');
    await page.keyboard.press('p');
    await page.keyboard.press('Enter');
    for (let i = 0; i < 4; ++i) await page.keyboard.press('ArrowRight');
    await page.keyboard.press('Enter');
    assert.ok(await page.evaluate(() => ilpViewer.state.profile.b));
    await page.keyboard.press(']');
    assert.ok(await page.evaluate(() => ilpViewer.state.keyframe));
    await page.keyboard.press('?');
    assert.ok(await page.locator('dialog').isVisible());
    await picture(page, 'help');
    await page.keyboard.press('Escape');
    assert.ok(!(await page.locator('dialog').isVisible()));
  },
  'everything that acts has a name': async (page) => {
    const nameless = await page.evaluate(() => [...document.querySelectorAll('button,select,input,canvas,[role=tabpanel]')]
      .filter((n) => !(n.textContent.trim() || n.getAttribute('aria-label') || n.labels?.length)).map((n) => n.outerHTML.slice(0, 80)));
    assert.deepEqual(nameless, []);
  },
};

// Frames a second while the view turns. They depend on the machine, so they are printed and not judged.
async function measure(page) {
  return page.evaluate(() => new Promise((done) => {
    const times = [];
    const turn = (now) => {
      times.push(now);
      ilpViewer.scene.turn(0.02, 0);
      if (times.length < 150) requestAnimationFrame(turn);
      else {
        const gaps = times.slice(31).map((t, i) => t - times[i + 30]).sort((p, q) => p - q);
        done({
          frames_per_second: 1000 / (gaps.reduce((s, g) => s + g, 0) / gaps.length),
          worst_gap_ms: gaps.at(-1), keyframes: ilpViewer.flight.keyframes.length,
          vertices: ilpViewer.scene.terrain.vertices, triangles: ilpViewer.scene.terrain.triangles,
          triangles_drawn: ilpViewer.scene.drawnTriangles, draw_calls: ilpViewer.scene.calls,
        });
      }
    };
    requestAnimationFrame(turn);
  }));
}

let failed = 0;
async function check(name, run) {
  try {
    await run();
    console.log(`ok      ${name}`);
  } catch (error) {
    ++failed;
    console.log(`FAILED  ${name}: ${error.stack}`);
  }
}

await check('no console message, no request', () => browse(flightFile, software, async (page) => {
  for (const [name, test] of Object.entries(tests)) await check(name, () => test(page));
}));
await check('in the light', () => browse(flightFile, software, async (page) => {
  await page.keyboard.press('2');
  await drawn(page);
  await picture(page, 'light');
}, { colorScheme: 'light' }));
for (const width of [420, 700]) {
  await check(`a window of ${width} px: nothing covers anything, the view is as wide as the window`, () => browse(flightFile, software, async (page) => {
    const box = (selector) => page.evaluate((s) => { const { left, right, top, bottom } = document.querySelector(s).getBoundingClientRect(); return { left, right, top, bottom }; }, selector);
    const rows = [];
    for (const selector of ['header', '.tools', '.stage', '.tabs', '.body', '.timeline']) rows.push(await box(selector));
    for (let i = 1; i < rows.length; ++i) assert.ok(rows[i].top >= rows[i - 1].bottom - 1, `row ${i} begins below the one before`);
    assert.ok(rows[2].right - rows[2].left >= width - 1, 'the view has the whole width');
    assert.ok(rows[2].bottom - rows[2].top >= 300, 'and a height that shows something');
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'the page is not wider than the window');
    await picture(page, `narrow-${width}`);
  }, { viewport: { width, height: 800 } }));
}
for (const width of [420, 800, 1400]) {
  await check(`the first view in a window of ${width} px has the whole strip`, () => browse(flightFile, software, async (page) => {
    const cut = () => page.evaluate(() => {
      const { scene, state } = ilpViewer;
      const { clientWidth, clientHeight } = scene.renderer.domElement;
      const { grid } = state.strip;
      const at = scene.track.centres.map((c) => { const p = c.clone().project(scene.camera); return [(0.5 + 0.5 * p.x) * clientWidth, (0.5 - 0.5 * p.y) * clientHeight]; });
      for (let j = 0; j < grid.height; j += 7) {
        for (let i = 0; i < grid.width; i += 7) {
          if (!Number.isNaN(grid.height_of[j * grid.width + i])) at.push(scene.screenOf(grid.x0 + i * grid.cell, grid.y0 - j * grid.cell));
        }
      }
      return [at.filter(([x, y]) => x < 0 || y < 0 || x > clientWidth || y > clientHeight).length, at.length];
    });
    const [outside, all] = await cut();
    assert.ok(all > 100);
    assert.equal(outside, 0, `${outside} of ${all} places are cut off`);
    await page.setViewportSize({ width: Math.round(0.7 * width), height: 900 });
    await until('the view fits again', async () => (await cut())[0] === 0);
    await picture(page, `first-view-${width}`);
  }, { viewport: { width, height: 800 } }));
}
await check('the report in a window of 420 px: the keyframes are lists of titled values, and nothing is wider than the window', async () => {
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: [...software, ...sandbox] });
  try {
    const page = await browser.newPage({ viewport: { width: 420, height: 800 } });
    await page.goto(pathToFileURL(`${build}/flight/report.html`).href);
    const wider = await page.evaluate(() => {
      const table = document.querySelector('.keyframes');
      return [table.scrollWidth - table.clientWidth, document.documentElement.scrollWidth - innerWidth];
    });
    assert.deepEqual(wider, [0, 0]);
    assert.equal(await page.evaluate(() => getComputedStyle(document.querySelector('.keyframes td'), '::before').content), '"keyframe"');
    await picture(page, 'report-narrow');
  } finally {
    await browser.close();
  }
});
await check('without WebGL: a sentence, the plan, and the rest of the page', () => browse(flightFile, noWebgl, async (page) => {
  assert.match(await page.locator('[role=alert]').textContent(), /cannot draw in 3D/);
  assert.ok(await page.locator('.without img').evaluate((i) => i.naturalWidth > 100));
  await page.keyboard.press(']');
  assert.equal(await page.locator('.body h2').textContent(), `Keyframe ${await page.evaluate(() => ilpViewer.flight.keyframes[0].id)}`);
  await picture(page, 'without-webgl');
}));
await check('an empty downlink', () => browse(`${build}/empty/ground/viewer.html`, software, async (page) => {
  assert.match(await page.locator('main').textContent(), /nothing usable/i);
  await picture(page, 'empty');
}));
await check('links lie over the view, each verdict with its own look', () => browse(`${build}/sample.html`, software, async (page) => {
  await page.evaluate(() => { ilpViewer.scene.lookAt(14, 0); ilpViewer.scene.zoom(0.15); });
  assert.deepEqual(await page.evaluate(() => ilpViewer.scene.track.links.count), { linked: 4, contradicts_poses: 1, images_only: 1 });
  const keys = await page.locator('.legend .links .key').allTextContents();
  assert.deepEqual(keys, ['images only (1)', 'linked (4)', 'contradicts the poses of the flight (1)']);
  const looks = await page.evaluate(() => ilpViewer.scene.track.links.group.children.map((l) => [l.material.color.getHex(), l.material.linewidth, l.material.dashed]));
  assert.equal(new Set(looks.map(String)).size, 3);
  const all = await stage(page);
  await picture(page, 'links');
  for (let i = 0; i < 3; ++i) {
    const set = (on) => page.evaluate(([k, visible]) => { ilpViewer.scene.track.links.group.children[k].visible = visible; }, [i, on]);
    await set(false);
    await differs(page, all, `links of verdict ${i} are gone that were drawn`);
    await set(true);
    await shows(page, `links of verdict ${i} are back`, (now) => now.equals(all));
  }
  await page.keyboard.press('l');
  await differs(page, all, 'the switch takes them away');
  assert.equal(await page.locator('.legend .links').count(), 0);
  await page.locator('[data-show=links]').click();
  await shows(page, 'the switch brings them back', (now) => now.equals(all));
  await page.evaluate(() => ilpViewer.state.select(ilpViewer.flight.byId.get(4)));
  assert.deepEqual(await page.locator('.body .links li').allTextContents(), ['Keyframe 12 linked', 'Keyframe 200 linked, in strip 2']);
  await page.locator('.body .links button').last().click();
  assert.equal(await page.evaluate(() => ilpViewer.state.keyframe.id), 200);
  await page.waitForFunction(() => ilpViewer.scene.track?.posed.length === 8 && ilpViewer.scene.terrain);
  assert.equal(await page.evaluate(() => ilpViewer.scene.track.links.group.children.length), 0, 'a link between two strips has no line');
}));
await check('200 keyframes in two strips, a hostile title', () => browse(`${build}/sample.html`, software, async (page) => {
  assert.match(await page.locator('h1').textContent(), /<\/script>/);
  await drawn(page);
  await picture(page, 'sample');
  assert.equal(await page.evaluate(() => ilpViewer.scene.track.cameras.count), 192);
  const figures = await measure(page);
  console.log(`        ${JSON.stringify(figures)}`);
  writeFileSync(`${build}/frames-per-second.json`, JSON.stringify(figures, null, 1));
  assert.equal(figures.keyframes, 200);
  await page.locator('select').selectOption({ index: 1 });
  await page.waitForFunction(() => ilpViewer.scene.track?.posed.length === 8 && ilpViewer.scene.terrain);
  await drawn(page);
  await picture(page, 'second-strip');
}));
process.exitCode = failed ? 1 : 0;
