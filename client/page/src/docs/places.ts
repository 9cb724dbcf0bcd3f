// Places in the documents. The address names the place of the reader, so that links, reloads and the way back work.
//   #                                   the first document
//   #proto/interface.md                 a document
//   #proto/interface.md:compression     a heading in it
//   #interface, #parameters, #parameter NAME, #post /fracture   the HTTP interface and places in it

export const INTERFACE = 'interface';

/** The place that an address names. */
export function placeOf(hash: string): string {
  try {
    return decodeURIComponent(hash.replace(/^#/, ''));
  } catch {
    return '';
  }
}

/** The document of a place, or INTERFACE; the first of `paths` if there is no such place. */
export function documentOf(place: string, paths: string[]): string {
  if (place === INTERFACE || place === 'parameters' || /^parameter |^[a-z]+ \//.test(place)) return INTERFACE;
  const path = place.split(':')[0]!;
  return paths.includes(path) ? path : paths[0] ?? INTERFACE;
}

/** Keeps in the history how far each entry was scrolled, because the document of an entry is drawn only after the browser's own try. */
export function keepScroll(): void {
  history.scrollRestoration = 'manual';
  let timer: ReturnType<typeof setTimeout> | undefined;
  addEventListener('scroll', () => {
    const { hash } = location;
    clearTimeout(timer);
    // Browsers refuse many changes in a short time.
    timer = setTimeout(() => location.hash === hash && history.replaceState({ scrolled: scrollY }, ''), 150);
  }, { passive: true });
}

/** To where the reader was in this entry, else to its place, else to the top. */
export function scrollTo(place: string): void {
  const kept: unknown = history.state?.scrolled;
  const target = document.getElementById(place);
  if (typeof kept === 'number') globalThis.scrollTo(0, kept);
  else if (target) target.scrollIntoView();
  else globalThis.scrollTo(0, 0);
}
