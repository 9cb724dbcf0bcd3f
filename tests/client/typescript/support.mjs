// Code that the tests of the package share: the package and its development dependencies, a server with raw sockets that answers as a test
// says (including badly), and the real server.
import { spawn } from 'node:child_process';
import { createHash } from 'node:crypto';
import fs from 'node:fs';
import net from 'node:net';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

export const here = path.dirname(fileURLToPath(import.meta.url)), root = path.resolve(here, '../../..');
export const folder = path.join(root, 'client/typescript');
/** Loads a development dependency of the package. These are next to its package.json, where a test does not look by itself. */
export function dependency(name) {
  const at = path.join(folder, 'node_modules', name), { exports, module, main } = JSON.parse(fs.readFileSync(path.join(at, 'package.json'), 'utf8'));
  const own = exports?.['.'] ?? exports, entry = own?.import ?? own?.node ?? own?.default ?? module ?? main ?? 'index.js';
  return import(pathToFileURL(path.join(at, typeof entry === 'string' ? entry : entry.default)));
}
export const built = (name = 'index.js') => import(pathToFileURL(path.join(folder, 'dist', name)));

export const { Client, FractureError, Glb, packGlb } = await built();
export const program = process.env.FRACTURE_TEST_SERVER;
export const noServer = program ? false : 'FRACTURE_TEST_SERVER names no fracture-server';

// -- answers, as bytes on the wire

const STATUS = { 200: 'OK', 404: 'Not Found', 503: 'Service Unavailable' };
export const digestOf = bytes => createHash('sha256').update(bytes).digest('base64');
export const idOf = bytes => `sha256:${createHash('sha256').update(bytes).digest('hex')}`;

/** `headers`: lines, each with its line end. */
export function answer(status, body, headers = '') {
  const bytes = Buffer.from(body);
  const head = `HTTP/1.1 ${status} ${STATUS[status] ?? 'Reason'}\r\n${headers}Content-Length: ${bytes.length}\r\n\r\n`;
  return { bytes: Buffer.concat([Buffer.from(head), bytes]) };
}
export const problem = (status, slug, headers = '', more = {}) =>
  answer(status, JSON.stringify({ type: `/problems/${slug}`, title: 'Title', status, detail: 'Because.', ...more }),
    `Content-Type: application/problem+json\r\n${headers}`);
export const stored = (id = 'sha256:0') => answer(201, JSON.stringify({ id, format: 'glb', bytes: 4, files: 0, ttl_s: 60, report: {} }));

/** The smallest answer of the service: one fragment without geometry. */
export const glb = packGlb({
  asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }],
  nodes: [
    { children: [1], extras: { fracture: {
      mesh: 'sha256:0', parameters: { sites: 1 }, report: { warnings: ['to do'], notes: ['done'], dropped: [{ what: 'light', name: 'Lamp', reason: 'why' }] }, certificate: { fragments: 1 }, interior_materials: [],
      bonds: { a: [], b: [], area: [], centroid: [], normal: [], strength: [] },
    } } },
    { name: 'one', extras: { fracture: { id: 7, sites: [0], part: 0 } } },
  ],
}, new Uint8Array());
export const fragments = (headers = '') => answer(200, glb, `Repr-Digest: sha-256=:${digestOf(glb)}:\r\nContent-Location: /fractures/sha256:1\r\n${headers}`);

/**
 * `handle(request)` returns the reply: {bytes, close: then hang up, silent: nothing}. Requests are {method, target, head, body, number,
 * connection}; it may be asynchronous.
 */
export class FakeServer {
  requests = [];
  connections = 0;
  sockets = new Set();

  constructor(handle) {
    this.handle = handle;
    this.server = net.createServer(socket => this.serve(socket, this.connections++));
  }

