// Runs the tests of the page; called by ctest.
//   node run.mjs prepare        npm ci if needed, and the build of the page
//   node run.mjs NAME           NAME.test.mjs with node's own test runner; with FRACTURE_TEST_FULL=1 all of it
//   node run.mjs late           some of them with every frame 300 ms late: a test that reads too early then always fails
// If something is missing, it prints the name and exits with 77: the test counts as skipped, not as passed.
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url)), folder = path.resolve(here, '../../../client/page'), [name] = process.argv.slice(2);
const at = (...parts) => path.join(folder, ...parts);
const skip = why => {
  console.log(`skipped: ${why}`);
  process.exit(77);
};
const time = file => (fs.existsSync(file) ? fs.statSync(file).mtimeMs : 0);

if (Number(process.versions.node.split('.')[0]) < 18) skip(`node ${process.versions.node} is older than 18`);
if (name === 'prepare') {
  if (time(at('package-lock.json')) > time(at('node_modules/.package-lock.json'))) {
    const { status, error, stderr } = spawnSync('npm', ['ci', '--no-audit', '--no-fund', '--fetch-retries=0'], { cwd: folder, encoding: 'utf8', timeout: 240_000 });
    if (error || status !== 0) skip(`npm ci in client/page does not work here: ${error?.message ?? stderr.slice(-400)}`);
  }
  process.exit(spawnSync('npm', ['run', '--silent', 'build'], { cwd: folder, stdio: 'inherit' }).status ?? 1);
}
if (!fs.existsSync(at('node_modules/three'))) skip('node_modules of client/page is missing (npm ci)');
if (!fs.existsSync(at('dist/index.html'))) skip('client/page is not built (npm run build)');
if (!['unit', 'snippets', 'pieces', 'docs'].includes(name)) {
  if (!process.env.FRACTURE_TEST_SERVER) skip('FRACTURE_TEST_SERVER names no fracture-server');
  if (!['/usr/bin/chromium', '/usr/bin/chromium-browser'].some(file => fs.existsSync(file))) skip('there is no Chromium (scripts/install-deps pictures)');
}
// These turn thousands of fragments in software, which takes minutes on a busy machine.
if (['play', 'load', 'late'].includes(name) && process.env.FRACTURE_TEST_FULL !== '1') skip('FRACTURE_TEST_FULL is not 1');
if (name === 'meshes' && !process.env.FRACTURE_TEST_MESHES) skip('FRACTURE_TEST_MESHES names no folders');
const files = (name === 'late' ? ['trouble', 'tasks', 'offers'] : [name]).map(each => path.join(here, `${each}.test.mjs`));
const env = name === 'late' ? { ...process.env, FRACTURE_TEST_LATE_FRAMES: '300' } : process.env;
process.exit(spawnSync(process.execPath, ['--test', '--test-concurrency=1', '--test-reporter=spec', ...files], { stdio: 'inherit', env }).status ?? 1);
