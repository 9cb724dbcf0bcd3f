// Interactions other than clicks: places are dragged by their handles, folders are dropped, presets are kept as files. Also a picture that
// returns after the graphics card was lost.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, eventually, onMesh, painted, pictures, problem, serious, shown, skip, state } from './support.mjs';

describe('hands', { skip, timeout: 300_000 }, () => {
  let bench;
  before(async () => {
    bench = await Bench.start();
  });
  after(() => bench?.stop());

  const place = (page, name) => page.getByRole('group', { name: 'Points to drag' }).getByRole('button', { name });
  const dotOf = (page, key) => page.evaluate(wanted => {
    const { view, stage } = globalThis.fracture;
    return stage.pixelOf(view.handles.find(handle => handle.key === wanted).at);
  }, key);
  async function drag(page, key, dx, dy) {
    const [x, y] = await dotOf(page, key);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + dx, y + dy, { steps: 5 });
    await page.mouse.up();
    await shown(page);
    return [x + dx, y + dy];
  }
  const settings = page => state(page, s => s.shown.wish.settings);

  test('a sphere is kept where it is dragged, and the view does not turn', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":60}', width: 1024, height: 700 }), { page } = opened;
    const camera = () => page.evaluate(() => globalThis.fracture.stage.camera.position.toArray()), before = await camera();
    assert.equal(await state(page, s => s.shown.answer.fragments.length), 60);
    await place(page, 'Keep sphere').click();
    await shown(page);
    const first = await settings(page), kept = await state(page, s => s.shown.answer.report.keep?.share);
    assert.ok(kept > 0.001, `a share of ${kept} is kept whole in the sphere`);
    const to = await drag(page, 'keep_center middle', 0, 70);
    const moved = await settings(page);
    assert.ok(moved.keep_center[1] < first.keep_center[1], 'lower');
    assert.equal(moved.keep_radius, first.keep_radius);
    const dot = await dotOf(page, 'keep_center middle');
    assert.ok(Math.hypot(dot[0] - to[0], dot[1] - to[1]) < 2, 'the dot is under the pointer');
    await drag(page, 'keep_center radius', 40, 0);
    assert.ok((await settings(page)).keep_radius > moved.keep_radius, 'larger');
    await page.screenshot({ path: path.join(pictures, 'sphere.png') });
    assert.deepEqual(await camera(), before);
    assert.equal(await state(page, s => s.wish.settings.impacts), undefined, 'a drag is no hit');
    // Each drag is a single undo step, however it moved.
    await page.keyboard.press('Control+z');
    await page.waitForFunction(radius => globalThis.fracture.state.shown.wish.settings.keep_radius === radius, moved.keep_radius);
    await place(page, 'Keep sphere').click();
    await shown(page);
    assert.deepEqual(await settings(page), { material: 'stone', fragments: 60 });
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('a box is kept, a plane anchors, arrows are the grain and the slices', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":40}', width: 1024, height: 700 }), { page } = opened;
    await place(page, 'Keep box').click();
    await shown(page);
    const low = (await settings(page)).keep_box;
    await drag(page, 'keep_box 11', 0, -60);
    const high = (await settings(page)).keep_box;
    assert.ok(high[1][1] > low[1][1]);
    assert.deepEqual([high[0], high[1][0], high[1][2]], [low[0], low[1][0], low[1][2]], 'one face alone has moved');
    await place(page, 'Keep box').click();
    await place(page, 'Anchor plane').click();
    await shown(page);
    const held = () => state(page, s => s.shown.answer.fragments.filter(({ anchored }) => anchored).length), few = await held();
    await drag(page, 'anchor_plane middle', 0, -80);
    assert.ok(await held() > few && few > 0, `${few}, then ${await held()} fragments are held`);
    await place(page, 'Anchor plane').click();
    await place(page, 'Grain').click();
    await shown(page);
    await drag(page, 'grain', 120, 90);
    const { grain } = await settings(page);
    assert.ok(grain[1] < 0.95 && Math.abs(Math.hypot(...grain) - 1) < 0.01, `${grain}`);
    await page.selectOption('#p-pattern', 'slice');
    await shown(page);
    await place(page, 'Normals').click();
    await shown(page);
    await drag(page, 'normals 0', 120, 60);
    assert.ok((await settings(page)).normals[0][1] < 0.95);
    await page.screenshot({ path: path.join(pictures, 'slices.png') });
    // Settings that belong only to a pattern disappear with it; the server would refuse them.
    await page.getByRole('button', { name: 'Wood' }).click();
    await shown(page);
    assert.deepEqual(Object.keys(await settings(page)).sort(), ['fragments', 'grain', 'material']);
    assert.equal(await page.locator('[role=alert]').count(), 0);
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('a place that was hit stays one, whatever the material and the pattern know of impacts', async () => {
    const opened = await bench.open(), { page } = opened;
    await page.mouse.click(...await onMesh(page));
    await shown(page);
    const [point] = await state(page, s => s.shown.wish.settings.impacts);
    await page.getByRole('button', { name: 'Wood' }).click();
    await shown(page);
    assert.deepEqual(await state(page, s => s.shown.wish.settings.impacts), [point]);
    await page.selectOption('#p-pattern', 'uniform');
    await shown(page);
    assert.deepEqual(await state(page, s => [s.shown.wish.settings.impacts, s.shown.wish.hits.map(hit => hit.point)]), [undefined, [point]]);
    assert.equal(await page.locator('[role=alert]').count(), 0);
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('Play is entered and left as often as somebody presses, and ends as the last press says', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":8}' }), { page } = opened;
    const away = () => page.evaluate(() => globalThis.fracture.stage.camera.position.distanceTo(globalThis.fracture.stage.controls.target));
    const before = await away();
    // Physics loads after all the presses.
    await page.evaluate(() => import('/page/play.js'));
    const press = times => page.evaluate(count => {
      for (let k = 0; k < count; ++k) document.body.dispatchEvent(new KeyboardEvent('keydown', { key: 'p', bubbles: true, cancelable: true }));
    }, times);
    const playing = () => page.waitForFunction(() => globalThis.fracture.state.play?.loading === false && globalThis.fracture.physics);
    const onBench = () => page.evaluate(() => new Promise(resolve => setTimeout(resolve, 400))).then(() => state(page, s => s.play === undefined));  // pause: nothing arrives late
    for (const count of [4, 12]) {
      await press(count);
      assert.ok(await onBench(), `${count} presses`);
      assert.ok(Math.abs(await away() - before) < 1e-6 * before, `the camera after ${count} presses`);
    }
    await press(3);
    await playing();
    assert.ok(Math.abs(await away() / before - 1.5) < 0.01, 'one step back for one Play');
    // A new answer while it plays: its pieces are played.
    await page.evaluate(() => globalThis.fracture.breaking.setParameter('fragments', 12));
    await shown(page);
    await playing();
    assert.equal(await page.evaluate(() => globalThis.fracture.physics.pieces.meshes.length), 12);
    // If a step fails, the page returns to the bench with a message, and the next Play works.
    await page.evaluate(() => {
      globalThis.fracture.physics.world.step = () => {
        throw new Error('unreachable');
      };
    });
    assert.match((await problem(page)).detail, /unreachable/);
    assert.ok(await onBench(), 'after a step that failed');
    assert.ok(Math.abs(await away() - before) < 1e-6 * before);
    await page.evaluate(() => globalThis.fracture.dismiss());
    await page.getByRole('button', { name: 'Play', exact: true }).click();
    await playing();
    await page.getByRole('button', { name: 'Stop playing' }).click();
    assert.ok(await onBench());
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('what is about the bench goes with Play: rings, and hints of clicks', async () => {
    const opened = await bench.open({ hash: '#sample=vase&set={"material":"terracotta","fragments":300}' }), { page } = opened;
    const rings = () => page.evaluate(() => globalThis.fracture.view.rings.children.length), hits = page.getByRole('region', { name: 'Hits' });
    await page.getByRole('tab', { name: 'Fragments' }).click();
    await page.getByRole('button', { name: 'Smallest' }).click();
    assert.equal(await rings(), 1, 'the smallest is small');
    await page.getByRole('tab', { name: 'Break' }).click();
    await page.mouse.click(...await onMesh(page));
    await shown(page);
    await hits.getByText('Click the mesh again').waitFor();
    for (const [tool, said] of [['Aim', 0], ['Select', 0], ['Hit', 1]]) {
      await page.getByRole('button', { name: tool, exact: true }).click();
      await eventually(() => hits.getByText('Click the mesh').count(), count => assert.equal(count, said, tool));
    }
    await page.keyboard.press('p');
    await page.waitForFunction(() => globalThis.fracture.physics);
    await page.evaluate(() => globalThis.fracture.look({}));
    assert.equal(await rings(), 0, 'nothing stays where the piece was');
    await eventually(() => hits.textContent(), text => assert.match(text, /Impact, 1 hit\.\s/));
    assert.doesNotMatch(await hits.textContent(), /Click the mesh/);
    await page.keyboard.press('p');
    await hits.getByText('Click the mesh again').waitFor();
    assert.equal(await rings(), await state(page, s => s.look.chosen.size));
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('the piece that is found is seen in the list, however far down', async () => {
    for (const [width, height] of [[1024, 700], [360, 740]]) {
      const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":120}', width, height }), { page } = opened;
      await page.getByRole('tab', { name: 'Fragments' }).click();
      const listed = page.getByRole('table').locator('tbody tr');
      await eventually(() => listed.count(), count => assert.equal(count, 50, 'the list begins with fifty'));
      for (const name of ['Smallest', 'Largest']) {
        await page.getByRole('button', { name, exact: true }).click();
        await eventually(() => page.evaluate(() => {
          const row = document.querySelector('.fragments tr.chosen'), { left, right, top, bottom } = row.getBoundingClientRect();
          return [top + 1, bottom - 1].map(y => row.contains(document.elementFromPoint((left + right) / 2, y)));
        }), seen => assert.deepEqual(seen, [true, true], `${name}, ${width} x ${height}`));
      }
      assert.deepEqual(opened.complaints, []);
      await opened.close();
    }
  });

  test('the number beside the radius takes as much room as any other, and both have all of theirs', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"fragments":8}' }), { page } = opened;
    const slider = page.locator('#radius'), widths = new Set();
    for (let k = 0; k <= 1000; k += 50) {
      await slider.evaluate((input, value) => {
        input.value = value;
        input.dispatchEvent(new Event('input'));
      }, k);
      await painted(page);
      widths.add(await slider.evaluate(input => input.getBoundingClientRect().width));
      assert.deepEqual(await page.locator('.control:has(#radius)').evaluate(control => [...control.querySelectorAll('label, output')].filter(each => each.scrollWidth > each.clientWidth).map(each => each.textContent)), []);
    }
    assert.equal(widths.size, 1, `${[...widths]}`);
    await opened.close();
  });

  test('a number says what 0 stands for, and what is beyond its limits, beside it', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":8}' }), { page } = opened;
    const field = page.locator('#p-fragments'), control = page.locator('.control:has(#p-fragments)'), asked = bench.site.passed.length;
    await field.fill('250000');
    await field.press('Tab');
    await control.getByText('250,000 is out of range: enter 0 to 100,000.').waitFor();
    assert.deepEqual([await field.inputValue(), await state(page, s => s.wish.settings.fragments), bench.site.passed.length], ['8', 8, asked]);
    await field.fill('1');
    await field.press('Tab');
    await shown(page);
    await control.getByText('is out of range').waitFor({ state: 'detached' });
    await eventually(() => page.locator('.status').textContent(), said => assert.match(said, /^\s*1\s+fragment\s/));
    await page.getByRole('tab', { name: 'Fragments' }).click();
    await page.getByRole('button', { name: 'Smallest' }).click();
    assert.doesNotMatch(await page.locator('#panel').innerText(), /\b1 (fragments|hulls|bodies)/);
    await page.getByRole('tab', { name: 'Break' }).click();
    await control.getByRole('button', { name: /Reset to the default/ }).click();
    await shown(page);
    await eventually(async () => [await field.inputValue(), await field.getAttribute('placeholder')], found => assert.deepEqual(found, ['', 'auto']));
    await eventually(() => page.getByRole('slider', { name: 'Fragments' }).getAttribute('aria-valuetext'), said => assert.equal(said, 'auto'));
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('a drag ends with its own pointer, and where its end was not seen with the next movement', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":20}', width: 1024, height: 700 }), { page } = opened;
    await place(page, 'Keep sphere').click();
    await shown(page);
    const height = async () => (await state(page, s => s.wish.settings)).keep_center[1];
    const first = await height(), [x, y] = await dotOf(page, 'keep_center middle');
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x, y + 20);
    const lower = await height();
    assert.ok(lower < first);
    await page.evaluate(() => dispatchEvent(new PointerEvent('pointercancel', { pointerId: 99 })));
    await page.mouse.move(x, y + 40);
    const lowest = await height();
    assert.ok(lowest < lower, "another finger's cancel ends no drag");
    await page.evaluate(([clientX, clientY]) => document.querySelector('#viewport canvas').dispatchEvent(new PointerEvent('pointermove', { pointerId: 1, buttons: 0, clientX, clientY })), [x, y + 60]);
    await page.mouse.move(x, y + 80);
    assert.equal(await height(), lowest, 'the button was let go unseen');
    await page.mouse.up();
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('a key that repeats more often than the panel is drawn counts each time', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"fragments":20}' }), { page } = opened;
    await page.getByRole('slider', { name: 'Fragments' }).evaluate(slider => {
      for (let k = 0; k < 5; ++k) slider.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true }));
    });
    await shown(page);
    assert.equal(await state(page, s => s.shown.answer.fragments.length), 25);
    // The key is released in another window, so this one is not told. The next press is a separate step.
    await page.getByRole('slider', { name: 'Fragments' }).evaluate(async slider => {
      slider.dispatchEvent(new FocusEvent('blur'));
      await new Promise(later => setTimeout(later, 1000));
      slider.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true }));
    });
    await shown(page);
    assert.equal(await state(page, s => s.shown.answer.fragments.length), 26);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(() => globalThis.fracture.state.shown.answer.fragments.length === 25);
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('what is exploded stays in the picture, and another mesh is as spread as the first one was', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"stone","fragments":40}' }), { page } = opened;
    const camera = () => page.evaluate(() => globalThis.fracture.stage.camera.position.toArray().map(value => Number(value.toFixed(6))));
    const explode = value => page.evaluate(to => {
      const slider = document.querySelector('#explode');
      slider.value = to;
      slider.dispatchEvent(new Event('input'));
    }, value);
    const outside = () => page.evaluate(() => {
      const { stage, view } = globalThis.fracture, { left, top, right, bottom } = document.querySelector('canvas').getBoundingClientRect();
      return view.batch.pieces.filter((_, k) => {
        const [x, y] = stage.pixelOf(stage.camera.position.clone().set(...view.batch.poses.get(k).at));
        return x < left || x > right || y < top || y > bottom;
      }).length;
    });
    const before = await camera(), usual = await state(page, s => s.look.explode);
    await explode(1);
    assert.equal(await state(page, s => s.look.explode), 3);
    assert.equal(await outside(), 0, 'pieces out of the picture');
    await page.screenshot({ path: path.join(pictures, 'exploded.png') });
    await explode(0.2);
    assert.deepEqual(await camera(), before, 'back where it was');
    await explode(1);
    await page.keyboard.press('f');
    assert.equal(await outside(), 0, 'after fit');
    await page.evaluate(() => globalThis.fracture.bringing.sample('plank'));
    await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'plank');
    await shown(page);
    assert.equal(await state(page, s => s.look.explode), usual);
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  test('a folder is dropped, with what systems leave in it', async () => {
    const opened = await bench.open(), { page } = opened, folder = fs.mkdtempSync(path.join(os.tmpdir(), 'fracture-page-')), asset = path.join(folder, 'asset');
    fs.mkdirSync(path.join(asset, 'textures'), { recursive: true });
    const box = 'mtllib box.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvt 0 0\nusemtl red\n' +
      ['4 3 2 1', '5 6 7 8', '1 2 6 5', '2 3 7 6', '3 4 8 7', '4 1 5 8'].map(face => `f ${face.split(' ').map(v => `${v}/1`).join(' ')}\n`).join('');
    fs.writeFileSync(path.join(asset, 'box.obj'), box);
    fs.writeFileSync(path.join(asset, 'box.mtl'), 'newmtl red\nKd 1 1 1\nmap_Kd textures/red.png\n');
    fs.writeFileSync(path.join(asset, 'textures/red.png'), Buffer.from('iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC', 'base64'));
    fs.writeFileSync(path.join(asset, '.DS_Store'), 'what a system leaves');
    try {
      const browser = await page.context().newCDPSession(page), data = { items: [], files: [asset], dragOperationsMask: 1 };
      for (const type of ['dragEnter', 'dragOver', 'drop']) await browser.send('Input.dispatchDragEvent', { type, x: 300, y: 250, data });
      await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'box.obj');
      await shown(page);
      assert.deepEqual(await state(page, s => s.source.input.map(({ name }) => name).sort()), ['asset/box.mtl', 'asset/box.obj', 'asset/textures/red.png']);
      assert.equal(await state(page, s => s.shown.answer.document.json.textures.length), 1, 'the texture of a folder in the folder');
      assert.deepEqual(opened.complaints, []);
    } finally {
      fs.rmSync(folder, { recursive: true });
    }
    await opened.close();
  });

  test('a preset is saved, and read for another mesh', async () => {
    const opened = await bench.open({ hash: '#sample=cube&set={"material":"concrete","fragments":21,"keep_center":[0,0.5,0],"keep_radius":0.2}' }), { page } = opened;
    await page.getByRole('tab', { name: 'Export' }).click();
    const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Save as a file' }).click()]);
    assert.equal(file.suggestedFilename(), 'concrete.fracture.json');
    const saved = await file.path();
    await page.getByRole('tab', { name: 'Mesh' }).click();
    await page.getByRole('button', { name: 'column' }).click();
    await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'column');
    await shown(page);
    await page.getByRole('tab', { name: 'Export' }).click();
    await page.getByLabel('Load a file').setInputFiles(saved);
    await page.waitForFunction(() => globalThis.fracture.state.wish.settings.material === 'concrete');
    await shown(page);
    assert.deepEqual(await settings(page), { material: 'concrete', fragments: 21 });
    await page.getByLabel('Load a file').setInputFiles({ name: 'no.json', mimeType: 'application/json', buffer: Buffer.from('{"fragments":3}') });
    assert.match((await problem(page)).title, /not a preset/);
    assert.deepEqual(opened.complaints, []);
    await opened.close();
  });

  /** How many colours the picture has; with only one or two it is blank. */
  const colours = page => page.evaluate(async () => {
    const { stage } = globalThis.fracture, bitmap = await createImageBitmap(await stage.picture()), canvas = new OffscreenCanvas(64, 64), context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0, 64, 64);
    const { data } = context.getImageData(0, 0, 64, 64);
    return new Set(new Uint32Array(data.buffer)).size;
  });

  test('never a blank canvas: a card that goes and comes back, and a file that is no mesh', async () => {
    const opened = await bench.open(), { page } = opened, before = await colours(page);
    assert.ok(before > 50, `${before} colours`);
    await page.evaluate(() => {
      globalThis.card = globalThis.fracture.stage.renderer.getContext().getExtension('WEBGL_lose_context');
      globalThis.card.loseContext();
    });
    await page.getByText('The graphics card was reset').waitFor();
    await page.evaluate(() => globalThis.card.restoreContext());
    await page.getByText('The graphics card was reset').waitFor({ state: 'detached' });
    await page.evaluate(() => globalThis.fracture.stage.drawn());
    const after = await colours(page);
    assert.ok(after > before / 2, `${after} colours after it came back, ${before} before`);
    // The previous mesh stays.
    await page.getByRole('tab', { name: 'Mesh' }).click();
    await page.setInputFiles('input[type=file] >> nth=0', { name: 'holiday.txt', mimeType: 'text/plain', buffer: Buffer.from('a text') });
    await problem(page);
    await eventually(() => page.getByRole('alert').textContent(), said => assert.match(said, /^\s*holiday\.txt: /));
    assert.ok(await colours(page) > before / 2);
    assert.equal(await state(page, s => s.source.label), 'vase');
    assert.deepEqual(serious(opened.complaints).filter(text => !/context lost|context restored/i.test(text)), []);
    await opened.close();
  });
});
