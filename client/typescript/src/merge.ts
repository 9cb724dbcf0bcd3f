// Merges an answer with the changes from a hit (delta=only) into the answer that the server gives with delta=stated. The layout matches
// the server's files (common/gltf), so the binary chunks are identical.
//
//   before   a b c d e          kept      a c d           order    by the first site, part and id, as on the server
//   changes      B' x y    ──>  changes     B' x y   ──>  names    renumbered in that order
//   gone     e                                            bonds    between kept fragments from before, others from the changes
import { type Glb, type Gltf, type GltfMesh, type GltfNode, packGlb, type Vector3 } from './glb.js';
import { collisionFilters } from './filters.js';
import { type BondColumns, type Figures, figuresOf, sheetNodeOf } from './fragments.js';
import { cut, Groups, MOST_NAME, uncutNodes } from './groups.js';
import { MeshCopier } from './mesh_copier.js';

interface Source {
  glb: Glb;
  node: GltfNode;
  figures: Record<string, any>;
}

const KHR = 'KHR_physics_rigid_bodies', OMI = 'OMI_physics_body', SHAPES = 'OMI_physics_shape';

/** Returns the name, or the name with _2, _3, … if it is taken. A fragment can take it if the fragments' numbers get more digits. */
function uniqueName(name: string, taken: Set<string>): string {
  let unique = name;
  for (let number = 2; taken.has(unique); ++number) unique = `${cut(name, MOST_NAME - 1 - String(number).length)}_${number}`;
  taken.add(unique);
  return unique;
}

/** Returns the maximum length of the fragments' names in bytes, and the number of digits in the names of hulls. The names of hulls,
 *  colliders and sheets add a suffix to a fragment's name, and must not exceed 63 bytes. */
function nameRoom(sources: Source[]): { room: number; digits: number } {
  const most = sources.reduce((sum, source) => Math.max(sum, hullsOf(source).length), 0), digits = Math.max(2, String(most - 1).length);
  const sheet = sources.some(({ glb, node }) => sheetNodeOf(glb, node) !== undefined) ? '_sheet'.length : 0;
  return { room: MOST_NAME - (most > 0 ? digits + '__collider'.length : sheet), digits };
}

const fractureOf = (node: GltfNode): Record<string, any> | undefined => node.extras?.['fracture'];

/** Returns the merged GLB; undefined if the files cannot be merged. The caller must then request the whole answer. */
export function merge(before: Glb, changes: Glb): Uint8Array | undefined {
  const now = figuresOf(changes), was = figuresOf(before);
  if (!now.delta || now.levels || was.levels || now.mesh !== was.mesh) return undefined;
  // With interior_detail, a delta contains neither the texture maps of the cuts nor the tangents that they need.
  if (JSON.stringify(before.json.materials) !== JSON.stringify(changes.json.materials)) return undefined;
  const left = new Set([...now.delta.changed, ...now.delta.gone]);
  const sources = inOrder(sourcesOf(before), sourcesOf(changes), left);
  const ids = new Set(sources.map(({ figures }) => figures['id']));
  if (sources.length !== now.certificate.fragments || ids.size !== sources.length) return undefined;
  const figures = withWholeBonds(now, was, sources, left);
  return write(before, changes, figures, sources, bondsOfWhole(was.bonds, now.bonds, sources, left),
    pairsOfWhole(was.filtered, now.filtered, sources, left));
}

function sourcesOf(glb: Glb): Source[] {
  return (glb.json.nodes ?? []).flatMap(node => {
    const figures = fractureOf(node);
    return figures?.['id'] === undefined ? [] : [{ glb, node, figures }];
  });
}

/** Returns all fragments in the server's order: by first site, then by part, then by id. `left`: ids of the fragments that changed or are gone. */
function inOrder(before: Source[], after: Source[], left: ReadonlySet<number>): Source[] {
  const stay = before.filter(({ figures }) => !left.has(figures['id'] as number));
  return [...stay, ...after].sort(({ figures: a }, { figures: b }) => a['sites'][0] - b['sites'][0] || a['part'] - b['part'] || a['id'] - b['id']);
}

