// A picture of a viewer's page after some keys: screenshot.mjs NODE_FOLDER PAGE.html OUT.png [KEY...]
// NODE_FOLDER holds playwright-core (tests/viewer/run leaves it in build/host/tests/viewer/node).

import { createRequire } from 'node:module';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [folder, file, out, ...keys] = process.argv.slice(2);
const { chromium } = createRequire(`${resolve(folder)}/`)('playwright-core');
const sandbox = process.getuid() === 0 ? ['--no-sandbox'] : [];
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', ...sandbox],
});
const page = await browser.newPage({ viewport: { width: 1366, height: 680 }, colorScheme: 'dark' });
await page.goto(pathToFileURL(resolve(file)).href);
await page.waitForSelector('html[data-ready]');
for (const key of keys) await page.keyboard.press(key);
await page.waitForTimeout(1500);
await page.screenshot({ path: out });
await browser.close();
