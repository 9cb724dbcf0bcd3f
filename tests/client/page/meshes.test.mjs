// Real meshes dropped on the page (FRACTURE_TEST_MESHES): files, files with the files that they refer to, folders.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, drop, full, meshOf, pictures, serious, shown, skip, state } from './support.mjs';

const SHORT = ['kk_barrel_large.glb', 'suzanne.obj', 'FlightHelmet'];
const ALL = [...SHORT, 'Fox.glb', 'cube_uv.ply', 'featuretype.STL', 'kk_bottle_A_brown.glb', 'kk_chest.glb', 'kk_wall_cracked.glb', 'moon_ext_manifold.glb',
  'mountain_open.obj', 'penguin.obj', 'plane_holes.obj', 'round.stl', 'spot.obj', 'hammer.obj'];

describe('meshes', { skip: skip || (meshOf('suzanne.obj') ? false : 'FRACTURE_TEST_MESHES names no folder with suzanne.obj'), timeout: 300_000 }, () => {
  let bench, opened;
  before(async () => {
    bench = await Bench.start();
    opened = await bench.open();
  });
  after(() => bench?.stop());

  for (const name of full ? ALL : SHORT)
    test(name, async () => {
      const { page, complaints } = opened, at = meshOf(name), folder = fs.statSync(at).isDirectory();
      const names = folder ? fs.readdirSync(at, { recursive: true }).filter(each => fs.statSync(path.join(at, each)).isFile()) : [path.basename(at)];
      await drop(page, names.map(each => ({ name: path.basename(each), data: fs.readFileSync(path.join(folder ? at : path.dirname(at), each)) })));
      const label = names.find(each => /\.gltf$/.test(each)) ?? name;
      await page.waitForFunction(wanted => globalThis.fracture.state.source?.label === wanted, path.basename(label), { timeout: 40_000 });
      await shown(page, 40_000);
      const [fragments, edges, textures] = await state(page, s => [s.shown.answer.fragments.length, s.shown.answer.certificate.open_edges, s.shown.answer.document.json.textures?.length ?? 0]);
      console.log(`${name}: ${fragments} fragments, ${textures} textures`);
      assert.equal(edges, 0);
      assert.ok(fragments > 1);
      await page.keyboard.press('1');
      await page.waitForSelector('#panel dl');
      await page.screenshot({ path: path.join(pictures, `mesh-${name}.png`) });
      assert.deepEqual(serious(complaints), []);
      assert.deepEqual(await page.evaluate(() => globalThis.violations), []);
      assert.deepEqual(opened.foreign, []);
    });
});
