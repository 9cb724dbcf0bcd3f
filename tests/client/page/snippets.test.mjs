// The commands and programs that the page offers: whatever files and parameters are called, they arrive as they are.
import assert from 'node:assert/strict';
import { execFile, spawnSync } from 'node:child_process';
import fs from 'node:fs';
import http from 'node:http';
import os from 'node:os';
import path from 'node:path';
import { describe, test } from 'node:test';
import { promisify } from 'node:util';
import { source } from './support.mjs';

const { snippets } = await source('take/snippets');

describe('snippets', () => {
  const file = "-it's;\"$(touch broken)\" `true`,\\ é.obj", sibling = 'a b;c.mtl';
  const parameters = { nodes: "true;'false'; $(touch broken) \"a\\b\"\n", deep: true, impacts: [[-0.5, 1, 0]], 'x"; touch broken #\'': 'y' };
  // The remark about a sample also contains the name of its file.
  const app = (more = {}) => ({ state: { wish: { settings: parameters, hits: [] }, source: { label: file, input: [{ name: file }, { name: sibling }], ...more } }, service: { hasToken: false } });
  const run = promisify(execFile);
  /** Runs `work` in a new folder, in which only `made` may be created. */
  async function inFolder(work) {
    const at = fs.mkdtempSync(path.join(os.tmpdir(), 'fracture-page-'));
    try {
      await work(at, (name, text, mode) => fs.writeFileSync(path.join(at, name), text, { mode }));
      assert.ok(!fs.existsSync(path.join(at, 'broken')), 'a name was run as a command');
    } finally {
      fs.rmSync(at, { recursive: true });
    }
  }
  const texts = (origin = 'http://[::1]:8080', more = {}) => {
    globalThis.location = { origin };
    return snippets(app(more));
  };
  const said = ({ stdout }) => JSON.parse(stdout);

  test('AShellGivesBakeEachWordAsItIs', () => inFolder(async (at, write) => {
    write('fracture-server', `#!${process.execPath}\nconsole.log(JSON.stringify(process.argv.slice(2)));`, 0o755);
    const words = said(await run('/bin/sh', ['-c', texts().bake], { cwd: at, env: { PATH: at } }));
    assert.deepEqual(words, ['bake', `./${file}`, '-o', 'fragments.glb', ...Object.entries(parameters).map(([name, value]) => `--${name}=${name === 'impacts' ? '-0.5,1,0' : value}`)]);
  }));
  test('CurlSendsTheFilesAndTheParametersAsTheyAreAndFailsWhenItIsRefused', { skip: spawnSync('curl', ['--version']).error ? 'there is no curl' : false }, () => inFolder(async (at, write) => {
    let body = '';
    const server = http.createServer((request, response) => {
      request.setEncoding('utf8').on('data', piece => { body += piece; }).on('end', () => response.writeHead(400).end('{"title": "no"}'));
    });
    await new Promise(resolve => server.listen(0, '127.0.0.1', resolve));
    write(file, 'the mesh');
    write(sibling, 'its materials');
    try {
      const line = texts(`http://127.0.0.1:${server.address().port}`).curl;
      await assert.rejects(run('/bin/sh', ['-c', line], { cwd: at, env: { PATH: process.env.PATH, no_proxy: '127.0.0.1' }, timeout: 60_000 }), { code: 22 });
    } finally {
      server.close();
    }
    const parts = body.split(/\r?\n?--[-\w]+(?:\r\n|--\r\n)/).filter(Boolean).map(part => part.split('\r\n\r\n'));
    assert.deepEqual(parts.map(([, content]) => content).slice(0, 2), ['the mesh', 'its materials']);
    assert.match(parts[2][0], /name="params"\r\nContent-Type: application\/json$/);
    assert.deepEqual(JSON.parse(parts[2][1]), parameters);
  }));
  test('PythonReadsTheValuesOfTheParameters', { skip: spawnSync('python3', ['--version']).error ? 'there is no python3' : false }, () => inFolder(async (at, write) => {
    write('fracture_client.py', `import json
class Client:
    def __init__(self, *given): self.given = list(given)
    def __enter__(self): return self
    def __exit__(self, *_): pass
    def put(self, name): self.given.append(name); return self
    def fracture(self, parameters): self.given.append(parameters); return self
    def save(self, name): print(json.dumps([*self.given, name]))
`);
    write('snippet.py', texts(undefined, { fetched: true, label: `a\nopen("broken", "w")\n#.obj`, input: undefined }).python);
    const given = said(await run('python3', ['snippet.py'], { cwd: at }));
    assert.deepEqual(given, ['http://[::1]:8080', `a\nopen("broken", "w")\n#.obj`, parameters, 'fragments.glb']);
  }));
  test('NodeReadsTheValuesOfTheParameters', () => inFolder(async (at, write) => {
    fs.mkdirSync(path.join(at, 'node_modules/fracture-client'), { recursive: true });
    write('node_modules/fracture-client/package.json', '{"type": "module", "exports": "./index.js"}');
    write('node_modules/fracture-client/index.js', `export class Client {
      constructor(url) { this.given = [url]; }
      put(files) { this.given.push(files.map(({ name, data }) => [name, String(data)])); return this; }
      fracture(parameters) { console.log(JSON.stringify([...this.given, parameters])); return { glb: 'glTF' }; }
    }`);
    write(file, 'the mesh');
    write(sibling, 'its materials');
    write('snippet.mjs', texts().javascript);
    assert.deepEqual(said(await run(process.execPath, ['snippet.mjs'], { cwd: at })), ['http://[::1]:8080', [[file, 'the mesh'], [sibling, 'its materials']], parameters]);
    assert.equal(fs.readFileSync(path.join(at, 'fragments.glb'), 'utf8'), 'glTF');
  }));
  test('ALineOfAManifestIsOneLine', () => {
    assert.deepEqual(JSON.parse(texts().manifest), { input: file, output: 'fragments.glb', parameters });
    assert.ok(!texts().manifest.includes('\n'));
  });
});
