// The bonds that a blow breaks, and the groups that stay together.
//
// A bond is a spring that breaks when it has stretched by `give` metres. Its tension is then `strength` (N), which the server computes as
// bond_strength times the bond's area. By then the bond has absorbed ½ · strength · give joules. The energy of a blow is that of a
// collision without a bounce: J² / 2μ, where J is the impulse and μ the reduced mass of the two bodies. The blow breaks the nearest bonds
// until its energy is used up. This is a model for games: forces do not travel through the group, and slow loads break nothing.
import type { Bond } from '../fragments.js';
import { length, sub, type Vec3 } from './mass.js';

/** Default stretch at which a bond breaks (m). With a bond_strength of 5 MPa, 1 m² absorbs 250 J, about the fracture energy
 * of rock. */
export const GIVE = 1e-4;

export interface Blow {
  /** m, in the frame of the mesh. */
  point: Vec3;
  /** J */
  energy: number;
}

export const energyOf = (impulse: number, massA: number, massB: number): number => {
  const inverse = (massA > 0 ? 1 / massA : 0) + (massB > 0 ? 1 / massB : 0);  // 0: it does not move
  return impulse * impulse * inverse / 2;
};

/** Returns the indices of the bonds that break, nearest first. `candidates`: the indices of the bonds that can break. */
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

/** Returns the groups of members that are connected by bonds. `ends` returns a bond's two members. */
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
