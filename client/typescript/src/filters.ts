// Makes the collision filters of KHR_physics_rigid_bodies from the pairs of fragments that must not collide, as the server does
// (common/physics/collision_filters.hpp). System 0 contains the fragments that no filter names.

/** The collision system of a fragment, and the systems with which it must not collide. */
export interface CollisionFilter {
  /** 0 to 31. No filter excludes system 0. */
  system: number;
  /** Systems, ascending. */
  excluded: readonly number[];
}

const MOST_SYSTEMS = 32;

/** Returns each body's filter; undefined for bodies that are in no pair. `pairs`: indices, in ascending order. */
export function collisionFilters(bodies: number, pairs: readonly (readonly [number, number])[]): (CollisionFilter | undefined)[] {
  const partners: number[][] = Array.from({ length: bodies }, () => []);
  for (const [a, b] of pairs) partners[b]!.push(a);
  for (const [a, b] of pairs) partners[a]!.push(b);
  const classes = new Map<string, number>();  // bodies with the same partners
  const classOf = partners.map(list => {
    if (list.length === 0) return -1;
    const key = list.join();
    if (!classes.has(key)) classes.set(key, classes.size);
    return classes.get(key)!;
  });
  const named = new Set<number>();
  for (let round = 1; round < MOST_SYSTEMS; ++round) {
    const open = new Array<number>(classes.size).fill(0);
    for (const [a, b] of pairs) {
      const [x, y] = [classOf[a]!, classOf[b]!];
      if (named.has(x) || named.has(y)) continue;
      ++open[x]!;
      ++open[y]!;
    }
    const most = open.reduce((high, count) => Math.max(high, count), 0);
    if (most === 0) break;
    named.add(open.indexOf(most));
  }
  const systems = new Map([...named].sort((x, y) => x - y).map((name, k) => [name, k + 1]));
  return classOf.map((own, k) => own < 0 ? undefined : {
    system: systems.get(own) ?? 0,
    excluded: [...new Set(partners[k]!.map(other => systems.get(classOf[other]!)).filter(system => system !== undefined))].sort((x, y) => x - y),
  });
}
