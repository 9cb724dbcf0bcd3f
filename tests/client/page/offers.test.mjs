// The samples include the files that the server was told to offer: a mesh from Debian's assimp-testmodels, if that is installed, and a file
// that is not a mesh.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { Bench, pictures, problem, realServer, shown, skip, state } from './support.mjs';

const MONKEY = '/usr/share/assimp/models/BLEND/Suzanne_248.blend';

describe('offers', { skip, timeout: 120_000 }, () => {
  let bench, folder;
  before(async () => {
    folder = fs.mkdtempSync(path.join(os.tmpdir(), 'fracture-page-'));
    fs.writeFileSync(path.join(folder, 'words.obj'), 'no mesh\n');
    const monkey = fs.existsSync(MONKEY) ? ['--enable-format', 'blend', '--page-sample', MONKEY] : [];
    bench = await Bench.start({ server: await realServer({ flags: [...monkey, '--page-sample', path.join(folder, 'words.obj')] }) });
  });
  after(async () => {
    await bench?.stop();
    fs.rmSync(folder, { recursive: true });
  });

  test('the monkey is a sample where it is installed, and can be taken away', { skip: !fs.existsSync(MONKEY) && 'assimp-testmodels is not installed' }, async () => {
    const opened = await bench.open(), { page } = opened;
    await page.getByRole('tab', { name: 'Mesh' }).click();
    await page.getByRole('button', { name: 'Suzanne_248.blend' }).click();
    await page.waitForFunction(() => globalThis.fracture.state.source?.label === 'Suzanne_248.blend');
    await shown(page);
    assert.ok(await state(page, s => s.shown.answer.fragments.length) > 1);
    await page.screenshot({ path: path.join(pictures, 'monkey.png') });
    await page.getByRole('tab', { name: 'Export' }).click();
    const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download this mesh' }).click()]);
    assert.equal(file.suggestedFilename(), 'Suzanne_248.blend');
    assert.ok(fs.readFileSync(MONKEY).equals(fs.readFileSync(await file.path())), 'byte for byte');
    assert.deepEqual([opened.complaints, opened.foreign], [[], []]);
    await opened.close();
  });

  test('one that is no mesh is refused by its name, and what was there stays', async () => {
    const opened = await bench.open(), { page } = opened;
    await page.getByRole('tab', { name: 'Mesh' }).click();
    const before = await state(page, s => s.source.label);
    await page.getByRole('button', { name: 'words.obj' }).click();
    await problem(page);
    await page.getByRole('alert').getByText('words.obj').waitFor();
    assert.equal(await state(page, s => s.source.label), before);
    await opened.close();
  });
});
