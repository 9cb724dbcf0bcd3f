// The groups of an answer. A group is a node that contains the fragments of one node of the source mesh. It has
// `extras.fracture.source` but no id, so programs that look for ids find only fragments.
import { type Glb, type GltfNode } from './glb.js';

export const MOST_NAME = 63;  // bytes; common tools cut longer names
const SUFFIX = '_group';  // ends a group's name if another node already has the name

const encoder = new TextEncoder();

/** Cuts a text to at most `size` bytes of UTF-8, without splitting a character. */
export function cut(text: string, size: number): string {
  let kept = '';
  for (const character of text) {
    size -= encoder.encode(character).length;
    if (size < 0) break;
    kept += character;
  }
  return kept;
}

/** Returns the index of a group; undefined for other nodes. With levels, fragments have a `source`, too. */
export function groupIndexOf(node: GltfNode): number | undefined {
  const own = node.extras?.['fracture'];
  return own?.id === undefined && typeof own?.source?.index === 'number' ? own.source.index as number : undefined;
}

/** Returns the uncut nodes, in file order. They are children of the root or of groups, but not fragments, clusters or groups. */
export function uncutNodes(glb: Glb): GltfNode[] {
  return uncutIndices(glb).map(index => glb.json.nodes![index]!);
}
export function uncutIndices({ json }: Glb): number[] {
  const nodes = json.nodes ?? [], root = nodes[json.scenes?.[json.scene ?? 0]?.nodes?.[0] ?? 0];
  const above = [...(root ? [root] : []), ...nodes.filter(node => node !== root && groupIndexOf(node) !== undefined)];
  return above.flatMap(node => node.children ?? []).filter(child => !nodes[child]!.extras?.['fracture']).sort((a, b) => a - b);
}

/** The groups of several answers for one mesh. Equal groups have the same index in all answers. A parent's index is below its children's. */
export class Groups {
  private readonly node = new Map<number, GltfNode>();
  private readonly parent = new Map<number, number | undefined>();
  private readonly holder = new Map<GltfNode, number>();  // for each node of an answer: index of the group that contains it

  constructor(answers: readonly Glb[]) {
    const all = answers.flatMap(({ json }) => (json.nodes ?? []).flatMap(node => {
      const index = groupIndexOf(node);
      return index === undefined ? [] : [{ node, index, children: (node.children ?? []).map(child => json.nodes![child]!) }];
    }));
    for (const { node, index, children } of all) {
      if (!this.node.has(index)) this.node.set(index, node);
      for (const child of children) this.holder.set(child, index);
    }
    for (const { node, index } of all)
      if (!this.parent.has(index)) this.parent.set(index, this.holder.get(node));
  }

  /** Returns the index of the group that contains this node of an answer; undefined if no group does. */
  above(node: GltfNode): number | undefined {
    return this.holder.get(node);
  }

  /** Returns the groups as the server writes them, and the root's children. Groups that contain nothing are left out. `held`: nodes of the
   *  file, ascending, with the groups that contain them. `first`: index of the first group's node. `taken`: names of nodes and meshes. */
  written(held: readonly { group: number | undefined; node: number }[], first: number, taken: ReadonlySet<string>): { nodes: GltfNode[]; ofRoot: number[] } {
    const ofRoot: number[] = [], below = new Map<number, number[]>(), names = new Set(taken), nodes: GltfNode[] = [];
    const listOf = (group: number | undefined): number[] => {
      for (let at = group; at !== undefined && !below.has(at); at = this.parent.get(at)) below.set(at, []);
      return group === undefined ? ofRoot : below.get(group)!;
    };
    for (const { group, node } of held) listOf(group).push(node);
    for (const index of [...below.keys()].sort((a, b) => a - b)) {
      listOf(this.parent.get(index)).push(first + nodes.length);
      const source = this.node.get(index)!;
      nodes.push({ ...source, name: freeName(source, names), children: below.get(index)! });
    }
    return { nodes, ofRoot };
  }
}

/** Returns the name that the server gives to a group if the names in `taken` are in use. Adds this name to `taken`. */
function freeName(group: GltfNode, taken: Set<string>): string {
  const stated = String(group.extras?.['fracture'].source.name ?? ''), given = group.name ?? '';
  const marked = given.endsWith(SUFFIX) && (!stated.endsWith(SUFFIX) || given.endsWith(SUFFIX + SUFFIX));
  const wanted = marked ? given.slice(0, -SUFFIX.length) : given;
  let name = wanted;
  for (let number = 1; taken.has(name); ++number) {
    const end = number === 1 ? SUFFIX : `_${number}${SUFFIX}`;
    name = cut(wanted, MOST_NAME - encoder.encode(end).length) + end;
  }
  taken.add(name);
  return name;
}
