// The parts of the page that need no browser: which answer wins, undo and redo, lists as people write them, links, presets.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { source } from './support.mjs';

const { Asker, Gestures, History, parseNumbers, textOf, readLink, trianglesOf, samples, parametersOf, meshesOf, underPattern, placesIn, withoutPlaces, firstPlace, withoutPlace,
  handlesOf, found, presetOf, readPreset, countRemark, remarkLists, withChoice, choiceButtons, Ray, Vector3 } = await source('service/asker', 'state/request', 'panels/lists', 'take/link', 'mesh/preview', 'mesh/samples', 'mesh/files',
  'state/places', 'scene/gizmos', 'take/presets', 'panels/remarks', 'panels/choices', 'panels/finding', '../node_modules/three/src/math/Ray.js', '../node_modules/three/src/math/Vector3.js');

describe('Asker', () => {
  /** An Asker whose questions are answered when the test says so. */
  function asker() {
    const open = new Map(), shown = [], failed = [];
    const made = new Asker((question, signal) => new Promise((resolve, reject) => {
      open.set(question, { resolve: () => resolve(question), reject });
      signal.addEventListener('abort', () => (open.delete(question), reject(new DOMException('', 'AbortError'))));
    }), answer => shown.push(answer), (_, question) => failed.push(question), () => {});
    const answer = async question => {
      open.get(question).resolve();
      open.delete(question);
      await new Promise(resolve => setImmediate(resolve));
    };
    return { made, open, shown, failed, answer };
  }

  test('TwoAtATimeAndTheNewestWaits', async () => {
    const { made, open, shown, answer } = asker();
    for (let k = 1; k <= 9; ++k) made.put(k, false);
    assert.deepEqual([...open.keys()], [1, 2]);
    await answer(1);
    assert.deepEqual([...open.keys()], [2, 9]);
    await answer(2);
    await answer(9);
    assert.deepEqual(shown, [1, 2, 9]);
  });
  test('AnOlderAnswerIsTakenBackByANewerOne', async () => {
    const { made, open, shown, answer } = asker();
    made.put(1, false);
    made.put(2, false);
    await answer(2);
    assert.deepEqual([...open.keys()], []);
    assert.deepEqual(shown, [2]);
  });
  test('TheEndOfADragTakesBackAllThatIsOlder', async () => {
    const { made, open, shown, answer } = asker();
    made.put(1, false);
    made.put(2, false);
    made.put(3, true);
    assert.deepEqual([...open.keys()], [3]);
    await answer(3);
    assert.deepEqual(shown, [3]);
  });
  test('OnlyTheNewestFailureIsSaid', async () => {
    const { made, open, failed } = asker();
    made.put(1, false);
    made.put(2, false);
    open.get(1).reject(new Error('one'));
    open.get(2).reject(new Error('two'));
    await new Promise(resolve => setImmediate(resolve));
    assert.deepEqual(failed, [2]);
  });
  test('CancelledMeansNothingIsShown', async () => {
    const { made, shown, failed } = asker();
    made.put(1);
    made.cancel();
    await new Promise(resolve => setImmediate(resolve));
    assert.deepEqual([shown, failed, made.busy], [[], [], false]);
  });
});

describe('Gestures', () => {
  test('ADragIsOneHoweverLongItTakes', () => {
    const gestures = new Gestures(), first = gestures.of('keep_radius', false, 0);
    assert.equal(gestures.of('keep_radius', false, 60_000), first);
    assert.equal(gestures.of('keep_radius', true, 120_000), first);
    assert.notEqual(gestures.of('keep_radius', false, 180_000), first, 'it was let go');
  });
  test('WhatFollowsAtOnceOnTheSameThingBelongsToIt', () => {
    const gestures = new Gestures(), first = gestures.of('sites', true, 0);
    assert.equal(gestures.of('sites', true, 500), first);
    assert.equal(gestures.of('sites', true, 1000), first);
    assert.notEqual(gestures.of('sites', true, 2500), first);
  });
  test('AKeyThatIsLetGoIsOver', () => {
    const gestures = new Gestures(), first = gestures.of('sites', false, 0);
    gestures.letGo();
    assert.equal(gestures.of('sites', false, 500), first);
    gestures.letGo();
    assert.notEqual(gestures.of('sites', false, 5000), first);
  });
  test('AnotherThingIsAnother', () => {
    const gestures = new Gestures(), first = gestures.of('sites', false, 0), second = gestures.of('seed', false, 1);
    assert.notEqual(second, first);
    assert.equal(new Set([first, second, gestures.of('sites', true, 2), gestures.of('', true, 3), gestures.of('', true, 3)]).size, 5);
  });
});

