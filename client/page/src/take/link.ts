// A link that restores the current view: it contains the request and the digest of the mesh. Both follow the #, because browsers do not
// send that part to servers.
import type { App } from '../app/app';
import type { Wish } from '../state/request';

export interface Link {
  sample: string | undefined;
  mesh: string | undefined;
  name: string;
  wish: Wish;
}

export function hashOf(app: App): string {
  const { source, shown } = app.state, { settings, hits } = (shown ?? app.state).wish;
  if (!source) return '';
  const parts = new URLSearchParams();
  if (source.sample) parts.set('sample', source.sample);
  else {
    parts.set('mesh', source.mesh.id);
    parts.set('name', source.label);
  }
  parts.set('set', JSON.stringify(settings));
  if (hits.length > 0) parts.set('hits', JSON.stringify(hits.map(({ point, radius, sites }) => [...point, radius, ...(sites === undefined ? [] : [sites])])));
  return `#${parts}`;
}
export const linkOf = (app: App): string => `${location.origin}${location.pathname}${hashOf(app)}`;

/** Parses a link; undefined if the text is not a link of this page. */
export function readLink(hash: string): Link | undefined {
  const parts = new URLSearchParams(hash.replace(/^#/, '')), sample = parts.get('sample') ?? undefined, mesh = parts.get('mesh') ?? undefined;
  if (!sample && !(mesh && /^sha256:[0-9a-f]{64}$/.test(mesh))) return undefined;
  try {
    const settings = JSON.parse(parts.get('set') ?? '{}') as Wish['settings'], hits = JSON.parse(parts.get('hits') ?? '[]') as number[][];
    if (typeof settings !== 'object' || settings === null || Array.isArray(settings) || !Array.isArray(hits)) return undefined;
    const good = hits.filter(hit => Array.isArray(hit) && (hit.length === 4 || hit.length === 5) && hit.every(Number.isFinite));
    return { sample, mesh, name: parts.get('name') ?? 'mesh', wish: { settings, hits: good.map(([x, y, z, radius, sites]) => ({ point: [x!, y!, z!], radius: radius!, ...(sites === undefined ? {} : { sites }) })) } };
  } catch {
    return undefined;
  }
}
