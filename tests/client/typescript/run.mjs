// Runs the tests of the package; called by ctest.
//   node run.mjs prepare        npm ci if needed, and the build of the package
//   node run.mjs NAME           NAME.test.mjs with node's own test runner
// If something is missing, it says what and exits with 77: the test counts as skipped, not as passed.
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url)), folder = path.resolve(here, '../../../client/typescript'), [name] = process.argv.slice(2);
const at = (...parts) => path.join(folder, ...parts), tsc = at('node_modules/typescript/bin/tsc');
const skip = why => {
  console.log(`skipped: ${why}`);
  process.exit(77);
};
const time = file => (fs.existsSync(file) ? fs.statSync(file).mtimeMs : 0);

if (Number(process.versions.node.split('.')[0]) < 18) skip(`node ${process.versions.node} is older than 18`);
if (name === 'prepare') {
  if (time(at('package-lock.json')) > time(at('node_modules/.package-lock.json'))) {
    const options = { cwd: folder, encoding: 'utf8', timeout: 240_000 };
    const { status, error, stderr } = spawnSync('npm', ['ci', '--no-audit', '--no-fund', '--fetch-retries=0'], options);
    if (error || status !== 0) skip(`npm ci in client/typescript does not work here: ${error?.message ?? stderr.slice(-400)}`);
  }
  const { status } = spawnSync(process.execPath, [tsc, '-p', folder], { stdio: 'inherit' });
  process.exit(status ?? 1);
}
if (!fs.existsSync(tsc)) skip('node_modules of client/typescript is missing (npm ci)');
if (!fs.existsSync(at('dist/index.js'))) skip('client/typescript is not built (npm run build)');
if (['babylon', 'closed', 'physics', 'service', 'web'].includes(name) && !process.env.FRACTURE_TEST_SERVER) skip('FRACTURE_TEST_SERVER names no fracture-server');
if (['babylon', 'web'].includes(name) && !['/usr/bin/chromium', '/usr/bin/chromium-browser'].some(file => fs.existsSync(file)))
  skip('there is no Chromium (scripts/install-deps pictures)');
process.exit(spawnSync(process.execPath, ['--test', '--test-reporter=spec', path.join(here, `${name}.test.mjs`)], { stdio: 'inherit' }).status ?? 1);