describe('History', () => {
  const step = (value, gesture) => ({ settings: { value }, hits: [], answer: undefined, gesture });
  test('OneDragIsOneStep', () => {
    const history = new History();
    history.push(step(0, 1));
    for (let k = 1; k <= 5; ++k) history.push(step(k, 2));
    assert.equal(history.move(-1).settings.value, 0);
    assert.equal(history.move(1).settings.value, 5);
    assert.equal(history.move(1), undefined);
  });
  test('ANewStepForgetsWhatWasUndone', () => {
    const history = new History();
    for (const k of [0, 1, 2]) history.push(step(k, k));
    history.move(-1);
    history.push(step(7, 7));
    assert.equal(history.canRedo, false);
    assert.equal(history.move(-1).settings.value, 1);
  });
  test('TheFirstStepIsNeverReplaced', () => {
    const history = new History();
    history.push(step(0, 1));
    history.push(step(1, 1));
    assert.equal(history.move(-1).settings.value, 0);
  });
});

describe('what an answer says about itself', () => {
  const hit = { point: [0, 0, 0], radius: 1 };
  const shown = ({ asked, made, hits = [], report = {}, certificate = {}, parameters = {} }) => ({
    answer: { parameters: asked === undefined ? {} : { fragments: asked, ...parameters }, fragments: Array(made).fill({}), report, certificate }, wish: { hits },
  });
  /** The values in a lit template and in nested ones, in their order. */
  const textsOf = value => (Array.isArray(value) ? value.flatMap(textsOf) : value?.values ? textsOf(value.values) : ['string', 'number'].includes(typeof value) ? [String(value)] : []);

  test('AsManyAsWereAskedForAreNoNews', () => {
    for (const same of [{ asked: 40, made: 40 }, { asked: 40, made: 40, hits: [hit] }, { asked: 0, made: 105 }, { made: 105 }]) assert.equal(countRemark(shown(same)), undefined);
  });
  test('MoreAreOfTheHits', () => {
    assert.equal(countRemark(shown({ asked: 40, made: 108, hits: [hit, hit] })), '40 requested, 108 made: 2 hits broke off additional pieces.');
    assert.match(countRemark(shown({ asked: 40, made: 52, hits: [hit] })), /: the hit broke off additional pieces/);
    assert.equal(countRemark(shown({ asked: 40, made: 35, hits: [hit] })), '40 requested, 35 made.', 'fewer are not');
  });
  test('FarOffTheFiguresSayWhy', () => {
    const parts = number => ({ size: { parts: number, united: 3 } });
    assert.equal(countRemark(shown({ asked: 1200, made: 1900, report: parts(1900) })), '1,200 requested, 1,900 made: the mesh has 1,900 separate parts, and each becomes at least one fragment.');
    assert.match(countRemark(shown({ asked: 40, made: 60, report: parts(2) })), /: the extra fragments touch no fragment/);
    assert.match(countRemark(shown({ asked: 40, made: 30, report: parts(1) })), /: the pattern and the size limits/);
    assert.match(countRemark(shown({ asked: 40, made: 30, report: parts(1), certificate: { united: 4 } })), /: the surface crosses itself/);
    assert.match(countRemark(shown({ asked: 60, made: 50, report: parts(1), parameters: { max_fragments: 50 } })), /: the maximum number of fragments is lower/);
    assert.match(countRemark(shown({ asked: 40, made: 37 })), /^40 requested, 37 made: the number can differ/);
  });
  test('NoSentenceOfTheServerDecides', () => {
    const warnings = ['1,200 fragments were asked for, and 1,900 were made, because of something new'];
    assert.match(countRemark(shown({ asked: 1200, made: 1900, report: { size: { parts: 1900 }, warnings } })), /1,900 separate parts/);
  });
  test('WarningsAndNotesAreShownApart', () => {
    const shownTexts = (warnings, notes, dropped) => textsOf(remarkLists(warnings, notes, dropped));
    assert.deepEqual(shownTexts([], []), []);
    assert.deepEqual(shownTexts(['to do'], []), ['Warnings', 'to do']);
    assert.deepEqual(shownTexts([], ['done', 'done too']), ['Notes', '2', 'done', 'done too']);
    assert.deepEqual(shownTexts(['to do'], ['done']), ['Warnings', 'to do', 'Notes', '1', 'done']);
    assert.deepEqual(shownTexts([], ['done'], [{ what: 'light', name: 'Lamp', reason: 'why' }, { what: 'joints', name: '', reason: 'cut' }]),
      ['Dropped from the source', '2', 'light Lamp: why', 'joints: cut', 'Notes', '1', 'done']);
  });
  test('AChoiceIsAButtonThatAddsItsParameters', () => {
    const wall = { kind: 'room', parameters: { thickness: 0.04 }, text: 'It is a room.' }, unit = { kind: 'unit', parameters: { unit: 'mm' }, text: 'It is large.' };
    const wish = { settings: { sites: 5 }, hits: [{ point: [1, 2, 3], radius: 0.1 }] };
    assert.deepEqual(withChoice(wish, wall), { settings: { sites: 5, thickness: 0.04 }, hits: wish.hits });
    assert.deepEqual(withChoice(wish, unit), { settings: { sites: 5, unit: 'mm' }, hits: [] }, 'the mesh is elsewhere then');
    const asked = [], app = { state: { wish }, breaking: { wishFor: (...all) => asked.push(all) } };
    assert.deepEqual(textsOf(choiceButtons(app, [])), []);
    assert.deepEqual(textsOf(choiceButtons(app, [wall])), ['Your choice', 'It is a room.', 'Try thickness 0.04']);
  });
});

