// 3D Tiles of a flight in CesiumJS, which knows only their standard: cesium_test.mjs BUILD_DIR. Heights are compared with
// those that GDAL reads from the map.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { extname, join, normalize } from 'node:path';

const build = process.argv[2];
const { chromium } = createRequire(`${build}/node/`)('playwright-core');
const kinds = { '.js': 'text/javascript', '.json': 'application/json', '.glb': 'model/gltf-binary', '.css': 'text/css', '.html': 'text/html', '.wasm': 'application/wasm' };
const roots = { tiles: `${build}/tiles`, cesium: `${build}/node/node_modules/cesium/Build/Cesium` };
const html = `<!doctype html><html><head><script>window.CESIUM_BASE_URL = '/cesium/';</script><script src="/cesium/Cesium.js"></script>
<style>html, body, #view { height: 100%; margin: 0; }</style></head><body><div id="view"></div></body></html>`;

const asked = [];
const server = createServer((request, response) => {
  const path = normalize(decodeURIComponent(new URL(request.url, 'http://x').pathname));
  asked.push(path);
  if (path === '/') return response.writeHead(200, { 'Content-Type': 'text/html' }).end(html);
  const [, root, ...rest] = path.split('/');
  try {
    const content = readFileSync(join(roots[root], ...rest));
    return response.writeHead(200, { 'Content-Type': kinds[extname(path)] ?? 'application/octet-stream' }).end(content);
  } catch {
    return response.writeHead(404).end();
  }
});
await new Promise((done) => server.listen(0, '127.0.0.1', done));

// Places of known height: cells of the map along both of its diagonals, with their longitude and latitude.
const gdal = (program, ...more) => execFileSync(program, more, { encoding: 'utf8' });
const info = JSON.parse(gdal('gdalinfo', '-json', `${build}/flight/height.tif`));
const [columns, rows] = info.size;
const affine = info.geoTransform;
const pixels = [];
for (let i = 1; i < 30; ++i) {
  pixels.push([Math.round((columns * i) / 30), Math.round((rows * i) / 30)], [Math.round((columns * i) / 30), Math.round((rows * (30 - i)) / 30)]);
}
const places = [];
for (const [column, row] of pixels) {
  const height = Number(gdal('gdallocationinfo', '-valonly', `${build}/flight/height.tif`, String(column), String(row)));
  if (!Number.isFinite(height)) continue;
  const [x, y] = [0, 3].map((k) => affine[k] + affine[k + 1] * (column + 0.5) + affine[k + 2] * (row + 0.5));
  const [longitude, latitude] = execFileSync('gdaltransform', ['-s_srs', info.coordinateSystem.wkt, '-t_srs', 'EPSG:4326', '-output_xy'],
    { input: `${x} ${y}\n`, encoding: 'utf8' }).trim().split(' ').map(Number);
  places.push({ longitude, latitude, height });
}
assert.ok(places.length > 15, `${places.length} cells with a height`);

const sandbox = process.getuid() === 0 ? ['--no-sandbox'] : [];
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', ...sandbox] });
try {
  const page = await browser.newPage({ viewport: { width: 800, height: 600 } });
  const complaints = [];
  page.on('console', (m) => { if (m.type() === 'error' && !m.text().startsWith('Failed to load resource')) complaints.push(m.text()); });
  page.on('pageerror', (e) => complaints.push(e.message));
  page.on('response', (r) => { if (r.status() >= 400 && !r.url().endsWith('/favicon.ico')) complaints.push(`${r.status()} ${r.url()}`); });
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  const seen = await page.evaluate(async (places_) => {
    const viewer = new Cesium.Viewer('view', { baseLayer: false, baseLayerPicker: false, geocoder: false, globe: false, skyBox: false, animation: false, timeline: false });
    // The finest tiles are wanted wherever the camera is, and their triangles are kept, because heights are asked for.
    const tileset = await Cesium.Cesium3DTileset.fromUrl('/tiles/tileset.json', { maximumScreenSpaceError: 0.01, enablePick: true });
    const failures = [];
    let loaded = 0;
    tileset.tileFailed.addEventListener((e) => failures.push(`${e.url}: ${e.message}`));
    tileset.tileLoad.addEventListener(() => { ++loaded; });
    viewer.scene.primitives.add(tileset);
    const { center, radius } = tileset.boundingSphere;
    viewer.camera.viewBoundingSphere(tileset.boundingSphere, new Cesium.HeadingPitchRange(0, -1.4, 2.5 * radius));
    const end = performance.now() + 120000;
    await new Promise((done) => {
      const look = () => (loaded > 0 && tileset.tilesLoaded) || performance.now() > end || failures.length > 0 ? done() : setTimeout(look, 200);
      look();
    });
    viewer.render();
    const middle = Cesium.Cartographic.fromCartesian(center);
    const heights = places_.map((p) => tileset.getHeight(Cesium.Cartographic.fromDegrees(p.longitude, p.latitude), viewer.scene) ?? null);
    return {
      failures, loaded, heights, all: tileset.tilesLoaded,
      middle: [Cesium.Math.toDegrees(middle.longitude), Cesium.Math.toDegrees(middle.latitude), middle.height],
    };
  }, places);
  assert.deepEqual(seen.failures, []);
  assert.deepEqual(complaints, [], 'nothing on the console');
  assert.ok(seen.all && seen.loaded > 0, `${seen.loaded} tiles loaded`);
  assert.equal(asked.filter((path) => path.endsWith('.glb')).length >= seen.loaded, true);
  const longitudes = places.map((p) => p.longitude), latitudes = places.map((p) => p.latitude);
  assert.ok(seen.middle[0] > Math.min(...longitudes) && seen.middle[0] < Math.max(...longitudes), `longitude ${seen.middle[0]}`);
  assert.ok(seen.middle[1] > Math.min(...latitudes) && seen.middle[1] < Math.max(...latitudes), `latitude ${seen.middle[1]}`);
  const off = places.map((p, i) => (seen.heights[i] === null ? Infinity : Math.abs(seen.heights[i] - p.height)));
  const found = off.filter(Number.isFinite).sort((a, b) => a - b);
  console.log(`${seen.loaded} tiles, ${found.length} of ${places.length} places have ground, heights differ by ${found.at(-1)?.toFixed(6)} m at most; the map has cells of ${Math.hypot(affine[1], affine[4]).toFixed(3)} m`);
  assert.ok(found.length >= 0.9 * places.length, 'there is ground where the map has it');
  assert.ok(found.at(-1) < 0.001, `a height differs by ${found.at(-1)} m`);
} finally {
  await browser.close();
  server.close();
}
