// The visible picture: it is the same after Play and after a change of size, even if frames are slow. No more frames are drawn than needed.
import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';
import { Bench, drop, onMesh, shown, skip, state } from './support.mjs';

describe('the picture', { skip, timeout: 300_000 }, () => {
  let bench;
  before(async () => {
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  const picture = page => page.locator('#viewport').screenshot();
  /** Waits until the picture equals that one again, pixel for pixel. */
  async function becomes(page, wanted, what) {
    for (const end = Date.now() + 20_000; Date.now() < end; await page.waitForTimeout(200))  // pause: between two pictures
      if ((await picture(page)).equals(wanted)) return;
    assert.fail(`${what}: another picture`);
  }
  /** Makes each frame take this many milliseconds. */
  const slow = (page, milliseconds) => page.evaluate(time => {
    const { renderer } = globalThis.fracture.stage, render = renderer.render.bind(renderer);
    globalThis.drawn = [];
    renderer.render = (...given) => {
      globalThis.drawn.push(renderer.getPixelRatio());
      render(...given);
      for (const end = performance.now() + time; performance.now() < end;);
    };
  }, milliseconds);

  test('after Play it is what it was, with its shadows, also where frames are slow', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":6}', width: 780, height: 420 }), { page } = opened;
    await page.mouse.move(5, 5);
    const before = await picture(page);
    await slow(page, 150);
    await page.keyboard.press('p');
    await page.waitForFunction(() => globalThis.fracture.physics);
    await page.keyboard.press(' ');
    await page.waitForFunction(() => globalThis.drawn.some(dots => dots < 1));
    await page.keyboard.press('p');
    await becomes(page, before, 'after Play');
    // Back above the ground, then back to the bench.
    await page.keyboard.press('p');
    await page.waitForFunction(() => globalThis.fracture.physics);
    await page.keyboard.press('r');
    await page.keyboard.press('p');
    await becomes(page, before, 'after Play and Reset');
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('a window that changes its size and back shows the same, also while it plays', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":6}', width: 780, height: 420 }), { page } = opened;
    await page.mouse.move(5, 5);
    const before = await picture(page);
    for (const plays of [false, true]) {
      if (plays) {
        await page.keyboard.press('p');
        await page.waitForFunction(() => globalThis.fracture.physics);
      }
      await page.setViewportSize({ width: 500, height: 700 });
      await page.waitForFunction(() => {
        const { width, height, parentElement: { clientWidth, clientHeight } } = document.querySelector('canvas');
        return Math.abs(width / height - clientWidth / clientHeight) < 0.01;
      });
      await page.setViewportSize({ width: 780, height: 420 });
      if (plays) await page.keyboard.press('p');
      await becomes(page, before, plays ? 'while it plays' : 'at the bench');
    }
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('the mesh fills a window of another shape as it would one that was so from the start, unless somebody has moved it', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":6}', width: 1024, height: 700 }), { page } = opened;
    const camera = () => page.evaluate(() => globalThis.fracture.stage.camera.position.toArray().map(value => Number(value.toFixed(6))));
    /** The camera, once it knows the size of the window. */
    const resized = async (width, height) => {
      await page.setViewportSize({ width, height });
      await page.waitForFunction(() => {
        const { clientWidth, clientHeight } = document.querySelector('#viewport');
        return Math.abs(globalThis.fracture.stage.camera.aspect - clientWidth / clientHeight) < 1e-6;
      });
      return camera();
    };
    const wide = await camera(), narrow = await resized(360, 740);
    assert.notDeepEqual(narrow, wide);
    await page.keyboard.press('f');
    assert.deepEqual(await camera(), narrow, 'Fit has nothing to do');
    // A click breaks, and moves nothing.
    await page.mouse.click(...await onMesh(page));
    await shown(page);
    assert.deepEqual(await resized(1024, 700), wide);
    await page.focus('canvas');
    await page.keyboard.press('ArrowLeft');
    const moved = await camera();
    assert.notDeepEqual(moved, wide);
    assert.deepEqual(await resized(360, 740), moved);
    await opened.close();
  });

  test('the first frame has the fragments: nothing is drawn before them', async () => {
    const opened = await bench.open({ wait: false }), { page } = opened;
    const frames = [];
    await page.exposeFunction('frame', pieces => frames.push(pieces));
    await page.addInitScript(() => {
      const draw = WebGL2RenderingContext.prototype.drawElements, clear = WebGL2RenderingContext.prototype.clear;
      let told = false;
      const tell = () => {
        if (!told) void globalThis.frame(globalThis.fracture?.view?.batch?.answer.parameters.fragments ?? 0);
        told = true;
      };
      WebGL2RenderingContext.prototype.drawElements = function drawElements(...given) {
        tell();
        return draw.apply(this, given);
      };
      WebGL2RenderingContext.prototype.clear = function clearAll(...given) {
        tell();
        return clear.apply(this, given);
      };
    });
    await page.reload();
    await shown(page);
    assert.deepEqual(frames, [40], 'of forty fragments');
    assert.equal(await state(page, s => s.shown.answer.parameters.fragments), 40);
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('a mesh whose fragments take longer is seen in one piece until then', async () => {
    const opened = await bench.open({ wait: false }), { page } = opened;
    bench.site.delay = 1500;
    await page.reload();
    const whole = () => globalThis.fracture?.state.source && !globalThis.fracture.state.shown && globalThis.fracture.stage.renderer.info.render.triangles > 0;
    await page.waitForFunction(whole, undefined, { polling: 50 });
    await shown(page);
    bench.site.delay = 0;
    await opened.close();
  });

  test('a sample looks like what it is made of, back and forth; a file keeps its colours', async () => {
    const opened = await bench.open({ hash: '#sample=vase&set={"material":"terracotta","fragments":12}' }), { page } = opened;
    const { materials } = await (await fetch(`${bench.server.url}/patterns`)).json();
    const linear = value => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);
    /**
     * Red, green and blue of a material as the server describes it, scaled so that the largest is 1. The outside may be darker or paler.
     */
    const hue = rgb => rgb.map(value => Number((value / Math.max(...rgb)).toFixed(3)));
    const hueOf = name => hue([1, 3, 5].map(at => linear(parseInt(materials.find(each => each.name === name).parameters.interior_color.slice(at, at + 2), 16) / 255)));
    const outside = () => state(page, s => s.shown.answer.document.json.materials[0].pbrMetallicRoughness.baseColorFactor.slice(0, 3)).then(hue);
    const mesh = () => state(page, s => [s.source.mesh.id, s.shown.answer.mesh.id]);
    assert.deepEqual(await outside(), hueOf('terracotta'));
    const [clay] = await mesh();
    for (const name of ['Wood', 'Ice']) {
      await page.getByRole('button', { name }).click();
      await page.getByRole('button', { name, pressed: true }).waitFor();
      await shown(page);
      assert.deepEqual(await outside(), hueOf(name.toLowerCase()), name);
    }
    const [ice, of] = await mesh();
    assert.equal(ice, of, 'what is downloaded is what is shown');
    assert.notEqual(ice, clay);
    for (let k = 0; k < 2; ++k) await page.keyboard.press('Control+z');
    await page.waitForFunction(() => globalThis.fracture.state.shown.wish.settings.material === 'terracotta');
    assert.deepEqual(await mesh(), [clay, clay]);
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('fragments', 14));
    await shown(page);
    assert.deepEqual([await mesh(), await outside()], [[clay, clay], hueOf('terracotta')]);
    // The same bytes as a user's file: its colours are kept.
    const data = Buffer.from(await state(page, s => [...s.source.input.data]));
    await drop(page, [{ name: 'pot.glb', data }]);
    await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'pot.glb');
    await shown(page);
    await page.getByRole('button', { name: 'Wood' }).click();
    await page.getByRole('button', { name: 'Wood', pressed: true }).waitFor();
    await shown(page);
    assert.deepEqual([await mesh(), await outside()], [[clay, clay], hueOf('terracotta')]);
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });
});
