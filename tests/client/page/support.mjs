// Code that the tests of the page share: a fracture-server (FRACTURE_TEST_SERVER) behind the site, Chromium with WebGL in software, and a
// page whose complaints are kept.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { Site } from './site.mjs';

export const here = path.dirname(fileURLToPath(import.meta.url)), folder = path.resolve(here, '../../../client/page'), dist = path.join(folder, 'dist');
export const require = createRequire(path.join(folder, 'package.json'));
export const full = process.env.FRACTURE_TEST_FULL === '1';
/** Milliseconds by which each frame of a page is delayed, so that a test that reads before the page has drawn always fails. */
const late = Number(process.env.FRACTURE_TEST_LATE_FRAMES ?? 0);
export const pictures = process.env.FRACTURE_TEST_PICTURES ?? path.join(os.tmpdir(), 'fracture-page');
export const program = process.env.FRACTURE_TEST_SERVER;
const chromium = ['/usr/bin/chromium', '/usr/bin/chromium-browser'].find(name => fs.existsSync(name));
export const skip = !program ? 'FRACTURE_TEST_SERVER names no fracture-server' : !chromium ? 'there is no Chromium (scripts/install-deps pictures)' : false;
/** Folders of real meshes; the first contains those of the tests. */
const meshes = (process.env.FRACTURE_TEST_MESHES ?? '').split(':').filter(Boolean);
export const meshOf = name => meshes.map(at => path.join(at, name)).find(at => fs.existsSync(at));

/** Loads modules of the page's sources into node. */
export async function source(...names) {
  const { build } = require('esbuild'), out = fs.mkdtempSync(path.join(os.tmpdir(), 'fracture-page-'));
  const at = (...parts) => path.join(folder, ...parts);
  await build({
    stdin: { contents: names.map(name => `export * from './src/${name}';`).join('\n'), resolveDir: folder }, bundle: true, format: 'esm', platform: 'node',
    outfile: path.join(out, 'out.mjs'), logLevel: 'error', tsconfig: at('tsconfig.json'),
    alias: { 'fracture-client': at('../typescript/src/index.ts'), three: at('node_modules/three/build/three.module.js') },
  });
  return import(pathToFileURL(path.join(out, 'out.mjs')));
}

const FLAGS = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-dev-shm-usage', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  '--enable-precise-memory-info', '--js-flags=--expose-gc'];

/** Starts fracture-server, which runs until this program ends or kill() is called: {url, port, kill}. */
export async function realServer({ port = 0, flags = [] } = {}) {
  const server = spawn(program, ['serve', '--port', String(port), '--admin-port', '0', '--threads', '2', '--drain-delay', '0', '--grace', '1',
    '--log-format', 'json', ...flags], { stdio: ['ignore', 'ignore', 'pipe'] });
  const gone = new Promise(resolve => server.once('exit', resolve)), kill = () => {
    server.ref();
    server.kill('SIGKILL');
    return gone;
  };
  process.once('exit', () => server.kill('SIGKILL'));
  let log = '';
  const found = await new Promise((resolve, reject) => {
    server.once('error', reject).once('exit', code => reject(new Error(`fracture-server ended with ${code}: ${log}`)));
    server.stderr.on('data', text => {
      log += text;
      const said = /serving on http:\/\/127\.0\.0\.1:(\d+)/.exec(log);
      if (said) resolve(said);
    });
  });
  server.unref();
  server.stderr.unref();
  return { url: `http://127.0.0.1:${found[1]}`, port: Number(found[1]), kill };
}

/** The browser's log entries about an answer that is an error. The page shows the error itself. */
const SAID = /Failed to load resource: the server responded with a status of/;
/** Messages about reading a picture of the page, and about the start of the physics engine. */
const HARMLESS = /GPU stall due to ReadPixels|using deprecated parameters for the initialization function/;

export class Bench {
  static async start({ server, flags = [] } = {}) {
    const bench = new Bench();
    fs.mkdirSync(pictures, { recursive: true });
    bench.server = server ?? await realServer();
    try {
      bench.site = await new Site(dist, bench.server.url).listen();
      bench.browser = await require('playwright-core').chromium.launch({ executablePath: chromium, args: [...FLAGS, ...flags], headless: true });
      return bench;
    } catch (error) {
      await bench.stop();
      throw error;
    }
  }

  async stop() {
    await this.browser?.close();
    this.site?.close();
    await this.server?.kill();
  }