  async listen(port = 0) {
    await new Promise((resolve, reject) => this.server.once('error', reject).listen(port, '127.0.0.1', resolve));
    return this;
  }
  get port() {
    return this.server.address().port;
  }
  get url() {
    return `http://127.0.0.1:${this.port}`;
  }
  async close() {
    for (const socket of this.sockets) socket.destroy();
    await new Promise(resolve => this.server.close(resolve));
  }

  serve(socket, connection) {
    let received = Buffer.alloc(0), turn = Promise.resolve();
    this.sockets.add(socket);
    socket.setNoDelay(true).on('error', () => {}).on('close', () => this.sockets.delete(socket));
    socket.on('data', data => {
      received = Buffer.concat([received, data]);
      for (;;) {
        const end = received.indexOf('\r\n\r\n');
        if (end < 0) return;
        const head = received.subarray(0, end + 4).toString('latin1'), [method, target] = head.split(' ');
        const length = Number(/content-length: (\d+)/i.exec(head)?.[1] ?? 0);
        if (received.length < end + 4 + length) return;
        const request = { method, target, head, body: received.subarray(end + 4, end + 4 + length), number: this.requests.length, connection };
        received = received.subarray(end + 4 + length);
        this.requests.push(request);
        turn = turn.then(() => this.reply(socket, request));
      }
    });
  }

  async reply(socket, request) {
    const { bytes, close, silent } = await this.handle(request);
    if (silent || socket.destroyed) return;
    socket.write(bytes);
    if (close) socket.end();
  }
}

/** Starts a fake server for the duration of a test. */
export async function fake(test, handle, port = 0) {
  const server = await new FakeServer(handle).listen(port);
  test.after(() => server.close());
  return server;
}

/** Starts fracture-server on free ports, until this program ends or kill() is called: {url, admin, pid, kill}. */
export async function realServer(...flags) {
  const server = spawn(program, ['serve', '--port', '0', '--admin-port', '0', '--threads', '2', '--drain-delay', '0', '--grace', '1',
    '--log-format', 'json', ...flags], { stdio: ['ignore', 'ignore', 'pipe'] });
  const kill = () => server.kill('SIGKILL');
  process.once('exit', kill);
  let log = '';
  const ports = await new Promise((resolve, reject) => {
    server.once('error', reject).once('exit', code => reject(new Error(`fracture-server ended with ${code}: ${log}`)));
    server.stderr.on('data', text => {
      log += text;
      const found = /serving on http:\/\/127\.0\.0\.1:(\d+) \(admin port (\d+)\)/.exec(log);
      if (found) resolve(found);
    });
  });
  // The server does not keep this program alive.
  server.unref();
  server.stderr.unref();
  return { url: `http://127.0.0.1:${ports[1]}`, admin: `http://127.0.0.1:${ports[2]}`, pid: server.pid, kill };
}

/**
 * Starts HAProxy with the repository's configuration in front of one server, with other addresses and fewer connections, until the end of
 * the test: {url}. Returns null if it is not installed.
 */
export async function haproxy(test, server) {
  const program = ['/usr/sbin/haproxy', '/usr/local/sbin/haproxy', '/usr/bin/haproxy'].find(name => fs.existsSync(name));
  if (!program) return null;
  const [port, statistics] = await Promise.all([freePort(), freePort()]), address = new URL(server.url).host, admin = new URL(server.admin).port;
  let text = read('docker/haproxy/haproxy.cfg');
  for (const [old, other] of [[/bind :8080/, `bind 127.0.0.1:${port}`], [/bind :8404/, `bind 127.0.0.1:${statistics}`], [/maxconn 4000/, 'maxconn 200'],
    [/^    server fracture[23] .*\n/gm, ''], [/fracture1:8080 track/, `${address} track`], [/fracture1:8080\n/, `${address} port ${admin}\n`]]) {
    if (!new RegExp(old.source, 'm').test(text)) throw new Error(`haproxy.cfg: where is ${old}?`);
    text = text.replace(old, other);
  }
  const at = fs.mkdtempSync(path.join(os.tmpdir(), 'fracture-haproxy-')), file = path.join(at, 'haproxy.cfg');
  fs.writeFileSync(file, text);
  const process = spawn(program, ['-db', '-f', file], { stdio: 'ignore' });
  test.after(() => {
    process.kill('SIGKILL');
    fs.rmSync(at, { recursive: true });
  });
  const url = `http://127.0.0.1:${port}`;
  await eventually('HAProxy to pass on what it is asked', () => fetch(`${url}/version`).then(({ ok }) => ok, () => false));
  return { url };
}
async function freePort() {
  const server = net.createServer();
  await new Promise((resolve, reject) => server.once('error', reject).listen(0, '127.0.0.1', resolve));
  const { port } = server.address();
  await new Promise(resolve => server.close(resolve));
  return port;
}

