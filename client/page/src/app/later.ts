// Loads parts of the page when they are first needed. By then the server may be away, or may have another version of the page.
import { FractureError } from 'fracture-client';
import { build } from './build';
import { words } from '../words/words';

/** Number of failed loads of each module. Some browsers (Chromium 150, but not 156) remember that a module could not be loaded,
 * and ask again only under another address. */
const failures = new Map<string, number>();

/** Loads a module on first use. `url`: its address. Throws FractureError if the server is away or has another version of the page. */
export async function loadLater<Module extends { build: string }>(url: string, load: () => Promise<Module>): Promise<Module> {
  let module: Module;
  try {
    const failed = failures.get(url);
    module = failed === undefined ? await load() : ((await import(`${url}#again=${failed}`)) as Module);
  } catch (cause) {
    failures.set(url, (failures.get(url) ?? 0) + 1);
    const answer = await fetch(url, { method: 'HEAD', cache: 'no-store' }).catch(() => undefined);
    throw answer ? updated(cause) : new FractureError({ type: 'client:server-absent', status: 0, title: words.problem.away, detail: words.problem.awayDetail, cause });
  }
  // A module from another version may have the same address.
  if (module.build !== build) throw updated(undefined);
  return module;
}

const updated = (cause: unknown) => new FractureError({ type: 'page:updated', status: 0, title: words.problem.updated, detail: words.problem.updatedDetail, cause });
