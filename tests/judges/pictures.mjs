// Tests whether the outside of the fragments looks as the source does. Headless Chromium opens both with three.js and
// renders them from four sides. The pictures stay in a folder for inspection. Chromium must also decode every texture.
//   usage: node pictures.mjs SAMPLES PICTURES      SAMPLES/sources.json: [{file, source}], written by make_samples
// Exit codes: 0 if all is good, 1 if not, 77 without Chromium, node_modules or meshes.
import { spawn, spawnSync } from 'node:child_process';
import fs from 'node:fs';
import http from 'node:http';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const LIMIT = 0.01;                                           // mean absolute difference of a channel, as a share of its range
const DRAWN = ['FlightHelmet/FlightHelmet.gltf', 'Fox.glb'];  // the other pairs are only loaded and counted
const here = path.dirname(fileURLToPath(import.meta.url)),  // Debian's node 18 has no import.meta.dirname
      [samples, pictures] = process.argv.slice(2);
const skip = why => {
  console.log(`skipped: ${why}`);
  process.exit(77);
};

const three = path.join(here, 'node_modules/three');
if (!fs.existsSync(three)) skip('three.js is not installed (npm ci in tests/judges)');
const chromium = ['chromium', 'chromium-browser', 'google-chrome'].find(name => spawnSync(name, ['--version']).status === 0);
if (!chromium) skip('there is no Chromium (scripts/install-deps pictures)');
const pairs = JSON.parse(fs.readFileSync(path.join(samples, 'sources.json'))).filter(({ source }) => /\.(glb|gltf)$/.test(source))
  .map(({ name, file, source }, k) => ({ name: name.replace(/[^A-Za-z0-9]+/g, '_'), source: `/source/${k}/${path.basename(source)}`,
    ours: `/samples/${file}`, pictures: DRAWN.includes(name), folder: path.dirname(source) }));
if (!pairs.length) skip('there are no meshes (FRACTURE_TEST_MESHES)');
fs.rmSync(pictures, { recursive: true, force: true });
fs.mkdirSync(pictures, { recursive: true });

const TYPES = { html: 'text/html', mjs: 'text/javascript', js: 'text/javascript', json: 'application/json', png: 'image/png', jpg: 'image/jpeg', wasm: 'application/wasm' };
const complaints = [], results = [];
const failed = () => pairs.find(p => !results.some(r => r.name === p.name))?.name;

/** The file that a path of the page names, or undefined. Only the test's folders are served. */
function fileOf(url) {
  const [, root, ...rest] = decodeURIComponent(url).split('/');
  const inside = (folder, parts) => {
    const file = path.resolve(folder, ...parts);
    return file.startsWith(path.resolve(folder) + path.sep) ? file : undefined;
  };
  if (root === 'three') return inside(three, rest);
  if (root === 'samples') return inside(samples, rest);
  if (root === 'source') return pairs[rest[0]] && inside(pairs[rest[0]].folder, rest.slice(1));
  return ['pictures.html', 'pictures_page.mjs'].includes(root) ? path.join(here, root) : undefined;
}