test('ListsAsPeopleWriteThem', () => {
  assert.deepEqual(parseNumbers('1, 2 3', 'x,y,z'), [1, 2, 3]);
  assert.deepEqual(parseNumbers('1,2,3;4,5,6', 'x,y,z;x,y,z'), [[1, 2, 3], [4, 5, 6]]);
  assert.equal(parseNumbers('1,two', 'x,y,z'), null);
  assert.equal(textOf([[1, 2, 3], [4, 5, 6]]), '1,2,3;4,5,6');
});

test('LinksThatAreNoneAreNotFollowed', () => {
  assert.equal(readLink(''), undefined);
  assert.equal(readLink('#mesh=nonsense'), undefined);
  assert.equal(readLink('#sample=cube&set=nonsense'), undefined);
  assert.deepEqual(readLink('#sample=cube&set={"sites":3}&hits=[[1,2,3,0.5],["x"]]').wish, { settings: { sites: 3 }, hits: [{ point: [1, 2, 3], radius: 0.5 }] });
});

test('HitsBecomeParameters', () => {
  assert.deepEqual(parametersOf({ settings: { sites: 5 }, hits: [{ point: [1, 2, 3], radius: 0.1 }] }),
    { sites: 5, local_point: [[1, 2, 3]], local_radius: [0.1], local_rest: 'fractured' });
});

test('TheSitesOfAHitAreGivenToAllHitsIfOneHasThem', () => {
  const hits = [{ point: [1, 2, 3], radius: 0.1 }, { point: [4, 5, 6], radius: 0.2, sites: 80 }];
  assert.deepEqual(parametersOf({ settings: {}, hits }).local_sites, [30, 80]);
  assert.deepEqual(readLink('#sample=cube&hits=[[1,2,3,0.5,80]]').wish.hits, [{ point: [1, 2, 3], radius: 0.5, sites: 80 }]);
});

describe('search', () => {
  const parameters = [
    { name: 'radius', description: 'Radius of the area with pieces.' }, { name: 'fragments', description: 'Number of fragments.', synonyms: ['pieces', 'shards'] },
    { name: 'rough_amplitude', description: 'How far noise moves cut faces.', synonyms: ['jagged'] },
  ];
  const names = search => found(parameters, search).map(({ name }) => name);
  test('ASynonymComesBeforeADescription', () => assert.deepEqual(names('pieces'), ['fragments', 'radius']));
  test('EveryWordMustOccurInAnyOrder', () => assert.deepEqual([names('noise rough'), names('noise pieces')], [['rough_amplitude'], []]));
  test('SpacesAreUnderscores', () => assert.deepEqual(names('Rough Amp'), ['rough_amplitude']));
});

/** Some parameters as /limits describes them. */
const PARAMETERS = [
  { name: 'grain', type: 'array', text: 'x,y,z' }, { name: 'gravity', type: 'array', text: 'x,y,z', unit: 'm/s²' }, { name: 'cell', type: 'array', text: 'x,y,z', unit: 'm', patterns: ['grid'] },
  { name: 'impacts', type: 'array', text: 'x,y,z;x,y,z', unit: 'm', patterns: ['impact'] }, { name: 'normals', type: 'array', text: 'x,y,z;x,y,z', patterns: ['slice'] },
  { name: 'keep_center', type: 'array', text: 'x,y,z', unit: 'm' }, { name: 'keep_radius', type: 'number', unit: 'm' }, { name: 'keep_box', type: 'array', text: 'x,y,z;x,y,z', unit: 'm' },
  { name: 'anchor_plane', type: 'array', text: 'x,y,z;x,y,z' }, { name: 'local_point', type: 'array', text: 'x,y,z;x,y,z', unit: 'm' },
  { name: 'local_radius', type: 'array', text: 'a,b,c', unit: 'm' }, { name: 'fragments', type: 'integer' }, { name: 'stretch', type: 'number' },
];

