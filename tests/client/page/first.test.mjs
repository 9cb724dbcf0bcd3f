// Things that a person finds without searching: a button that opens a mesh, the samples, the controls of hits, and parameters under the headings of
// the documents. Clicks reach the surface, also between exploded fragments.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, clean, drop, eventually, here, onMesh, painted, pictures, shown, skip, state } from './support.mjs';

const BOX = 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n' +
  ['4 3 2 1', '5 6 7 8', '1 2 6 5', '2 3 7 6', '3 4 8 7', '4 1 5 8'].map(face => `f ${face}\n`).join('');

describe('at first sight', { skip, timeout: 300_000 }, () => {
  let bench;
  before(async () => {
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  for (const [width, height, touch] of [[1280, 800, {}], [360, 740, { hasTouch: true, isMobile: true }]])
    test(`a mesh can be opened, and every sample is there, ${width} x ${height}`, async () => {
      const opened = await bench.open({ width, height, ...touch }), { page } = opened;
      const inside = async locator => {
        const { x, y, width: wide, height: high } = await locator.boundingBox();
        return x >= 0 && y >= 0 && x + wide <= width && y + high <= height;
      };
      const button = page.locator('header label.button', { hasText: 'Open mesh' }), samples = page.getByRole('navigation', { name: 'Samples' }).getByRole('button');
      assert.ok(await inside(button));
      assert.equal(await samples.count(), 8);
      for (let k = 0; k < 8; ++k) assert.ok(await inside(samples.nth(k)), await samples.nth(k).textContent());
      await page.screenshot({ path: path.join(pictures, `first-${width}.png`) });
      await samples.filter({ hasText: 'cube' }).click();
      await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'cube');
      await shown(page);
      const [chooser] = await Promise.all([page.waitForEvent('filechooser'), button.click()]);
      await chooser.setFiles([{ name: 'box.obj', mimeType: 'model/obj', buffer: Buffer.from(BOX) }]);
      await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'box.obj');
      await shown(page);
      assert.equal(await page.getByRole('navigation', { name: 'Samples' }).count(), 0);
      await page.getByRole('tab', { name: 'Mesh' }).click();
      await page.getByRole('button', { name: 'vase' }).click();
      await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'vase');
      await shown(page);
      await clean(opened);
      await opened.close();
    });

  test('a dropped mesh starts as it looks, and keeps what the user has chosen', async () => {
    const opened = await bench.open(), { page } = opened;
    await drop(page, [{ name: 'box.obj', data: BOX }]);
    await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'box.obj');
    await shown(page);
    assert.deepEqual(await state(page, s => s.shown.wish.settings), {}, 'neither the material nor the number of the sample');
    await page.getByRole('button', { name: 'None', pressed: true }).waitFor();
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('fragments', 12));
    await shown(page);
    await page.getByRole('button', { name: 'Wood' }).click();
    await shown(page);
    await page.getByRole('button', { name: 'Wood' }).click();
    await painted(page);
    assert.equal(await state(page, s => s.wish.settings.material), 'wood', 'a second click changes nothing');
    await drop(page, [{ name: 'other.obj', data: BOX.replace('v 1 1 1', 'v 1 1 1.25') }]);
    await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'other.obj');
    await shown(page);
    assert.deepEqual(await state(page, s => s.shown.wish.settings), { fragments: 12 });
    await page.getByRole('button', { name: 'Wood' }).click();
    await shown(page);
    await page.getByRole('button', { name: 'None' }).click();
    await shown(page);
    assert.deepEqual(await state(page, s => s.shown.wish.settings), { fragments: 12 });
    await clean(opened);
    await opened.close();
  });

  test('a click reaches the near surface, also between the fragments', async () => {
    const opened = await bench.open({ hash: '#sample=sphere&set={"material":"ice","fragments":60}', width: 1024, height: 700 }), { page } = opened;
    for (const explode of [0, 0.18, 0.6]) {
      await page.evaluate(to => globalThis.fracture.look({ explode: to }), explode);
      await page.evaluate(() => globalThis.fracture.stage.drawn());
      // A sphere of radius 0.5 about (0, 0.5, 0). The points lie within 0.7 of its radius on the screen, so that each ray meets the sphere.
      const found = await page.evaluate(spread => {
        const { view, stage } = globalThis.fracture, at = (x, y, z) => stage.camera.position.clone().set(x, y, z), [x, y] = stage.pixelOf(at(0, 0.5, 0));
        const side = at(1, 0, 0).applyQuaternion(stage.camera.quaternion), [edge] = stage.pixelOf(at(0, 0.5, 0).addScaledVector(side, 0.7 * 0.5 * (1 + spread)));
        const out = [];
        for (let k = 0; k < 60; ++k) {
          const r = (edge - x) * Math.sqrt((k + 0.5) / 60), angle = k * 2.399963;
          const picked = view.pick(x + r * Math.cos(angle), y + r * Math.sin(angle)), eye = stage.camera.position;
          out.push(picked && { interior: picked.interior, far: Math.hypot(picked.point[0], picked.point[1] - 0.5, picked.point[2]),
            near: picked.point[0] * eye.x + (picked.point[1] - 0.5) * (eye.y - 0.5) + picked.point[2] * eye.z > 0 });
        }
        return out;
      }, explode);
      const outside = found.filter(each => each && !each.interior);
      assert.equal(found.filter(Boolean).length, 60, `explode ${explode}: every click picks`);
      assert.ok(outside.every(({ far }) => far > 0.49 && far < 0.501), 'on the surface of the assembled mesh');
      assert.ok(found.every(({ near }) => near), 'on the side that is seen');
    }
    await clean(opened);
    await opened.close();
  });

  test('radius, number and fineness of pieces stand with the hits', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","pattern":"impact","fragments":20}' }), { page } = opened;
    const hits = page.getByRole('region', { name: 'Local hits' });
    for (const label of ['Local radius', 'Radius', 'Share', 'Exponent']) await hits.getByLabel(label, { exact: label === 'Local radius' }).first().waitFor();
    await hits.locator('#hit-sites').fill('45');
    await hits.locator('#hit-sites').press('Tab');
    const before = bench.site.passed.length;
    await page.mouse.click(...await onMesh(page));
    await shown(page);
    await page.mouse.click(...await onMesh(page));
    await shown(page);
    const asked = bench.site.passed.slice(before).filter(({ path: at }) => at.endsWith('/fracture')).map(({ body }) => JSON.parse(body));
    assert.deepEqual(asked[0].local_sites, [45], 'in a request with all parameters');
    assert.equal(asked.at(-1).local_sites, 45, 'in a hit on the answer');
    assert.deepEqual(await state(page, s => s.shown.answer.parameters.local_sites), [45, 45]);
    await page.waitForFunction(() => JSON.parse(new URLSearchParams(location.hash.slice(1)).get('hits') ?? '[]').length === 2);
    const digest = await state(page, s => s.shown.answer.parameters.local_sites), again = await bench.open({ hash: new URL(page.url()).hash });
    assert.deepEqual(await state(again.page, s => s.shown.answer.parameters.local_sites), digest, 'a link keeps it');
    await again.close();
    await clean(opened);
    await opened.close();
  });

  test('parameters stand under the headings of the documents, and are found by other words', async () => {
    const opened = await bench.open(), { page } = opened, panel = page.locator('#panel');
    await page.getByRole('button', { name: /All parameters/ }).click();
    await page.getByRole('button', { name: 'Fewer' }).waitFor();
    const text = fs.readFileSync(path.resolve(here, '../../../proto/parameters.md'), 'utf8'), headings = [...text.matchAll(/^## (.+)$/gm)].map(([, title]) => title).filter(title => !['Choose parameters', 'Cost'].includes(title));
    const said = (await panel.locator('summary').allTextContents()).map(each => each.replace(/\s+\d+\s*$/, '').trim());
    assert.ok(said.length > 10);
    assert.deepEqual(said, headings.filter(title => said.includes(title)), 'the same headings in the same order');
    for (const [word, id] of [['pieces', '#p-fragments'], ['bounce', '#p-restitution'], ['jagged', '#p-rough_amplitude'], ['inside colour', '#p-interior_color']]) {
      await page.fill('input[type=search]', word);
      await eventually(() => panel.locator('section').last().locator('.control').first().locator(id).count(), count => assert.equal(count, 1, `${word} is ${id}`));
    }
    await page.fill('input[type=search]', 'inches');
    await panel.getByRole('button', { name: 'On the Mesh tab' }).click();
    await page.getByRole('group', { name: 'Unit of the coordinates' }).waitFor();
    await clean(opened);
    await opened.close();
  });
});