/** Returns the hull meshes of a fragment in the order of the nodes that refer to them, without duplicates. Sheets are not hulls. */
function hullsOf({ glb, node }: Source): number[] {
  const sheet = sheetNodeOf(glb, node);
  const nodes = [node, ...(node.children ?? []).filter(child => child !== sheet).map(child => glb.json.nodes![child]!)];
  return [...new Set(nodes.flatMap(held => {
    const khr = held.extensions?.[KHR]?.collider?.geometry?.mesh as number | undefined, omi = held.extensions?.[OMI]?.collider?.shape as number | undefined;
    const drawn = held === node ? undefined : held.mesh;  // a hull for Unreal
    const mesh = khr ?? (omi === undefined ? drawn : glb.json.extensions![SHAPES].shapes[omi].convex.mesh as number);
    return mesh === undefined ? [] : [mesh];
  }))];
}

/** Returns the bonds between unchanged fragments, and the bonds in the delta. They are sorted, and each goes from the earlier fragment
 *  to the later one. */
function bondsOfWhole(was: BondColumns, now: BondColumns, sources: Source[], left: ReadonlySet<number>): BondColumns {
  const place = new Map(sources.map(({ figures }, k) => [figures['id'] as number, k]));
  const rows: { a: number; b: number; area: number; centroid: Vector3; normal: Vector3; strength: number }[] = [];
  const take = (bonds: BondColumns, wanted: (a: number, b: number) => boolean) => bonds.a.forEach((idA, k) => {
    const idB = bonds.b[k]!;
    if (!wanted(idA, idB)) return;
    const a = place.get(idA), b = place.get(idB), normal = bonds.normal[k]!;
    if (a === undefined || b === undefined) return;
    const turned: Vector3 = a > b ? [-normal[0], -normal[1], -normal[2]] : normal;
    const figures = { area: bonds.area[k]!, centroid: bonds.centroid[k]!, normal: turned, strength: bonds.strength[k]! };
    rows.push({ a: Math.min(a, b), b: Math.max(a, b), ...figures });
  });
  take(was, (a, b) => !left.has(a) && !left.has(b));
  take(now, () => true);
  rows.sort((x, y) => x.a - y.a || x.b - y.b);
  const id = (k: number) => sources[k]!.figures['id'] as number;
  return {
    a: rows.map(row => id(row.a)), b: rows.map(row => id(row.b)), area: rows.map(row => row.area),
    centroid: rows.map(row => row.centroid), normal: rows.map(row => row.normal), strength: rows.map(row => row.strength),
  };
}

/** Returns the figures with all bonds between fragments and uncut nodes. */
function withWholeBonds({ whole_bonds: now, ...figures }: Figures, was: Figures, sources: Source[], left: ReadonlySet<number>): Figures {
  const place = new Map(sources.map(({ figures: { id } }, k) => [id as number, k])), before = was.whole_bonds;
  const rows = [before, now].flatMap(bonds => (bonds?.a ?? []).flatMap((id, k) => (bonds === before && left.has(id) ? [] : [{ bonds: bonds!, k, id }])));
  rows.sort((x, y) => place.get(x.id)! - place.get(y.id)! || x.bonds.node[x.k]! - y.bonds.node[y.k]!);
  if (rows.length === 0) return figures as Figures;
  const column = (name: keyof NonNullable<typeof now>) => rows.map(({ bonds, k }) => (bonds[name] as unknown[])[k]);
  const names = ['a', 'node', 'area', 'centroid', 'normal', 'strength'] as const;
  return { ...figures, whole_bonds: Object.fromEntries(names.map(name => [name, column(name)])) } as unknown as Figures;
}

type Pairs = { a: number[]; b: number[] };

/** Returns the pairs of fragments that must not collide, sorted, as indices. */
function pairsOfWhole(was: Pairs | undefined, now: Pairs | undefined, sources: Source[], left: ReadonlySet<number>): [number, number][] {
  const place = new Map(sources.map(({ figures }, k) => [figures['id'] as number, k])), pairs: [number, number][] = [];
  const take = ({ a: from, b: to }: Pairs, wanted: (a: number, b: number) => boolean) => from.forEach((idA, k) => {
    const [a, b] = [place.get(idA), place.get(to[k]!)];
    if (a !== undefined && b !== undefined && wanted(idA, to[k]!)) pairs.push(a < b ? [a, b] : [b, a]);
  });
  if (was) take(was, (a, b) => !left.has(a) && !left.has(b));
  if (now) take(now, () => true);
  return pairs.sort((x, y) => x[0] - y[0] || x[1] - y[1]);
}

function withPairs({ filtered: _, ...figures }: Figures, pairs: [number, number][], sources: Source[]): object {
  const ids = (which: 0 | 1) => pairs.map(pair => sources[pair[which]]!.figures['id'] as number);
  return pairs.length > 0 ? { ...figures, filtered: { a: ids(0), b: ids(1) } } : figures;
}

