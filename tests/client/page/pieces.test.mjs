// GLB files that the page makes of an answer: fragments alone, and with names of the user.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { source } from './support.mjs';

const { piecesAlone, renamed, packGlb, Glb } = await source('take/pieces', '../../typescript/src/glb');

describe('files that the page makes', () => {
  /** Two fragments; the first uses the second of two textures. Each bufferView is four bytes, filled with its number, and the
   * last accessor is sparse: its element 1 comes from view 7. */
  const json = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], extensionsUsed: ['KHR_physics_rigid_bodies', 'EXT_none'],
    nodes: [
      { name: 'Fracture', children: [1, 2], extras: { fracture: { bonds: {} } } },
      { name: 'a', mesh: 2, children: [3], translation: [1, 2, 3], extras: { fracture: { id: 7 } } }, { name: 'b', mesh: 0, extras: { fracture: { id: 8 } } },
      { extensions: { KHR_physics_rigid_bodies: { collider: { geometry: { convexHull: true, mesh: 1 } } } } },
    ],
    meshes: [0, 1, 2].map(k => ({ primitives: [{ attributes: { POSITION: 2 * k }, indices: 2 * k + 1, ...(k === 2 ? { material: 1 } : {}) }] })),
    accessors: [0, 1, 2, 3, 4, 5].map(k => ({ bufferView: k, componentType: 5121, count: 4, type: 'SCALAR',
      ...(k === 5 ? { sparse: { count: 1, indices: { bufferView: 8, componentType: 5121 }, values: { bufferView: 7 } } } : {}) })),
    materials: [{ name: 'unused', normalTexture: { index: 0 } }, { name: 'used', pbrMetallicRoughness: { baseColorTexture: { index: 1 } } }],
    textures: [{ source: 0, sampler: 0 }, { source: 1, sampler: 0 }], samplers: [{}], images: [{ bufferView: 6 }, { bufferView: 7 }],
    bufferViews: [0, 1, 2, 3, 4, 5, 6, 7, 8].map(k => ({ buffer: 0, byteOffset: 4 * k, byteLength: 4 })), buffers: [{ byteLength: 36 }],
  };
  const whole = new Glb(packGlb(json, Uint8Array.from({ length: 36 }, (_, k) => (k < 32 ? k >> 2 : 1))));

  test('AloneAFragmentHasItsOwnBuffersMaterialsAndHulls', () => {
    const glb = new Glb(piecesAlone(whole, new Set([7]), new Map([[7, 'handle']]))), { nodes, meshes, materials, textures, images } = glb.json;
    assert.deepEqual(nodes.map(({ name }) => name), ['Fracture', 'handle', undefined]);
    assert.deepEqual([nodes[0].children, nodes[1].children, nodes[1].translation, nodes[0].extras], [[1], [2], [1, 2, 3], undefined]);
    assert.deepEqual(materials.map(({ name }) => name), ['used']);
    assert.deepEqual([materials[0].pbrMetallicRoughness.baseColorTexture.index, textures.length, images.length, glb.json.extensionsUsed], [0, 1, 1, ['KHR_physics_rigid_bodies']]);
    const of = ({ primitives: [{ attributes, indices, material }] }) => [...glb.accessor(attributes.POSITION), ...glb.accessor(indices), material];
    assert.deepEqual(of(meshes[nodes[1].mesh]), [4, 4, 4, 4, 5, 7, 5, 5, 0]);
    assert.deepEqual(of(meshes[nodes[2].extensions.KHR_physics_rigid_bodies.collider.geometry.mesh]), [2, 2, 2, 2, 3, 3, 3, 3, undefined]);
    assert.deepEqual([...glb.image(0).bytes], [7, 7, 7, 7]);
  });
  test('ANameChangesNothingElse', () => {
    const glb = new Glb(renamed(whole, new Map([[8, 'lid'], [9, 'gone']])));
    assert.equal(glb.json.nodes[2].name, 'lid');
    assert.deepEqual([...glb.binary], [...whole.binary]);
    assert.equal(renamed(whole, new Map([[9, 'gone']])), whole.bytes, 'without a name the bytes are those of the server');
  });
});
