// Heavy use: a hundred fractures leave memory unchanged, and two thousand fragments can still be turned.
import assert from 'node:assert/strict';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, full, pictures, shown, skip, state } from './support.mjs';

describe('much', { skip, timeout: 300_000 }, () => {
  let bench;
  before(async () => {
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  test('two thousand fragments', async () => {
    const opened = await bench.open({ hash: `#sample=cube&set={"sites":2000}`, width: 800, height: 600 }), { page } = opened;
    assert.equal(await state(page, s => s.shown.answer.fragments.length), 2000);
    const measure = () => page.evaluate(async () => {
      const { stage } = globalThis.fracture, times = [];
      for (let k = 0; k < 40; ++k) {
        stage.camera.position.applyAxisAngle(stage.camera.up, 0.05);
        stage.camera.lookAt(stage.controls.target);
        await stage.drawn();
        // Once a pixel can be read, the card has drawn everything that was sent to it.
        const gl = stage.renderer.getContext();
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        times.push(performance.now());
      }
      return times.slice(11).map((time, k) => time - times[k + 10]).sort((a, b) => a - b);
    });
    const times = await measure(), median = times[times.length >> 1];
    await page.screenshot({ path: path.join(pictures, 'many.png') });
    console.log(`2,000 fragments, ${await state(page, s => s.shown.answer.fragments.reduce((sum, { triangles }) => sum + triangles.length / 3, 0))} triangles: ` +
      `${(1000 / median).toFixed(1)} frames a second in software at 800 x 600 (median), ${times.at(-1).toFixed(0)} ms the longest`);
    // The limit is 8 frames a second. A machine that does other things as well needs to reach only a third of it.
    assert.ok(1000 / median > 8 / 3, `${median} ms`);
    await opened.close();
  });

  test('a hundred fractures', { skip: full ? false : 'with FRACTURE_TEST_FULL=1' }, async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":60}' }), { page } = opened, heaps = [];
    const browser = await page.context().newCDPSession(page);
    await browser.send('HeapProfiler.enable');
    for (let k = 1; k <= 120; ++k) {
      await page.evaluate(seed => globalThis.fracture.breaking.setParameter('seed', seed), k + 1);
      await shown(page);
      if (k % 20 !== 0) continue;
      // The page's own gc() leaves objects that wait for a finalizer: tens of megabytes of old answers.
      for (let twice = 0; twice < 2; ++twice) await browser.send('HeapProfiler.collectGarbage');
      const { usedSize, backingStorageSize } = await browser.send('Runtime.getHeapUsage');
      heaps.push({ heap: usedSize + backingStorageSize, ...await page.evaluate(() => globalThis.fracture.stage.renderer.info.memory) });
    }
    console.log(heaps.map(({ heap, geometries, textures }) => `${(heap / 2 ** 20).toFixed(1)} MiB ${geometries} geometries ${textures} textures`).join('; '));
    // An answer of sixty fragments takes more than a megabyte. If each were kept, that would be more than a hundred.
    assert.ok(heaps.at(-1).heap < heaps[0].heap + (4 << 20), 'memory is flat');
    assert.equal(heaps.at(-1).geometries, heaps[1].geometries);
    assert.equal(heaps.at(-1).textures, heaps[1].textures);
    await opened.close();
  });
});
