// Physics in the page: loaded only on the first Play, with the bodies from the file, until everything rests.
import assert from 'node:assert/strict';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, pictures, skip, state } from './support.mjs';

describe('play', { skip, timeout: 300_000 }, () => {
  let bench;
  before(async () => {
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  test('falls, is hit by a ball, breaks, and rests on the ground', async () => {
    const loaded = [], opened = await bench.open({ hash: '#sample=vase&set={"material":"terracotta","fragments":30}', width: 780, height: 420 }), { page } = opened;
    page.on('request', request => loaded.push(new URL(request.url()).pathname));
    await page.keyboard.press('p');
    await page.waitForFunction(() => globalThis.fracture.physics);
    assert.ok(loaded.includes('/page/play.js'), 'physics is loaded on the first Play');
    const bodies = await state(page, s => s.play.bodies);
    await page.waitForTimeout(300);  // pause: it falls
    for (let k = 0; k < 3; ++k) await page.keyboard.press(' ');
    await page.screenshot({ path: path.join(pictures, 'ball.png') });
    await page.waitForFunction(() => globalThis.fracture.state.play.resting, undefined, { timeout: 150_000 }).catch(async error => {
      throw new Error(`${error.message} ${await page.evaluate(() => JSON.stringify([globalThis.fracture.state.play, globalThis.fracture.state.problem, globalThis.fracture.physics.untouched]))}`);
    });
    const rest = await page.evaluate(() => {
      const { stage, view } = globalThis.fracture, { poses, pieces } = view.batch;
      const heights = pieces.map((_, k) => poses.get(k).at[1]);
      return { bodies: globalThis.fracture.state.play.bodies, lowest: Math.min(...heights) - stage.groundHeight, size: view.size, all: heights.every(Number.isFinite) };
    });
    await page.screenshot({ path: path.join(pictures, 'rest.png') });
    console.log(`${bodies} body before, ${rest.bodies} at rest`);
    assert.ok(rest.all && rest.lowest > -0.02 * rest.size, `nothing is below the ground: ${rest.lowest}`);
    assert.ok(rest.bodies > bodies, 'bonds broke');
    await page.keyboard.press('r');
    await page.waitForFunction(() => globalThis.fracture.state.play.bodies === 1);
    // The button for slow motion: as many steps, but smaller ones. The test counts frames, however fast the machine draws them.
    const fall = () => page.evaluate(() => {
      const { stage, view, physics } = globalThis.fracture, height = () => view.batch.poses.get(0).at[1];
      physics.reset();
      stage.animate(undefined);
      const before = height();
      for (let k = 0; k < 6; ++k) physics.frame(1.01 / 60);
      return before - height();
    });
    const fast = await fall();
    await page.getByRole('button', { name: 'Slow motion' }).click();
    await page.getByRole('button', { name: 'Slow motion', pressed: true }).waitFor();
    const slow = await fall();
    console.log(`six steps fall ${fast.toFixed(4)} m, in slow motion ${slow.toFixed(5)} m`);
    assert.ok(fast > 0 && slow > 0 && slow < 0.05 * fast, `${slow} of ${fast}`);
    await page.keyboard.press('t');
    await page.getByRole('button', { name: 'Slow motion', pressed: false }).waitFor();
    await page.evaluate(() => globalThis.fracture.physics.reset());
    await page.evaluate(() => globalThis.fracture.physics.pause());
    // A piece that is dragged moves; the view does not turn.
    const camera = await page.evaluate(() => globalThis.fracture.stage.camera.position.toArray());
    const at = await page.evaluate(() => {
      const { left, top, width, height } = document.querySelector('canvas').getBoundingClientRect();
      for (let y = 0.2; y < 0.8; y += 0.02) if (globalThis.fracture.view.pick(left + width / 2, top + height * y)) return [left + width / 2, top + height * y];
      return undefined;
    });
    await page.mouse.move(...at);
    await page.mouse.down();
    await page.mouse.move(at[0] + 120, at[1] - 60, { steps: 6 });
    await page.waitForFunction(() => globalThis.fracture.view.batch.poses.get(0).at[0] !== globalThis.fracture.view.batch.pieces[0].origin[0]);
    await page.mouse.up();
    assert.deepEqual(await page.evaluate(() => globalThis.fracture.stage.camera.position.toArray()), camera);
    await page.keyboard.press('Escape');
    await page.waitForFunction(() => !globalThis.fracture.state.play);
    assert.deepEqual(await page.evaluate(() => globalThis.violations), []);
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });
});
