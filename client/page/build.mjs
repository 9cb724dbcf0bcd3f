// Builds the page into dist/: index.html and docs.html, and the files that they load, in page/. File names are
// constant: the server sends strong ETags, so a browser revalidates a file and gets 304.
//
//   node build.mjs           builds once, minified; prints the size of each load
//   node build.mjs --watch   builds again after each change, not minified
import { build, context } from 'esbuild';
import { createHash } from 'node:crypto';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { documents } from './documents.mjs';

const here = path.dirname(fileURLToPath(import.meta.url)), dist = path.join(here, 'dist'), watch = process.argv.includes('--watch');
const at = (...parts) => path.join(here, ...parts);

/** Returns an identifier for the page's sources. Files that are loaded later use it to check that they belong to the
 * open page. */
function buildOf() {
  const hash = createHash('sha256'), add = folder => {
    for (const entry of fs.readdirSync(folder, { withFileTypes: true }).sort((a, b) => (a.name < b.name ? -1 : 1))) {
      const file = path.join(folder, entry.name);
      if (entry.isDirectory()) add(file);
      else hash.update(fs.readFileSync(file));
    }
  };
  add(at('src'));
  add(at('../typescript/src'));
  return hash.update(fs.readFileSync(at('package-lock.json'))).digest('hex').slice(0, 16);
}

const options = {
  define: { BUILD: JSON.stringify(buildOf()) },
  absWorkingDir: here,
  entryPoints: {
    app: 'src/main.ts', play: 'src/play/play.ts', docs: 'src/docs/docs.ts', style: 'style/style.css',
  },
  outdir: 'dist/page', bundle: true, splitting: true, format: 'esm', target: 'es2022', minify: !watch, charset: 'utf8',
  legalComments: 'none', metafile: true, chunkNames: 'chunk-[hash]', logLevel: 'warning', tsconfig: 'tsconfig.json',
  alias: {
    'fracture-client': at('../typescript/src/index.ts'), 'fracture-client/three': at('../typescript/src/three/index.ts'),
    'three/addons': at('node_modules/three/examples/jsm'), three: at('node_modules/three/build/three.module.js'),
  },
};

/** Gives the chunks that several entries share the same names in every build. */
function nameChunks() {
  const folder = path.join(dist, 'page'), chunks = fs.readdirSync(folder).filter(name => /^chunk-.*\.js$/.test(name));
  const sized = chunks.map(name => ({ name, size: fs.statSync(path.join(folder, name)).size })).sort((a, b) => b.size - a.size);
  const names = new Map(sized.map(({ name }, k) => [name, k === 0 ? 'shared.js' : `shared${k + 1}.js`]));
  for (const name of fs.readdirSync(folder).filter(name => name.endsWith('.js'))) {
    let text = fs.readFileSync(path.join(folder, name), 'utf8');
    for (const [from, to] of names) text = text.replaceAll(`./${from}`, `./${to}`);
    fs.writeFileSync(path.join(folder, name), text);
  }
  for (const [from, to] of names) fs.renameSync(path.join(folder, from), path.join(folder, to));
}

/** Returns the total size of the files as transferred, compressed with gzip. */
const packed = (...files) => files.reduce((sum, file) => sum + gzipSync(fs.readFileSync(path.join(dist, file)), { level: 9 }).length, 0);

/** Returns the licence texts of the bundled packages, which the licences require. */
function licences() {
  const packages = ['three', 'lit', 'lit-html', 'lit-element', '@lit/reactive-element', '@dimforge/rapier3d-compat'];
  return packages.map(name => {
    const folder = at('node_modules', name), file = fs.readdirSync(folder).find(each => /^licen[cs]e/i.test(each));
    const { version, license } = JSON.parse(fs.readFileSync(path.join(folder, 'package.json'), 'utf8'));
    // Rapier's package names its licence, but lacks the text. All packages with this licence have the same text.
    const text = file ? path.join(folder, file) : license === 'Apache-2.0' ? at('node_modules/typescript/LICENSE.txt') : undefined;
    if (!text) throw new Error(`The licence of ${name} is missing.`);
    return `${name} ${version} (${license})\n\n${fs.readFileSync(text, 'utf8').trim()}\n`;
  }).join(`\n${'-'.repeat(80)}\n\n`);
}

function finish() {
  if (!watch) nameChunks();
  for (const [name, script] of [['index.html', 'app.js'], ['docs.html', 'docs.js']]) {
    // The browser requests the script's imports together with the script, not after it.
    const imported = new Set([...fs.readFileSync(path.join(dist, 'page', script), 'utf8').matchAll(/["']\.\/((?:shared|chunk-)[^"']*\.js)["']/g)].map(([, file]) => file));
    const links = [...imported].map(file => `<link rel="modulepreload" href="/page/${file}">\n`).join('');
    fs.writeFileSync(path.join(dist, name), fs.readFileSync(at(name), 'utf8').replace('<script type="module"', `${links}<script type="module"`));
  }
  fs.copyFileSync(at('style/icon.svg'), path.join(dist, 'page/icon.svg'));
  fs.writeFileSync(path.join(dist, 'page/licences.txt'), licences());
  fs.writeFileSync(path.join(dist, 'page/documents.json'), JSON.stringify(documents(at('../..'))));
}

fs.rmSync(dist, { recursive: true, force: true });
fs.mkdirSync(path.join(dist, 'page'), { recursive: true });
if (watch) {
  const running = await context({ ...options, plugins: [{ name: 'finish', setup: ({ onEnd }) => onEnd(finish) }] });
  await running.watch();
} else {
  await build(options);
  finish();
  const files = fs.readdirSync(path.join(dist, 'page')).map(name => `page/${name}`);
  for (const file of ['index.html', 'docs.html', ...files]) console.log(`${String(packed(file)).padStart(8)}  ${file}`);
  const shared = files.filter(file => /shared\d*\.js$/.test(file));
  const first = packed('index.html', 'page/app.js', 'page/style.css', 'page/icon.svg', ...shared), physics = packed('page/play.js');
  // The interface description from the server adds about 20 kB to these 130 kB.
  const imported = files.filter(file => fs.readFileSync(path.join(dist, 'docs.html'), 'utf8').includes(`/${file}"`));
  const docs = packed('docs.html', 'page/documents.json', ...imported);
  console.log(`first load ${first} of 500000 bytes, physics ${physics} of 1300000, documents ${docs} of 130000`);
  if (first > 500_000 || physics > 1_300_000 || docs > 130_000) throw new Error('The page exceeds its size limit.');
}