describe('places', () => {
  const places = placesIn(PARAMETERS);

  test('AreKnownByWhatTheServerSaysOfThem', () => {
    assert.deepEqual([...places], [['grain', 'direction'], ['normals', 'normals'], ['keep_center', 'sphere'], ['keep_box', 'box'], ['anchor_plane', 'plane']]);
  });
  test('AreOfOneMeshAndDirectionsAreOfAll', () => {
    const settings = { fragments: 9, grain: [0, 1, 0], keep_center: [1, 2, 3], keep_radius: 0.5, anchor_plane: [[0, 0, 0], [0, 1, 0]], local_point: [[0, 0, 0]], local_radius: [1], cell: [1, 1, 1] };
    assert.deepEqual(withoutPlaces(settings, PARAMETERS), { fragments: 9, grain: [0, 1, 0] });
  });
  test('BeginInTheMeshAndGoAsTheyCame', () => {
    const bounds = { low: [-1, 0, -1], high: [1, 2, 1] };
    for (const [name, kind] of places) {
      const settings = firstPlace(name, kind, bounds, undefined);
      assert.ok(handlesOf(settings, places, { middle: new Vector3(0, 1, 0), size: Math.sqrt(12) }).length > 0, name);
      assert.deepEqual(withoutPlace({ fragments: 9, ...settings }, name), { fragments: 9 });
    }
    assert.deepEqual(firstPlace('anchor_plane', 'plane', bounds, undefined), { anchor_plane: [[0, 0, 0], [0, 1, 0]] });
    assert.deepEqual(firstPlace('grain', 'direction', bounds, [1, 0, 0]), { grain: [1, 0, 0] });
  });

  // A camera that looks along -z at a mesh around (0, 0, 0) with a diagonal of 2.
  const facing = new Vector3(0, 0, -1), extent = { middle: new Vector3(), size: 2 };
  const drag = (settings, key, x, y) => handlesOf(settings, places, extent).find(handle => handle.key === key).drag(new Ray(new Vector3(x, y, 10), facing), facing);

  test('ASphereFollowsItsMiddleAndReachesToThePointer', () => {
    const sphere = { keep_center: [0.25, 0, 0.5], keep_radius: 0.25 };
    assert.deepEqual(drag(sphere, 'keep_center middle', 0.5, -0.25), { keep_center: [0.5, -0.25, 0.5] });
    assert.deepEqual(drag(sphere, 'keep_center radius', 0.25, 0.75), { keep_radius: 0.75 });
    assert.deepEqual(drag(sphere, 'keep_center radius', 0.25, 0), { keep_radius: 0.02 }, 'it is never nothing');
  });
  test('ABoxMovesAndItsFacesStopBeforeOneAnother', () => {
    const box = { keep_box: [[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]] };
    assert.deepEqual(drag(box, 'keep_box middle', 0.25, 0.125), { keep_box: [[-0.25, -0.375, -0.5], [0.75, 0.625, 0.5]] });
    assert.deepEqual(drag(box, 'keep_box 11', 0.3, 0.75), { keep_box: [[-0.5, -0.5, -0.5], [0.5, 0.75, 0.5]] }, 'only along its axis');
    assert.deepEqual(drag(box, 'keep_box 00', 0.9, 0), { keep_box: [[0.49, -0.5, -0.5], [0.5, 0.5, 0.5]] });
    assert.deepEqual(drag(box, 'keep_box 21', 0.3, 0.3), box, 'an axis that points at the eye says nothing');
  });
  test('APlaneMovesAlongItsNormalAndTurns', () => {
    const plane = { anchor_plane: [[7, -0.5, 7], [0, 2, 0]] };
    assert.deepEqual(drag(plane, 'anchor_plane middle', 0.3, 0.25), { anchor_plane: [[0, 0.25, 0], [0, 2, 0]] });
    assert.deepEqual(drag(plane, 'anchor_plane normal', 5, -0.5), { anchor_plane: [[0, -0.5, 0], [1, 0, 0]] });
  });
  test('ADirectionPointsToThePointerAndStaysOnItsSide', () => {
    assert.deepEqual(drag({ grain: [0, 1, 0] }, 'grain', 3, 0), { grain: [1, 0, 0] });
    assert.deepEqual(drag({ grain: [0, 0, 1] }, 'grain', 0, 0), { grain: [0, 0, 1] });
    assert.deepEqual(drag({ grain: [0, 0, -1] }, 'grain', 0, 0), { grain: [0, 0, -1] });
    assert.deepEqual(drag({ normals: [[0, 1, 0], [1, 0, 0]] }, 'normals 1', 0, -9), { normals: [[0, 1, 0], [0, -1, 0]] });
  });
});

