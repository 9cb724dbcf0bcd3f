// The documents at /docs, without a browser: what the build makes of the Markdown, what the search ranks first, what addresses mean.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { describe, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { gzipSync } from 'node:zlib';
import { dist, folder, require, source } from './support.mjs';

const root = path.resolve(folder, '../..'), read = file => fs.readFileSync(path.join(root, file), 'utf8');
const { anchorOf, documents, listed, rendered } = await import(pathToFileURL(path.join(folder, 'documents.mjs')));
const { entriesOf, headingsOf, shownOf, textOf, search, excerptOf, partsOf, placeOf, documentOf } = await source('docs/documents', 'docs/search', 'docs/places');

describe('Markdown', () => {
  const known = new Set(['a/b.md', 'a/c.md', 'README.md']), html = text => rendered('a/b.md', text, known).html;

  test('HeadingsHaveTheAnchorsOfGitHub', () => {
    const seen = new Map();
    assert.deepEqual(['Fracture (exact) for Blender', '`bake`, inspect and health', '1. Make tokens', 'Größe_x', 'Limits', 'Limits', 'Limits-1', 'Limits'].map(text => anchorOf(text, seen)),
      ['fracture-exact-for-blender', 'bake-inspect-and-health', '1-make-tokens', 'größe_x', 'limits', 'limits-1', 'limits-1-1', 'limits-2']);
    assert.equal(html('## The `x` & [c](c.md)'), '<h2 id="a/b.md:the-x--c">The <code>x</code> &amp; <a href="#a/c.md">c</a></h2>');
    assert.equal(rendered('a/b.md', "# Don't `stop` & go\n\n## Later", known).title, "Don't stop & go");
  });
  test('LinksLeadToDocumentsAndSourcesAreNamed', () => {
    assert.equal(html('[x](c.md)'), '<p><a href="#a/c.md">x</a></p>');
    assert.equal(html('[x](../README.md#three-tasks)'), '<p><a href="#README.md:three-tasks">x</a></p>');
    assert.equal(html('[x](#here)'), '<p><a href="#a/b.md:here">x</a></p>');
    assert.equal(html('[the interface](../proto/openapi.yaml)'), '<p><a href="#interface">the interface</a></p>');
    assert.equal(html('[common](../common/README.md#glossary)'), '<p>common (<code>common/README.md</code>)</p>');
    assert.equal(html('[`d.hpp`](../x/d.hpp)'), '<p><code>x/d.hpp</code></p>');
    assert.equal(html('[y](https://example.org/?a=1&b=2)'), '<p><a href="https://example.org/?a=1&amp;b=2" rel="noopener">y</a></p>');
    assert.equal(html('Open http://127.0.0.1:8080.'), '<p>Open http://127.0.0.1:8080.</p>');
  });
  test('PicturesAreLeftOutAndColumnsOfThem', () => {
    assert.deepEqual(rendered('a/b.md', 'a\n\n![p](p.png)\n\nb', known), { title: '', html: '<p>a</p>\n<p>b</p>', pictures: true });
    assert.equal(rendered('a/b.md', '| | n |\n|---|---|\n| ![p](p.png) | 1 |\n| | 2 |', known).html.replaceAll('\n', ''),
      '<div class="table"><table><thead><tr><th>n</th></tr></thead><tbody><tr><td>1</td></tr><tr><td>2</td></tr></tbody></table></div>');
    assert.equal(rendered('a/b.md', '| | |\n|---|---|\n| ![p](p.png) | ![q](q.png) |', known).html, '');
    assert.match(html('| | n |\n|---|---|\n| | 2 |'), /<th><\/th>/, 'a column that is only empty stays');
    assert.equal(rendered('a/b.md', 'a', known).pictures, false);
  });
  test('NothingButMarkdownGetsThrough', () => {
    assert.equal(html('a <!-- b -->'), '<p>a </p>');
    assert.equal(html('<!-- a\nb -->\n\nc'), '<p>c</p>');
    for (const text of ['<script>1</script>', 'a <b onclick="x">c</b>', '<!-- a --><img src=x><!-- b -->', '<div style="top:0">a</div>', '[x](javascript:1)', '[x](JaVaScript:1)', '[x](data:text/html,1)'])
      assert.throws(() => html(text), /a\/b\.md/, text);
    assert.equal(html('`<b>`\n\n    <i>&'), '<p><code>&lt;b&gt;</code></p>\n<pre><code>&lt;i&gt;&amp;</code></pre>');
  });
});

