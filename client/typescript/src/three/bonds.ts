// Which bonds a blow breaks, and what then still holds together.
//
// A bond is a spring that breaks at the pull `strength` (newtons, in the file: bond_strength times its area), when it has
// given way by `give` metres: until then it took ½ · strength · give joules. A blow has the energy that a collision without
// a bounce loses, J² / 2μ, of its impulse J and the reduced mass μ of the two bodies; it breaks the nearest bonds as long as
// that lasts. A model for games: forces do not travel through the group, and slow loads break nothing.
import type { Bond } from '../fragments.js';
import { length, sub, type Vec3 } from './mass.js';

/** Metres. With a bond_strength of 5 MPa a square metre takes 250 J: the order of the fracture energy of rock. */
export const GIVE = 1e-4;

export interface Blow {
  /** In the frame of the mesh. */
  point: Vec3;
  /** Joules. */
  energy: number;
}

export const energyOf = (impulse: number, massA: number, massB: number): number => {
  const inverse = (massA > 0 ? 1 / massA : 0) + (massB > 0 ? 1 / massB : 0);  // 0: it does not move
  return impulse * impulse * inverse / 2;
};

/** Indices into `bonds` of those that break, the nearest first. */
export function brokenBy(blow: Blow, bonds: readonly Bond[], candidates: Iterable<number>, give = GIVE): number[] {
  const distance = (k: number) => length(sub(bonds[k]!.centroid, blow.point));
  const near = [...candidates].map(k => ({ k, at: distance(k) })).sort((a, b) => a.at - b.at || a.k - b.k);
  const broken: number[] = [];
  let left = blow.energy;
  for (const { k } of near) {
    left -= 0.5 * bonds[k]!.strength * give;
    if (left < 0) break;
    broken.push(k);
  }
  return broken;
}

export type Ends = (bond: number) => readonly [number, number];

/** Connected components of the members under the bonds; members are indices that `ends` gives for each bond. */
export function components(members: readonly number[], bonds: Iterable<number>, ends: Ends): number[][] {
  const root = new Map(members.map(member => [member, member]));
  const find = (k: number): number => {
    let top = k;
    while (root.get(top) !== top) top = root.get(top)!;
    root.set(k, top);
    return top;
  };
  for (const bond of bonds) {
    const [a, b] = ends(bond);
    if (root.has(a) && root.has(b)) root.set(Math.max(find(a), find(b)), Math.min(find(a), find(b)));
  }
  const groups = new Map<number, number[]>();
  for (const member of members) {
    const top = find(member), group = groups.get(top);
    if (group) group.push(member);
    else groups.set(top, [member]);
  }
  return [...groups.values()];
}