  /**
   * Opens a page in a separate context, with an empty cache. `complaints`: console errors and warnings, violations of the policy,
   * exceptions; `foreign`: requests to other origins.
   */
  async open({ hash = '', path: at = '/', width = 860, height = 560, wait = true, ...more } = {}) {
    const context = await this.browser.newContext({ viewport: { width, height }, reducedMotion: 'reduce', ...more }), page = await context.newPage();
    const complaints = [], foreign = [];
    page.setDefaultTimeout(20_000);
    page.on('console', message => {
      if (['error', 'warning'].includes(message.type()) && !HARMLESS.test(message.text())) complaints.push(message.text());
    });
    page.on('pageerror', error => complaints.push(String(error.stack)));
    page.on('request', request => {
      if (!request.url().startsWith(this.site.url) && !/^(data|blob):/.test(request.url())) foreign.push(request.url());
    });
    await page.addInitScript(() => {
      globalThis.violations = [];
      document.addEventListener('securitypolicyviolation', event => globalThis.violations.push(`${event.violatedDirective} ${event.blockedURI}`));
    });
    if (late > 0)
      await page.addInitScript(time => {
        const frame = globalThis.requestAnimationFrame.bind(globalThis);
        globalThis.requestAnimationFrame = call => setTimeout(() => frame(call), time);
        globalThis.cancelAnimationFrame = clearTimeout;
      }, late);
    const press = page.keyboard.press.bind(page.keyboard);
    page.keyboard.press = async (...given) => {
      await press(...given);
      await painted(page);
    };
    await page.goto(`${this.site.url}${at}${hash}`);
    if (wait) await shown(page);
    return { page, complaints, foreign, close: () => context.close() };
  }
}

/** Complaints, without the lines that a browser logs about errors from the server. */
export const serious = complaints => complaints.filter(text => !SAID.test(text));

/** Asserts that the policy refused nothing, nothing failed, and no other origin was asked. */
export async function clean({ page, complaints, foreign }) {
  assert.deepEqual(await page.evaluate(() => globalThis.violations), []);
  assert.deepEqual(complaints, []);
  assert.deepEqual(foreign, []);
}

/** Waits until the page has drawn its present state, which it does with its next frame. */
export const painted = page => page.evaluate(() => new Promise(resolve => requestAnimationFrame(() => requestAnimationFrame(resolve))));

/** Waits until the picture and the panels show the answer to the last wish. */
export async function shown(page, timeout = 20_000) {
  await page.waitForFunction(() => {
    const { state } = globalThis.fracture ?? {};
    return state && state.inFlight === 0 && !state.bringing && !state.job && state.shown?.toPicture > 0 && state.shown.wish === state.wish;
  }, undefined, { timeout });
  await painted(page);
}

/** Waits for a problem on the page: {name, title, detail}. */
export async function problem(page, timeout = 20_000) {
  await page.waitForFunction(() => globalThis.fracture?.state.problem, undefined, { timeout });
  await painted(page);
  return page.evaluate(() => {
    const { problem: name, title, detail } = globalThis.fracture.state.problem;
    return { name, title, detail };
  });
}

/** Reads and judges until the judgement passes. Throws the last failure at the end. */
export async function eventually(read, judge, timeout = 20_000) {
  for (const end = Date.now() + timeout; ; await new Promise(resolve => setTimeout(resolve, 50)))  // pause: between two readings
    try {
      return judge(await read());
    } catch (error) {
      if (Date.now() > end) throw error;
    }
}
export const state = (page, read) => page.evaluate(`(${read})(globalThis.fracture.state)`);

/** Returns a point at which a click hits the mesh; the page is asked what is under the pointer. */
export const onMesh = page => page.evaluate(() => {
  const { left, top, width, height } = document.querySelector('canvas').getBoundingClientRect();
  for (let ring = 0; ring < 0.4; ring += 0.04)
    for (let k = 0; k < 8; ++k) {
      const x = left + width * (0.5 + ring * Math.cos(k * Math.PI / 4)), y = top + height * (0.5 + ring * Math.sin(k * Math.PI / 4));
      const picked = globalThis.fracture.view.pick(x, y);
      if (picked && document.elementFromPoint(x, y) === document.querySelector('canvas')) return [x, y];
    }
  return undefined;
});

/** Drops files as a person does. */
export async function drop(page, files) {
  const data = await page.evaluateHandle(given => {
    const transfer = new DataTransfer();
    for (const { name, base64 } of given) transfer.items.add(new File([Uint8Array.from(atob(base64), letter => letter.charCodeAt(0))], name));
    return transfer;
  }, files.map(({ name, data }) => ({ name, base64: Buffer.from(data).toString('base64') })));
  await page.dispatchEvent('#viewport', 'drop', { dataTransfer: data });
}