describe('the documents', () => {
  const all = documents(root), paths = all.map(each => each.path);

  test('AreAllOfThem', () => {
    const markdown = place => fs.readdirSync(path.join(root, place)).filter(name => name.endsWith('.md')).map(name => path.posix.join(place, name));
    const inFolders = place => fs.readdirSync(path.join(root, place)).map(name => `${place}/${name}/README.md`).filter(file => fs.existsSync(path.join(root, file)));
    assert.deepEqual([...paths].sort(), ['README.md', 'CHANGELOG.md', 'server/README.md', 'server/bake/README.md', 'docker/README.md', ...markdown('proto'), ...markdown('proto/guides'),
      ...markdown('client'), ...inFolders('client')].sort());
    assert.deepEqual([...new Set(all.map(({ kind }) => kind))], ['tutorial', 'how-to', 'reference', 'explanation']);
    assert.equal(all.filter(({ name }) => name === '').length, 0);
  });
  test('LeadOnlyToPlacesThatExist', () => {
    const places = new Set(['interface', ...paths, ...all.flatMap(({ html }) => [...html.matchAll(/ id="([^"]+)"/g)].map(([, id]) => id))]);
    for (const { path: file, html } of all) for (const [, to] of html.matchAll(/ href="#([^"]*)"/g)) assert.ok(places.has(to), `${file} links to #${to}`);
  });
  test('ObeyThePolicyOfThePage', () => {
    for (const { path: file, html } of all) assert.doesNotMatch(html, /<(?:script|style|img|iframe|object)\b| (?:style|on\w+)=/, file);
  });
  test('AreInTheContainersBuild', () => {
    const copied = [...read('docker/Dockerfile').split('AS test')[0].matchAll(/^COPY (.+) \S+$/gm)].flatMap(([, from]) => from.split(' '));
    const kept = read('docker/Dockerfile.dockerignore').split('\n').filter(line => line.startsWith('!')).map(line => line.slice(1));
    const covers = (pattern, file) => file === pattern || file.startsWith(`${pattern}/`) || new RegExp(`^${pattern.replaceAll('.', '\\.').replaceAll('*', '[^/]*')}$`).test(file);
    for (const file of paths) {
      assert.ok(copied.some(pattern => covers(pattern, file)), `docker/Dockerfile copies ${file}`);
      assert.ok(kept.some(pattern => covers(pattern, file)), `docker/Dockerfile.dockerignore keeps ${file}`);
    }
  });
  test('RebuildThePage', () => {
    const globs = [.../file\(GLOB page_documents([^)]*)\)/.exec(read('server/CMakeLists.txt'))[1].matchAll(/\$\{CMAKE_SOURCE_DIR\}\/(\S+)/g)].map(([, glob]) => glob);
    for (const file of paths) assert.ok(globs.some(glob => new RegExp(`^${glob.replaceAll('.', '\\.').replaceAll('*', '[^/]*')}$`).test(file)), file);
  });
  test('WeighAtMost150kBWithAllThatThePageLoads', () => {
    const html = fs.readFileSync(path.join(dist, 'docs.html'), 'utf8'), files = ['docs.html', 'page/documents.json', ...[...html.matchAll(/"\/(page\/[^"]+)"/g)].map(([, file]) => file)];
    assert.ok(files.includes('page/docs.js') && files.includes('page/style.css'));
    const own = files.map(file => fs.readFileSync(path.join(dist, file))), served = JSON.stringify(require('yaml').parse(read('proto/openapi.yaml')));
    const weight = [...own, served].reduce((sum, bytes) => sum + gzipSync(bytes, { level: 9 }).length, 0);
    console.log(`/docs weighs ${weight} bytes`);
    assert.ok(weight <= 150_000, `${weight} bytes`);
  });
  test('AreFoundByTheirSubject', () => {
    const entries = all.flatMap(entriesOf), first = query => search(entries, query)[0]?.entry.at;
    assert.equal(first('install'), 'proto/guides/install.md');
    assert.equal(first('exactly n pieces'), 'proto/guides/exact-number-of-pieces.md');
    assert.match(first('exit codes'), /:exit-codes$/);
    assert.equal(first('upgrade farm'), 'proto/guides/upgrade-a-farm.md');
    assert.equal(first('godot'), 'client/ENGINES.md:godot-4');
  });
});

describe('a document in the page', () => {
  const page = { path: 'a.md', kind: 'reference', name: 'A', pictures: false, ...rendered('a.md', '# Alpha\n\nfirst `one`s\n\n## Beta & more\n\n| x | y |\n|---|---|\n| 1 | 2 |\n\n## See [it](#beta--more)\n\nlast', new Set(['a.md'])) };

  test('IsTextInSections', () => {
    assert.deepEqual(entriesOf(page), [
      { at: 'a.md', of: 'A', title: 'A', heading: '', text: 'first ones' },
      { at: 'a.md:beta--more', of: 'A', title: '', heading: 'Beta & more', text: 'x y 1 2' },
      { at: 'a.md:see-it', of: 'A', title: '', heading: 'See it', text: 'last' },
    ]);
    assert.deepEqual(headingsOf(page).map(({ level, text }) => `${level} ${text}`), ['1 Alpha', '2 Beta & more', '2 See it']);
    assert.equal(textOf('<p>&lt;b&gt; &amp;lt; it&#39;s</p>'), "<b> &lt; it's");
  });
  test('HasHeadingsThatLinkToThemselves', () => {
    const html = shownOf(page);
    assert.match(html, /<h2 id="a\.md:beta--more"><a href="#a\.md:beta--more">Beta &amp; more<\/a><\/h2>/);
    assert.match(html, /<h2 id="a\.md:see-it">See <a href="#a\.md:beta--more">it<\/a><\/h2>/, 'no link in a link');
    assert.match(html, /<h1 id="a\.md:alpha">Alpha<\/h1>/);
  });
});

describe('the search', () => {
  const entry = (at, { of = '', title = '', heading = '', text = '' }) => ({ at, of, title, heading, text });
  const found = (entries, query) => search(entries, query).map(({ entry: { at } }) => at);

  test('PutsTitlesBeforeHeadingsAndHeadingsBeforeText', () => {
    const entries = [entry('text', { text: 'token token token' }), entry('inside a heading', { heading: 'Retokenise' }), entry('heading', { heading: 'Token' }), entry('title', { title: 'Mytokens' }),
      entry('none', { text: 'taken' }), entry('part of a document', { of: 'Token', text: 'else' })];
    assert.deepEqual(found(entries, 'TOKEN'), ['title', 'heading', 'inside a heading', 'text', 'part of a document']);
  });
  test('PutsWordsBeforeBeginningsAndBeginningsBeforeTheRest', () => {
    assert.deepEqual(found([entry('rest', { text: 'rebake' }), entry('beginning', { text: 'baked' }), entry('word', { text: 'to bake.' })], 'bake'), ['word', 'beginning', 'rest']);
    assert.deepEqual(found([entry('longer', { title: 'local_radius' }), entry('it', { title: 'radius' })], 'radius'), ['it', 'longer']);
  });
  test('FindsAllWordsOrNothing', () => {
    const entries = [entry('one', { heading: 'Windows', text: 'of a house' }), entry('both', { of: 'Bake many meshes', heading: 'On Windows' })];
    assert.deepEqual(found(entries, 'bake windows'), ['both']);
    assert.deepEqual(found(entries, 'bake linux'), []);
    assert.deepEqual(found(entries, '  '), []);
    assert.deepEqual(found([entry('apart', { text: 'exit of codes' }), entry('together', { text: 'the exit codes' })], 'exit codes'), ['together', 'apart']);
  });
  test('TakesWhatPeopleTypeAsText', () => {
    for (const query of ['(', '[a', '.*', '\\', '--max-body', '$&']) assert.deepEqual(found([entry('it', { text: `x ${query} y` }), entry('other', { text: 'z' })], query), ['it'], query);
    assert.deepEqual(partsOf('a.b aXb', 'a.b'), ['', 'a.b', ' aXb']);
  });
  test('ShowsTheTextAroundTheFirstWord', () => {
    const text = `${'before '.repeat(30)}Needle ${'after '.repeat(60)}`.trim(), parts = excerptOf(text, 'needle');
    assert.equal(parts[1], 'Needle');
    assert.match(parts[0], /^… (?:before )+$/);
    assert.match(parts[2], /^(?: after)+ …$/);
    assert.ok(parts.join('').length < 160);
    assert.deepEqual(excerptOf('short text', 'none'), ['short text']);
  });
});

test('AddressesNamePlaces', () => {
  const paths = ['README.md', 'proto/interface.md'];
  for (const [hash, place, document] of [['', '', 'README.md'], ['#proto/interface.md', 'proto/interface.md', 'proto/interface.md'], ['#proto/interface.md:jobs', 'proto/interface.md:jobs', 'proto/interface.md'],
    ['#interface', 'interface', 'interface'], ['#parameters', 'parameters', 'interface'], ['#post%20/fracture', 'post /fracture', 'interface'], ['#parameter%20seed', 'parameter seed', 'interface'],
    ['#none.md', 'none.md', 'README.md'], ['#%', '', 'README.md']]) {
    assert.equal(placeOf(hash), place);
    assert.equal(documentOf(place, paths), document, hash);
  }
  assert.equal(documentOf('', []), 'interface', 'without documents the interface is there');
  assert.ok(Object.values(listed(root)).flat().includes('proto/interface.md'));
});
