// Five tasks of a person who has only the address. Everything is found by its visible words. The tests judge the visible page and the
// downloads, not the page's own state.
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, eventually, painted, skip } from './support.mjs';

for (const [width, height] of [[1280, 800], [360, 740]])
  describe(`a first visit, ${width} x ${height}`, { skip, timeout: 240_000 }, () => {
    let bench, opened, page;
    before(async () => {
      bench = await Bench.start();
      opened = await bench.open({ width, height, wait: false });
      ({ page } = opened);
    });
    after(() => bench?.stop());

    const status = () => page.locator('.status'), count = async () => Number(/^\s*([\d,]+)/.exec(await status().textContent())[1].replace(',', ''));
    const until = (what, given) => page.waitForFunction(what, given, { timeout: 20_000 });
    /** Waits for the proved answer to a request. */
    async function answered() {
      await painted(page);
      await until(() => /Proved/.test(document.querySelector('.status')?.textContent ?? '') && /\d (ms|s)/.test(document.querySelector('.status .time')?.textContent ?? ''));
    }

    test('the sample is broken, and the slider breaks it into more', async () => {
      await answered();
      const before = await count();
      assert.ok(before > 1, `${before} fragments without doing anything`);
      await page.getByRole('tab', { name: 'Break' }).click();
      const slider = page.getByRole('slider', { name: 'Fragments' });
      await slider.focus();
      for (let k = 0; k < 5; ++k) await slider.press('ArrowRight');
      await until(wanted => Number(/\d+/.exec(document.querySelector('.status').textContent)) === wanted, before + 5);
      await answered();
    });

    test('it is hit where they point', async () => {
      await page.getByRole('region', { name: 'Hits' }).getByText(/Click the mesh to hit it there/).waitFor();
      await page.getByRole('button', { name: 'Hit', exact: true }).click();
      const { x, y, width: wide, height: high } = await page.getByRole('img', { name: /Viewport/ }).boundingBox();
      await page.mouse.click(x + wide / 2, y + high / 2);
      await page.getByRole('region', { name: 'Hits' }).getByText(/Impact/).waitFor();
      await answered();
    });

    test('it is wood', async () => {
      await page.getByRole('button', { name: 'Wood' }).click();
      await page.getByRole('button', { name: 'Wood', pressed: true }).waitFor();
      await answered();
      assert.equal(await page.getByRole('alert').count(), 0);
    });

    let smallest;
    test('the smallest piece is found', async () => {
      await page.getByRole('tab', { name: 'Fragments' }).click();
      await page.getByRole('button', { name: 'Smallest' }).click();
      const row = page.getByRole('table').locator('tr.chosen');
      // Sorted by volume with the smallest first, it is the first in the list.
      await page.getByRole('button', { name: 'Volume' }).click();
      await row.waitFor();
      await eventually(async () => [await page.getByRole('table').locator('tbody tr').first().textContent(), await row.textContent()], ([first, chosen]) => assert.equal(first, chosen));
      smallest = await row.getByRole('button').textContent();
      await eventually(() => page.getByRole('region', { name: 'Selection' }).textContent(), said => assert.match(said, new RegExp(smallest)));
    });

    test('the curl line is taken away, and gives the same pieces', async t => {
      await page.getByRole('tab', { name: 'Export' }).click();
      await page.getByRole('button', { name: 'curl' }).click();
      const line = await page.getByRole('textbox', { name: 'curl' }).inputValue();
      assert.match(line, /^curl --fail-with-body -F mesh=@vase\.glb/);
      assert.match(line, /"material":"wood"/);
      if (spawnSync('curl', ['--version']).error) return t.skip('there is no curl');
      const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'fracture-page-'));
      try {
        // Downloads the sample and its fragments as the page offers them, and runs the line unchanged.
        assert.match(line, /vase\.glb is a sample/);
        const [sample] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download this mesh' }).click()]);
        assert.equal(sample.suggestedFilename(), 'vase.glb');
        await sample.saveAs(path.join(folder, 'vase.glb'));
        const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: /^GLB/ }).click()]);
        const shell = spawn('sh', ['-c', line], { cwd: folder, stdio: 'ignore', timeout: 60_000, env: { PATH: process.env.PATH, no_proxy: '127.0.0.1' } });
        assert.equal(await new Promise(resolve => shell.once('exit', resolve)), 0);
        assert.ok(fs.readFileSync(path.join(folder, 'fragments.glb')).equals(fs.readFileSync(await file.path())), 'byte for byte');
      } finally {
        fs.rmSync(folder, { recursive: true });
      }
      assert.deepEqual(opened.complaints, []);
      assert.deepEqual(opened.foreign, []);
      return undefined;
    });
  });