/** Waits until the condition holds, at most a minute, which is hundreds of times what it takes. */
export async function eventually(what, holds) {
  for (const end = Date.now() + 60_000; !await holds(); await new Promise(resolve => setTimeout(resolve, 5)))
    if (Date.now() > end) throw new Error(`not within a minute: ${what}`);
}

/** Returns the reason for which a promise is rejected. */
export async function refusal(promise) {
  try {
    await promise;
  } catch (error) {
    if (!(error instanceof FractureError)) throw error;
    return error;
  }
  throw new Error('it was not refused');
}

// -- meshes, made here

/** A closed torus as OBJ, in metres. */
export function torus({ radius = 1, tube = 0.4, around = 24, across = 12, material = '' } = {}) {
  const lines = material ? [`mtllib ${material}`, 'usemtl skin'] : [];
  for (let i = 0; i < around; ++i)
    for (let k = 0; k < across; ++k) {
      const [a, b] = [2 * Math.PI * i / around, 2 * Math.PI * k / across], r = radius + tube * Math.cos(b);
      lines.push(`v ${r * Math.cos(a)} ${tube * Math.sin(b)} ${r * Math.sin(a)}`, `vt ${i / around} ${k / across}`);
    }
  const at = (i, k) => 1 + (i % around) * across + k % across, corner = (i, k) => `${at(i, k)}/${at(i, k)}`;
  for (let i = 0; i < around; ++i)
    for (let k = 0; k < across; ++k) lines.push(`f ${corner(i, k)} ${corner(i, k + 1)} ${corner(i + 1, k + 1)} ${corner(i + 1, k)}`);
  return `${lines.join('\n')}\n`;
}
/** A house that contains a wall, which contains a beam that touches it; and a lamp outside of the house. All are boxes. */
export function house() {
  const corners = Array.from({ length: 8 }, (_, k) => [k & 1, k >> 1 & 1, k >> 2]), sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  const indices = sides.flatMap(([a, b, c, d]) => [a, b, c, a, c, d]);  // counter-clockwise from outside
  const binary = new Uint8Array([new Float32Array(corners.flat()), new Uint16Array(indices)].flatMap(array => [...new Uint8Array(array.buffer)]));
  return Buffer.from(packGlb({
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0, 3] }],
    nodes: [{ name: 'House', children: [1] }, { name: 'Wall', mesh: 0, children: [2], scale: [3, 2, 1] }, { name: 'Beam', mesh: 0, translation: [1, 0.25, 0] },
      { name: 'Lamp', mesh: 0, translation: [0, 5, 0] }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 8, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 1] }, { bufferView: 1, componentType: 5123, count: 36, type: 'SCALAR' }],
    bufferViews: [{ buffer: 0, byteOffset: 0, byteLength: 96 }, { buffer: 0, byteOffset: 96, byteLength: 72 }], buffers: [{ byteLength: binary.length }],
  }, binary));
}
export const torusFile = { name: 'torus.obj', data: Buffer.from(torus()) };
/** A single pixel. */
export const png = Buffer.from('iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==', 'base64');

export const read = name => fs.readFileSync(path.join(root, name), 'utf8');