function judge({ name, sides, source, ours }) {
  results.push({ name, sides, source, ours });
  const say = text => complaints.push(`${name}: ${text}`);
  if (source.decoded.length !== source.textures) say(`${source.decoded.length} of the source's ${source.textures} textures can be decoded`);
  if (ours.decoded.length !== ours.textures) say(`${ours.decoded.length} of ${ours.textures} textures can be decoded`);
  for (const what of ['textures', 'images']) if (ours[what] !== source[what]) say(`${ours[what]} ${what}, the source has ${source[what]}`);
  if (ours.decoded.sort().join() !== source.decoded.sort().join()) say(`textures of ${ours.decoded}, in the source ${source.decoded}`);
  if (ours.materials !== source.materials + ours.interiors) say(`${ours.materials} materials, the source has ${source.materials} and ${ours.interiors} are of cuts`);
  if (!(ours.interiors >= 1)) say('no material is listed as one of cuts');
  const missing = source.used.filter(material => !ours.used.includes(material));
  if (missing.length) say(`no fragment wears ${missing}`);
  const { boxes, ...views } = sides, notes = [];
  for (const [side, { picture, object, control, covered, far }] of Object.entries(views)) {
    notes.push(`${side} ${(100 * Math.max(...object)).toFixed(3)} % (${(100 * far).toFixed(2)} % of pixels off by more than a tenth)`);
    if (!(Math.max(...picture) < LIMIT)) say(`${side}: the pictures differ by ${picture.map(x => (100 * x).toFixed(2))} %`);
    if (!(Math.max(...object) < LIMIT)) say(`${side}: the object differs by ${object.map(x => (100 * x).toFixed(2))} %`);
    if (!(Math.max(...control) > 10 * LIMIT)) say(`${side}: the comparison does not see that another side looks different`);
    if (!(covered > 0.02)) say(`${side}: nothing to see`);
  }
  console.log(`${name}: ${ours.materials} materials, ${ours.decoded.length} textures of ${ours.images} images decoded${notes.length ? `; ${notes.join(', ')}` : ''}`);
}

const server = http.createServer(async (request, response) => {
  const chunks = [];
  for await (const chunk of request) chunks.push(chunk);
  const body = Buffer.concat(chunks), { pathname } = new URL(request.url, 'http://page');
  if (request.method === 'POST') {
    response.end();
    if (pathname.startsWith('/picture/')) fs.writeFileSync(path.join(pictures, path.basename(pathname)), body);
    if (pathname === '/result') judge(JSON.parse(body));
    if (pathname === '/failed') finish(`the page failed at ${failed()}: ${body}`);
    if (pathname === '/done') finish();
    return;
  }
  if (pathname === '/pairs.json') return response.end(JSON.stringify(pairs.map(({ folder, ...pair }) => pair)));
  const file = fileOf(pathname);
  if (!file || !fs.existsSync(file)) return response.writeHead(404).end();
  response.writeHead(200, { 'Content-Type': TYPES[path.extname(file).slice(1)] ?? 'application/octet-stream' }).end(fs.readFileSync(file));
});

let browser, log = '';
const profile = fs.mkdtempSync(path.join(os.tmpdir(), 'fracture-pictures-'));
let finished = false;
process.on('exit', () => {  // however this program ends, it ends the browser
  try { process.kill(-browser.pid, 'SIGKILL'); } catch {}
});
function finish(complaint) {
  if (finished) return;
  finished = true;
  if (complaint) complaints.push(complaint);
  if (!complaint && results.length !== pairs.length) complaints.push(`${results.length} of ${pairs.length} pairs were judged`);
  process.kill(-browser.pid, 'SIGKILL');  // and its child processes
  browser.once('exit', async () => {
    for (let tries = 0; tries < 20 && fs.existsSync(profile); ++tries) {  // they may still write for a moment
      await new Promise(resolve => setTimeout(resolve, 100));
      try { fs.rmSync(profile, { recursive: true, force: true }); } catch {}
    }
    fs.writeFileSync(path.join(pictures, 'results.json'), JSON.stringify(results, null, 1));
    for (const complaint of complaints) console.log(`BAD  ${complaint}`);
    process.exit(complaints.length ? 1 : 0);
  });
}

server.listen(0, '127.0.0.1', () => {
  browser = spawn(chromium, ['--headless=new', '--no-sandbox', '--disable-dev-shm-usage', '--use-gl=angle', '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader', '--disable-extensions', '--disable-background-networking', '--disable-component-update', '--no-first-run',
    `--user-data-dir=${profile}`, `http://127.0.0.1:${server.address().port}/pictures.html`], { stdio: ['ignore', 'ignore', 'pipe'], detached: true });
  browser.stderr.on('data', text => (log += text));
  browser.once('exit', () => finished || (complaints.push(`Chromium ended: ${log.slice(-2000)}`), console.log(complaints.join('\n')), process.exit(1)));
  setTimeout(() => finish(`nothing more came from the page after 9 minutes, at ${failed()}: ${log.slice(-2000)}`), 540e3);
});
