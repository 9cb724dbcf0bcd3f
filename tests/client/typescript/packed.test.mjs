// The package as a user gets it: packed, and installed from the file into an empty folder without a network. Node, a TypeScript program and
// the program of its README use it there.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { before, describe, test } from 'node:test';
import { promisify } from 'node:util';
import { built, fake, folder, fragments, noServer, realServer, stored, torusFile } from './support.mjs';

const run = promisify(execFile);

describe('the packed package', () => {
  const empty = fs.mkdtempSync(path.join(os.tmpdir(), 'fracture-packed-')), inside = name => path.join(empty, name);
  const write = (name, text) => fs.writeFileSync(inside(name), text);
  process.once('exit', () => fs.rmSync(empty, { recursive: true, force: true }));

  let packed;
  before(async () => {
    const { stdout } = await run('npm', ['pack', '--ignore-scripts', '--json', '--pack-destination', empty], { cwd: folder });
    const [{ filename, files }] = JSON.parse(stdout), names = files.map(({ path: name }) => name);
    for (const name of ['dist/index.js', 'dist/index.d.ts', 'dist/bodies.js', 'dist/bodies.d.ts', 'dist/three/index.js', 'dist/three/index.d.ts', 'README.md', 'LICENSE', 'package.json'])
      assert.ok(names.includes(name), name);
    for (const name of names) assert.match(name, /^(dist\/[\w/]+(\.js|\.d\.ts)|README\.md|LICENSE|package\.json)$/);
    packed = filename;
    write('package.json', '{"name": "game", "private": true, "type": "module"}');
    await run('npm', ['install', '--offline', '--no-audit', '--no-fund', `./${filename}`], { cwd: empty });
    const { dependencies } = JSON.parse(fs.readFileSync(inside('node_modules/fracture-client/package.json')));
    assert.equal(dependencies, undefined, 'there are no dependencies at run time');
    assert.deepEqual(fs.readdirSync(inside('node_modules')).filter(name => !name.startsWith('.')), ['fracture-client']);
  });

  test('git would not add what building and packing leave', async () => {
    const checkout = path.join(empty, 'checkout'), below = 'client/typescript';
    fs.mkdirSync(path.join(checkout, below), { recursive: true });
    for (const name of ['.gitignore', `${below}/.gitignore`]) fs.copyFileSync(path.join(folder, '../..', name), path.join(checkout, name));
    await run('git', ['init', '--quiet', checkout]);
    for (const name of [packed, 'dist/index.js', 'node_modules/three/package.json', 'src/index.ts']) {
      fs.mkdirSync(path.dirname(path.join(checkout, below, name)), { recursive: true });
      fs.writeFileSync(path.join(checkout, below, name), '');
    }
    const { stdout } = await run('git', ['-C', checkout, 'ls-files', '--others', '--exclude-standard', '--', below]);
    assert.deepEqual(stdout.trim().split('\n'), [`${below}/.gitignore`, `${below}/src/index.ts`]);
  });

  test('node uses it', async t => {
    const server = await fake(t, ({ method }) => (method === 'PUT' ? stored() : fragments()));
    write('use.js', `import { Client } from 'fracture-client';
      const mesh = await new Client(process.argv[2]).put(new Uint8Array(3));
      console.log((await mesh.fracture({ sites: 1 })).fragments.map(({ id }) => id).join());`);
    assert.equal((await run(process.execPath, ['use.js', server.url], { cwd: empty })).stdout, '7\n');
    // Works without three.js, which is not installed there.
    write('bodies.js', "import { combine } from 'fracture-client/bodies';\nconsole.log(combine([]).mass);");
    assert.equal((await run(process.execPath, ['bodies.js'], { cwd: empty })).stdout, '0\n');
  });

  test('a TypeScript program is checked against its declarations', async () => {
    // Packages that a game also has; three.js declares its types in a package of its own.
    for (const name of ['three', '@types', '@dimforge', 'undici-types', '@tweenjs', 'fflate', 'meshoptimizer'])
      if (!fs.existsSync(inside(`node_modules/${name}`))) fs.symlinkSync(path.join(folder, 'node_modules', name), inside(`node_modules/${name}`));
    write('game.ts', `import RAPIER from '@dimforge/rapier3d-compat';
      import { Scene } from 'three';
      import { Client, FractureError, type Answer, type Fragment, type Parameters } from 'fracture-client';
      import { materialsOf, place, swap, type World } from 'fracture-client/three';
      export async function broken(file: File, signal: AbortSignal): Promise<number> {
        const client = new Client('http://127.0.0.1:8080', { token: () => 'secret', timeout: 1000 });
        const parameters: Parameters = { material: 'stone', fragments: 40, impacts: [[0, 1, 0]] };
        try {
          const mesh = await client.put(file), answer: Answer = await mesh.fracture(parameters, { signal });
          const world: World = { rapier: RAPIER, world: new RAPIER.World({ x: 0, y: -9.81, z: 0 }), parent: new Scene(), materials: await materialsOf(answer) };
          const intact = place(answer, world, { whole: true }), hit = await answer.hit([0, 1, 0], 0.2, { sites: 5, signal });
          swap(intact, hit, world, { bonded: true });
          const own = world.world.createRigidBody(RAPIER.RigidBodyDesc.dynamic());
          swap({ body: own, object3D: new Scene() }, hit, world);
          const largest: Fragment | undefined = hit.fragments[0];
          const view: Float32Array | undefined = largest?.positions;
          for await (const { percent } of (await mesh.job(parameters)).progress({ signal })) console.log(percent);
          return view?.length ?? 0;
        } catch (error) {
          if (error instanceof FractureError && error.problem === 'mesh-not-closed') console.log(error.parameter, error.detail, error.document?.request_id);
          throw error;
        }
      }
      // @ts-expect-error a parameter is no function
      export const wrong: Parameters = { sites: () => 3 };`);
    write('node.ts', `import { readFile } from 'node:fs/promises';
      import { Client } from 'fracture-client';
      const answer = await (await new Client('http://127.0.0.1:8080').put({ name: 'a.glb', data: await readFile('a.glb') })).fracture();
      console.log(answer.bonds.length);`);
    const tsc = path.join(folder, 'node_modules/typescript/bin/tsc');
    const strict = ['--noEmit', '--strict', '--target', 'es2022', '--exactOptionalPropertyTypes', 'true'];
    const check = (...given) => run(process.execPath, [tsc, ...strict, ...given], { cwd: empty }).catch(({ stdout }) => assert.fail(stdout));
    await Promise.all([
      check('--module', 'nodenext', '--lib', 'es2022', '--types', 'node', '--skipLibCheck', 'false', 'node.ts'),
      check('--module', 'esnext', '--moduleResolution', 'bundler', '--lib', 'es2022,dom,dom.iterable', '--types', 'three', '--skipLibCheck', 'true', 'game.ts'),
    ]);
  });

  test('the program of the README', { skip: noServer }, async t => {
    const readme = fs.readFileSync(inside('node_modules/fracture-client/README.md'), 'utf8'), [, code] = /```js\n([^`]*readFile[^`]*)```/.exec(readme);
    assert.ok(code.trim().split('\n').length <= 10, 'it has ten lines');
    const server = await realServer();
    t.after(server.kill);
    write('fracture.js', code.replace('http://127.0.0.1:8080', server.url).replaceAll('barrel.glb', 'barrel.obj'));
    write('barrel.obj', torusFile.data);
    const { stdout } = await run(process.execPath, ['fracture.js'], { cwd: empty });
    assert.match(stdout, /fragments/);
    const { Glb } = await built();
    assert.ok(new Glb(fs.readFileSync(inside('fragments.glb'))).json.nodes.length > 40);
  });
});
