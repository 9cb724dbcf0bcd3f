// Files of the page that are loaded when they are wanted for the first time: the server may be away by then, or have another page.
import { FractureError } from 'fracture-client';
import { build } from './build';
import { words } from '../words/words';

/** `url` is where the module comes from. */
export async function loadLater<Module extends { build: string }>(url: string, load: () => Promise<Module>): Promise<Module> {
  let module: Module;
  try {
    module = await load();
  } catch (cause) {
    const answer = await fetch(url, { method: 'HEAD', cache: 'no-store' }).catch(() => undefined);
    throw answer ? updated(cause) : new FractureError({ type: 'client:server-absent', status: 0, title: words.problem.away, detail: words.problem.awayDetail, cause });
  }
  // One that fits by chance is none of this page.
  if (module.build !== build) throw updated(undefined);
  return module;
}

const updated = (cause: unknown) => new FractureError({ type: 'page:updated', status: 0, title: words.problem.updated, detail: words.problem.updatedDetail, cause });