test('AnotherPatternKeepsWhatItKnowsAndMakesHitsOfImpacts', () => {
  const wish = { settings: { fragments: 9, impacts: [[1, 2, 3]], grain: [0, 1, 0] }, hits: [{ point: [4, 5, 6], radius: 1 }] };
  assert.deepEqual(underPattern(wish, 'impact', PARAMETERS, 0.5), wish);
  assert.deepEqual(underPattern({ ...wish, settings: { ...wish.settings, normals: [[0, 1, 0]] } }, 'uniform', PARAMETERS, 0.5),
    { settings: { fragments: 9, grain: [0, 1, 0] }, hits: [{ point: [1, 2, 3], radius: 0.5 }, { point: [4, 5, 6], radius: 1 }] });
});

test('APresetIsReadAgainWithoutPlacesAndNothingElseIsOne', () => {
  const wished = [], problems = [], service = { parameters: PARAMETERS, knowledge: { version: { algorithm: 14 } } };
  const app = { state: { wish: { settings: { material: 'stone', fragments: 9, keep_center: [1, 2, 3], keep_radius: 1 }, hits: [{ point: [0, 0, 0], radius: 1 }] } }, service,
    breaking: { wishFor: wish => wished.push(wish) }, set: ({ problem }) => problems.push(problem.title) };
  readPreset(app, presetOf(app));
  assert.deepEqual(wished, [{ settings: { material: 'stone', fragments: 9 }, hits: [] }]);
  for (const text of ['', 'nonsense', '[]', 'null', '{"parameters":{"fragments":9}}', '{"kind":"fracture-preset","parameters":[9]}']) readPreset(app, text);
  assert.equal(problems.length, 6);
  assert.equal(wished.length, 1);
});

test('TheMeshOfSeveralFilesIsTheLargest', () => {
  const file = (name, size) => ({ name, data: new Uint8Array(size) });
  const found = meshesOf([file('a/a.mtl', 9), file('a/a.obj', 5), file('a/b.obj', 7), file('a/a.png', 99)], ['obj', 'glb']);
  assert.deepEqual(found.map(({ name }) => name), ['a/b.obj', 'a/a.obj']);
});

test('RefusedMeshesAreReadForTheirPicture', () => {
  const bytes = text => new TextEncoder().encode(text);
  const square = 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n';
  assert.equal(trianglesOf('a.obj', bytes(`${square}f 1//1 2/2 3 4\n`)).length, 18);
  assert.equal(trianglesOf('a.obj', bytes(`${square}f -4 -3 -2\n`)).length, 9);
  assert.equal(trianglesOf('a.obj', bytes(`${square}f 1 2 9\n`)), undefined);
  assert.equal(trianglesOf('a.off', bytes('OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n')).length, 18);
  assert.equal(trianglesOf('a.ply', bytes('ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n')).length, 9);
  assert.equal(trianglesOf('a.stl', bytes('solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid')).length, 9);
  assert.equal(trianglesOf('a.glb', bytes('nonsense')), undefined);
});

/** Six times the volume that a triangle soup encloses, by the divergence theorem; positive if it is wound outwards. */
function volume(points) {
  let sum = 0;
  for (let t = 0; t < points.length; t += 9) {
    const [a, b, c] = [0, 3, 6].map(k => points.subarray(t + k, t + k + 3));
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum / 6;
}

describe('samples', () => {
  for (const sample of samples)
    test(`${sample.name}IsClosedAndWoundOutwards`, () => {
      const points = trianglesOf('a.glb', sample.make()), once = new Set();
      const key = v => points.subarray(3 * v, 3 * v + 3).join();
      for (let t = 0; t < points.length / 3; t += 3)
        for (let k = 0; k < 3; ++k) if (!once.delete(`${key(t + (k + 1) % 3)} ${key(t + k)}`)) once.add(`${key(t + k)} ${key(t + (k + 1) % 3)}`);
      assert.equal(once.size, 0, 'open edges');
      assert.ok(volume(points) > 1e-4, `${volume(points)}`);
    });
});
