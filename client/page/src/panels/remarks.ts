// What an answer says about itself, for who knows the page and not the service.
import type { Shown } from '../app/state';
import { words } from '../words/words';

/** The server takes the middle of the mesh for the place where nobody has hit it, and warns of what follows as if somebody had. */
const NOT_AROUND_IMPACT = /^\d+ of \d+ sites found no place in the solid within the radius of their impact/;

export function warningsOf({ answer, wish }: Shown): string[] {
  const aimed = wish.settings['impacts'] !== undefined;
  return answer.warnings.map(text => (!aimed && NOT_AROUND_IMPACT.test(text) ? words.pieces.notHit : text));
}

/** Why there are more or fewer fragments than were asked for; undefined where there are as many, or none were asked for. */
export function countRemark({ answer, wish: { hits } }: Shown): string | undefined {
  const asked = Number(answer.parameters['fragments'] ?? 0), made = answer.fragments.length, [hit] = hits;
  if (asked === 0 || asked === made) return undefined;
  // The server says why from a tenth on, but not with hits: they are on top of what was asked for.
  const said = answer.warnings.find(text => text.startsWith(`fragments: ${asked} asked, `))?.split('; ').slice(1).join('; ');
  return words.break.made(asked, made, said ?? (!hit ? words.break.withinTenth : made > asked ? words.break.brokenOff(hits.length) : undefined));
}
