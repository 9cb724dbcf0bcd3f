// Files of the page that are loaded when they are wanted for the first time: the server may be away by then, or have another page.
import { FractureError } from 'fracture-client';
import { build } from './build';
import { words } from '../words/words';

/** How often each failed. Browsers remember that a module could not be loaded (Chromium 150 does, 156 does not): under another address
 * they ask again. */
const failures = new Map<string, number>();

/** `url` is where the module comes from. */
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
  // One that fits by chance is none of this page.
  if (module.build !== build) throw updated(undefined);
  return module;
}

const updated = (cause: unknown) => new FractureError({ type: 'page:updated', status: 0, title: words.problem.updated, detail: words.problem.updatedDetail, cause });
