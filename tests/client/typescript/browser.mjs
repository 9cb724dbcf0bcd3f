// Code that the tests in Debian's Chromium share: pages that are bundled as their READMEs do it, served together with fracture-server, and
// their complaints. Pictures stay in a folder, to look at (FRACTURE_TEST_PICTURES).
import assert from 'node:assert/strict';
import fs from 'node:fs';
import http from 'node:http';
import os from 'node:os';
import path from 'node:path';
import { after, before } from 'node:test';
import { dependency, folder, noServer, realServer, root } from './support.mjs';

const chromium = ['/usr/bin/chromium', '/usr/bin/chromium-browser'].find(name => fs.existsSync(name));
export const noBrowser = noServer || (chromium ? false : 'there is no Chromium (scripts/install-deps pictures)');
export const pictures = process.env.FRACTURE_TEST_PICTURES ?? path.join(os.tmpdir(), 'fracture-web');
const FLAGS = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-dev-shm-usage', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  '--host-resolver-rules=MAP game.test 127.0.0.1'];

/** Builds a page's script as the README does. */
export async function bundle(entry) {
  const { build } = await dependency('esbuild');
  const dist = name => path.join(folder, 'dist', name);
  const { outputFiles: [file] } = await build({
    ...entry, bundle: true, loader: { '.wasm': 'binary' }, format: 'esm', write: false, minify: true, logLevel: 'error',
    nodePaths: [path.join(folder, 'node_modules')],
    alias: { 'fracture-client': dist('index.js'), 'fracture-client/bodies': dist('bodies.js'), 'fracture-client/three': dist('three/index.js') },
  });
  return file.contents;
}

/** Returns the files of a folder in client/examples, as a page with that name. */
export async function example(name) {
  const at = path.join(root, 'client/examples', name);
  return { [`/${name}/`]: ['text/html', fs.readFileSync(path.join(at, 'index.html'))],
    [`/${name}/bundle.js`]: ['text/javascript', await bundle({ entryPoints: [path.join(at, 'game.js')] })] };
}

/**
 * Sets up the tests of a `describe`: pages, a server that they may ask (with these additional flags), and a browser. `files()`: {path:
 * [type, content]}.
 */
export function around(files, flags = []) {
  const here = {};
  let pages, browser;
  before(async () => {
    fs.mkdirSync(pictures, { recursive: true });
    const served = await files();
    pages = http.createServer(({ url }, response) => {
      const [type, text] = served[url.split('?')[0]] ?? ['text/plain', 'nothing'];
      response.writeHead(type === 'text/plain' ? 404 : 200, { 'Content-Type': type }).end(text);
    });
    await new Promise(resolve => pages.listen(0, '127.0.0.1', resolve));
    here.port = pages.address().port;
    here.server = await realServer('--cors-origin', `http://127.0.0.1:${here.port}`, '--cors-origin', `http://game.test:${here.port}`, ...flags);
    browser = await (await dependency('playwright-core')).default.chromium.launch({ executablePath: chromium, args: FLAGS, headless: true });
  });
  after(async () => {
    await browser?.close();
    here.server?.kill();
    pages?.closeAllConnections?.();
    pages?.close();
  });

  /** Opens a page and collects its complaints. */
  here.open = async url => {
    const page = await browser.newPage({ viewport: { width: 640, height: 400 } }), complaints = [];
    page.on('console', message => {
      // Taking a picture of the page causes this stall.
      if (['error', 'warning'].includes(message.type()) && !/GPU stall due to ReadPixels/.test(message.text())) complaints.push(message.text());
    });
    page.on('pageerror', error => complaints.push(String(error)));
    page.on('requestfailed', request => complaints.push(`${request.url()}: ${request.failure()?.errorText}`));
    await page.goto(url);
    return { page, complaints };
  };
  return here;
}

/** Records from now on when an example's page gets its frames. */
export async function watchFrames(page) {
  await page.evaluate(() => {
    globalThis.frames = [];
    const next = now => (globalThis.frames.push(now), requestAnimationFrame(next));
    requestAnimationFrame(next);
  });
  return async count => {
    const now = await page.evaluate(() => globalThis.frames.length);
    await page.waitForFunction(wanted => globalThis.frames.length > wanted, now + count);
  };
}

/** Clicks until the page says that something broke. The object turns, and one of these points is on it. */
export async function hitIt(page, says) {
  for (const [x, y] of [[270, 240], [330, 240], [300, 120], [380, 200], [320, 280]]) {
    await page.mouse.click(x, y);
    if (await says('fragments, in', 1500).then(() => true, () => false)) return;
  }
  assert.fail('no click broke anything');
}

/** Prints how well the swaps kept momentum, and asserts that it changed by less than `within`. */
export function checkSwaps(swaps, within) {
  for (const { before: was, after: is, bodies } of swaps) {
    const [linear, angular] = ['linear', 'angular'].map(kind => Math.hypot(...is[kind].map((value, k) => value - was[kind][k])) / Math.hypot(...was[kind]));
    console.log(`${bodies} bodies for one: linear momentum off by ${linear.toExponential(1)} of ${Math.hypot(...was.linear).toFixed(0)} kg m/s, ` +
      `angular by ${angular.toExponential(1)} of ${Math.hypot(...was.angular).toFixed(0)} kg m²/s`);
    assert.ok(linear < within && angular < within, `${linear} ${angular}`);
  }
}
