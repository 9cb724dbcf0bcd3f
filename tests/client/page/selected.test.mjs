// A selected fragment is named, framed, hidden, broken again and saved alone.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, clean, eventually, onMesh, painted, pictures, shown, skip, source, state } from './support.mjs';

describe('a selected fragment', { skip, timeout: 300_000 }, () => {
  let bench, Glb;
  before(async () => {
    ({ Glb } = await source('../../typescript/src/glb'));
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  /** Opens the cube and selects a fragment with the Select tool: [opened, id]. */
  async function selectedOne() {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":12}', width: 1024, height: 700 }), { page } = opened;
    await page.getByRole('button', { name: 'Select', exact: true }).click();
    await page.mouse.click(...await onMesh(page));
    await page.getByRole('region', { name: 'Selection' }).waitFor();
    const [id] = await state(page, s => [...s.look.chosen]);
    return [opened, id];
  }
  const download = async (page, act) => {
    const [file] = await Promise.all([page.waitForEvent('download'), act()]);
    return { name: file.suggestedFilename(), bytes: new Uint8Array(fs.readFileSync(await file.path())) };
  };
  /** The volume (m³) of a node's mesh where the node is, by the divergence theorem, and the number of edges without an opposite one. */
  function measured(glb, node) {
    let volume = 0;
    const open = new Set();
    for (const { attributes, indices } of glb.json.meshes[node.mesh].primitives) {
      const at = glb.accessor(attributes.POSITION), index = glb.accessor(indices), corner = v => [0, 1, 2].map(k => at[3 * v + k] + node.translation[k]), key = v => at.subarray(3 * v, 3 * v + 3).join();
      for (let t = 0; t < index.length; t += 3) {
        const [a, b, c] = [0, 1, 2].map(k => corner(index[t + k]));
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
        for (let k = 0; k < 3; ++k) {
          const [from, to] = [key(index[t + k]), key(index[t + (k + 1) % 3])];
          if (!open.delete(`${to} ${from}`)) open.add(`${from} ${to}`);
        }
      }
    }
    return { volume, open: open.size };
  }

  test('is named, in the list and in the file', async () => {
    const [opened, id] = await selectedOne(), { page } = opened;
    const before = await download(page, () => page.keyboard.press('d'));
    await page.locator('#piece-name').fill('Corner stone');
    await page.locator('#piece-name').press('Tab');
    await page.locator('tr.chosen').getByText('Corner stone').waitFor();
    const after = await download(page, () => page.evaluate(() => document.body.dispatchEvent(new KeyboardEvent('keydown', { key: 'd', bubbles: true }))));
    const [old, now] = [new Glb(before.bytes), new Glb(after.bytes)], node = now.json.nodes.find(each => each.extras?.fracture?.id === id);
    assert.equal(node.name, 'Corner stone');
    assert.ok(Buffer.from(old.binary).equals(Buffer.from(now.binary)));
    node.name = old.json.nodes.find(each => each.extras?.fracture?.id === id).name;
    assert.deepEqual(now.json, old.json, 'nothing but the name has changed');
    await clean(opened);
    await opened.close();
  });

  test('is framed, hidden and shown', async () => {
    const [opened, id] = await selectedOne(), { page } = opened, region = page.getByRole('region', { name: 'Selection' });
    await region.getByRole('button', { name: 'Frame' }).click();
    const [near, size] = await page.evaluate(which => {
      const { stage, view } = globalThis.fracture, k = view.batch.indexOf.get(which), { center } = view.batch.pieces[k].bounds;
      return [center.clone().add(stage.camera.position.clone().set(...view.batch.poses.get(k).at)).distanceTo(stage.controls.target), view.size];
    }, id);
    assert.ok(near < 0.01 * size, `${near}: the camera turns about the fragment`);
    await page.screenshot({ path: path.join(pictures, 'selected.png') });
    const hidden = () => page.evaluate(which => {
      const { view } = globalThis.fracture, { left, top, width, height } = document.querySelector('canvas').getBoundingClientRect();
      return [view.batch.poses.visible(view.batch.indexOf.get(which)), view.pick(left + width / 2, top + height / 2)?.id === which];
    }, id);
    await region.getByRole('button', { name: 'Hide' }).click();
    await painted(page);
    assert.deepEqual(await hidden(), [false, false], 'neither seen nor picked');
    await region.getByRole('button', { name: 'Show 1 hidden' }).click();
    await painted(page);
    assert.equal((await hidden())[0], true);
    await clean(opened);
    await opened.close();
  });

  test('is broken again, and the others come back', async () => {
    const [opened, id] = await selectedOne(), { page } = opened;
    const volume = await state(page, s => s.shown.answer.fragment([...s.look.chosen][0]).volume);
    await page.getByRole('button', { name: 'Break again' }).click();
    await shown(page);
    const pieces = await state(page, s => s.shown.answer.fragments.map(each => each.volume));
    assert.ok(pieces.length > 1);
    assert.ok(Math.abs(pieces.reduce((a, b) => a + b) / volume - 1) < 1e-6);
    await page.screenshot({ path: path.join(pictures, 'again.png') });
    // A hit would be about the whole mesh, which is not shown.
    await page.getByRole('button', { name: 'Hit', exact: true }).click();
    await page.mouse.click(...await onMesh(page));
    await page.getByRole('alert').getByText(/Go back to all fragments/).waitFor();
    await page.evaluate(() => globalThis.fracture.dismiss());
    await page.getByRole('button', { name: 'Back to all fragments' }).click();
    await shown(page);
    assert.deepEqual(await state(page, s => [s.shown.answer.fragments.length, s.shown.wish.settings.fragment]), [12, undefined]);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(count => globalThis.fracture.state.shown.answer.fragments.length === count, pieces.length);
    // Another seed has other fragments, so this one no longer exists.
    await page.evaluate(() => globalThis.fracture.breaking.reseed());
    await page.waitForFunction(() => globalThis.fracture.state.wish.settings.fragment === undefined);
    await shown(page);
    assert.equal(await state(page, s => s.shown.answer.fragments.length), 12);
    assert.equal(await page.getByRole('alert').count(), 0);
    assert.ok(id > 0);
    await opened.close();
  });

  test('is saved alone: closed, in its place, with its materials and hulls', async () => {
    const [opened, id] = await selectedOne(), { page } = opened;
    const expected = await state(page, s => {
      const fragment = s.shown.answer.fragment([...s.look.chosen][0]);
      return { volume: fragment.volume, translation: fragment.translation, hulls: fragment.hulls.length, name: fragment.name };
    });
    const { name, bytes } = await download(page, () => page.getByRole('button', { name: 'Save selected' }).click()), glb = new Glb(bytes);
    assert.equal(name, `cube_fragments_${expected.name}.glb`);
    const nodes = glb.json.nodes.filter(each => each.extras?.fracture?.id !== undefined), { volume, open } = measured(glb, nodes[0]);
    assert.deepEqual(nodes.map(each => [each.extras.fracture.id, each.translation]), [[id, expected.translation]]);
    assert.equal(open, 0);
    assert.ok(Math.abs(volume / expected.volume - 1) < 1e-5);
    const shapes = [nodes[0], ...(nodes[0].children ?? []).map(k => glb.json.nodes[k])].filter(each => each.extensions?.KHR_physics_rigid_bodies?.collider);
    assert.equal(shapes.length, expected.hulls);
    for (const { extensions: { KHR_physics_rigid_bodies: { collider } } } of shapes) assert.ok(glb.json.meshes[collider.geometry.mesh]);
    assert.ok(bytes.length < await state(page, s => s.shown.answer.glb.length) / 2, 'without the others');
    assert.equal(glb.json.buffers[0].byteLength, glb.binary.length);
    await eventually(() => page.locator('[role=alert]').count(), count => assert.equal(count, 0));
    await clean(opened);
    await opened.close();
  });
});