function write(before: Glb, changes: Glb, now: Figures, sources: Source[], bonds: BondColumns, pairs: [number, number][]): Uint8Array {
  const width = String(sources.length - 1).length, names = nameRoom(sources), room = names.room - 1 - width;
  const nameOf = (name: string, k: number) => `${cut(name.replace(/_\d+$/, ''), room)}_${String(k).padStart(width, '0')}`;
  const copier = new MeshCopier(), numbers = new Map<string, number>(), listed: object[] = [];
  const filters = collisionFilters(sources.length, pairs).map(filter => {  // numbered in the order of their first fragments
    if (!filter) return undefined;
    const key = `${filter.system}:${filter.excluded.join()}`, excluded = filter.excluded.map(String);
    if (!numbers.has(key)) numbers.set(key, listed.push({ collisionSystems: [String(filter.system)],
      ...(excluded.length > 0 ? { notCollideWithSystems: excluded } : {}) }) - 1);
    return numbers.get(key);
  });
  const fragmentNodes: GltfNode[] = [], childNodes: GltfNode[] = [], shapes: unknown[] = [];
  // The order of the meshes: fragments, shapes that instances share, hulls of both, sheets.
  const meshes: GltfMesh[] = [], hulls: { glb: Glb; mesh: GltfMesh }[] = [];
  const sheets: { glb: Glb; node: GltfNode; mesh: GltfMesh }[] = [];
  const firstOfShape: typeof hulls = [], sharedHulls: typeof hulls = [];
  const alone = sources.filter(({ figures }) => figures['shape'] === undefined);
  const meshOfShape = new Map<number, number>(), hullsOfShape = new Map<number, Map<number, number>>();
  for (const { figures: { shape } } of sources)
    if (shape !== undefined && !meshOfShape.has(shape)) meshOfShape.set(shape, alone.length + meshOfShape.size);
  const firstHull = alone.length + meshOfShape.size, firstSharedHull = firstHull + alone.reduce((sum, source) => sum + hullsOf(source).length, 0);

  sources.forEach((source, k) => {
    const { glb, node, figures } = source, shape = figures['shape'] as number | undefined;
    const name = nameOf(node.name ?? '', k);
    const rename = (text: string, from = node.name ?? ''): string => {  // of a hull, a collider or a sheet
      const at = text.indexOf(from), number = (_: string, digits: string) => `_${String(Number(digits)).padStart(names.digits, '0')}`;
      return at < 0 ? text : text.slice(0, at) + name + text.slice(at + from.length).replace(/^_(\d+)/, number);
    };
    const holder = glb.json.meshes![node.mesh!]!.name;  // the fragment or the instance that named the hulls
    const isFirst = shape !== undefined && !hullsOfShape.has(shape);
    if (isFirst) hullsOfShape.set(shape, new Map());
    const order = hullsOf(source);
    const hullMesh = new Map<number, number>();  // mesh index in the source file -> index in the merged file
    const hullOf = (mesh: number) => {
      if (hullMesh.has(mesh)) return hullMesh.get(mesh)!;
      const [list, first] = shape === undefined ? [hulls, firstHull] : [sharedHulls, firstSharedHull];
      const known = shape === undefined ? undefined : hullsOfShape.get(shape)!, number = order.indexOf(mesh);
      if (!known?.has(number)) {
        const original = glb.json.meshes![mesh]!;
        hullMesh.set(mesh, first + list.push({ glb, mesh: { ...original, name: rename(original.name ?? '', holder) } }) - 1);
        known?.set(number, hullMesh.get(mesh)!);
      } else {
        hullMesh.set(mesh, known.get(number)!);
      }
      return hullMesh.get(mesh)!;
    };
    const physics = (extensions: Record<string, any>): Record<string, any> => {
      const result = { ...extensions }, khr = extensions[KHR], omi = extensions[OMI];
      if (khr?.collider) {
        const { collisionFilter: _, ...collider } = khr.collider;
        result[KHR] = { ...khr, collider: { ...collider, geometry: { ...collider.geometry, mesh: hullOf(collider.geometry.mesh) },
          ...(filters[k] === undefined ? {} : { collisionFilter: filters[k] }) } };
      }
      if (omi?.collider) {
        const listedShape = glb.json.extensions![SHAPES].shapes[omi.collider.shape];
        const number = hullOf(listedShape.convex.mesh) - firstHull;
        shapes[number] = { ...listedShape, convex: { ...listedShape.convex, mesh: firstHull + number } };
        result[OMI] = { ...omi, collider: { ...omi.collider, shape: number } };
      }
      return result;
    };
    const adopt = (source: GltfNode, more: Partial<GltfNode>): GltfNode => {
      const { children: _, extensions, ...rest } = source;
      return { ...rest, name: rename(source.name ?? ''), ...(extensions ? { extensions: physics(extensions) } : {}), ...more };
    };
    const own = adopt(node, { mesh: shape === undefined ? meshes.length : meshOfShape.get(shape)! }), sheet = sheetNodeOf(glb, node);
    if (node.children) own.children = node.children.map(index => {
      const child = glb.json.nodes![index]!;
      if (index === sheet) {
        const carrier = adopt(child, {});
        sheets.push({ glb, node: carrier, mesh: glb.json.meshes![child.mesh!]! });
        return childNodes.push(carrier) + sources.length;
      }
      return childNodes.push(adopt(child, child.mesh === undefined ? {} : { mesh: hullOf(child.mesh) })) + sources.length;
    });
    fragmentNodes.push(own);
    if (shape === undefined) meshes.push({ ...copier.copy(glb, glb.json.meshes![node.mesh!]!), name });
    else if (isFirst) firstOfShape.push({ glb, mesh: { ...glb.json.meshes![node.mesh!]!, name } });
  });
  for (const { glb, mesh } of [...firstOfShape, ...hulls, ...sharedHulls]) meshes.push(copier.copy(glb, mesh));
  for (const { glb, node, mesh } of sheets) {
    node.mesh = meshes.length;
    meshes.push({ ...copier.copy(glb, mesh), name: node.name! });
  }

  const root = changes.json.nodes![0]!, behind = 1 + sources.length + childNodes.length;
  const groups = new Groups([before, changes]), others: GltfNode[] = [], held: { group: number | undefined; node: number }[] = [];
  const taken = new Set([root, ...fragmentNodes, ...childNodes, ...meshes].map(each => each.name ?? ''));
  sources.forEach((source, k) => {
    held.push({ group: groups.above(source.node), node: 1 + k });
    hullsOf(source).forEach((_, hull) => taken.add(`${fragmentNodes[k]!.name}_${String(hull).padStart(names.digits, '0')}_collider`));
  });
  for (const node of uncutNodes(before)) {  // a delta may omit these nodes
    held.push({ group: groups.above(node), node: behind + others.length });
    const name = uniqueName(node.name ?? '', taken);
    if (node.mesh === undefined) {
      others.push({ ...node, name });
      continue;
    }
    others.push({ ...node, name, mesh: meshes.length });
    meshes.push({ ...copier.copy(before, before.json.meshes![node.mesh]!), name });
  }
  const tree = groups.written(held, behind + others.length, taken);
  const stated = (parameters: Record<string, any>) => ({ ...parameters, delta: 'stated' });
  const json: Gltf = {
    ...changes.json,
    asset: { ...changes.json.asset, extras: { ...changes.json.asset.extras, parameters: stated(changes.json.asset.extras.parameters) } },
    extensionsUsed: [...new Set([...(before.json.extensionsUsed ?? []), ...(changes.json.extensionsUsed ?? [])])],
    nodes: [
      { ...root, children: tree.ofRoot,
        extras: { fracture: withPairs({ ...now, parameters: stated(now.parameters), bonds }, pairs, sources) } },
      ...fragmentNodes, ...childNodes, ...others, ...tree.nodes,
    ],
    meshes,
  };
  // These come from the earlier answer, because a delta without fragments has no textures.
  for (const member of ['materials', 'textures', 'samplers', 'images'] as const) {
    delete json[member];
    if (before.json[member]) json[member] = before.json[member];
  }
  const extensions = { ...before.json.extensions, ...changes.json.extensions };
  if (extensions[KHR]) {
    const { collisionFilters: _, ...khr } = extensions[KHR];
    extensions[KHR] = listed.length > 0 ? { ...khr, collisionFilters: listed } : khr;
  }
  if (extensions[SHAPES]) extensions[SHAPES] = { ...extensions[SHAPES], shapes };
  if (Object.keys(extensions).length > 0) json.extensions = extensions;
  const binary = copier.finish(before, json);
  return packGlb(json, binary);
}
