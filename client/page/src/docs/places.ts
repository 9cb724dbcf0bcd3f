// Places in the documents. The address contains the reader's place, so that links, reloads and going back work.
//   #                                   the first document
//   #proto/interface.md                 a document
//   #proto/interface.md:all-addresses   a heading in it
//   #interface, #parameters, #parameter NAME, #post /fracture   the HTTP interface and places in it

export const INTERFACE = 'interface';

/** Returns the place that the address contains after the #. */
export function placeOf(hash: string): string {
  try {
    return decodeURIComponent(hash.replace(/^#/, ''));
  } catch {
    return '';
  }
}

/** Returns the path of the document that contains a place, or INTERFACE. Returns the first of `paths` for an unknown place. */
export function documentOf(place: string, paths: string[]): string {
  if (place === INTERFACE || place === 'parameters' || /^parameter |^[a-z]+ \//.test(place)) return INTERFACE;
  const path = place.split(':')[0]!;
  return paths.includes(path) ? path : paths[0] ?? INTERFACE;
}

/** Stores in the history how far the reader has scrolled in each entry. The browser cannot restore this itself, because it tries
 * before the entry's document is drawn. */
export function keepScroll(): void {
  history.scrollRestoration = 'manual';
  let timer: ReturnType<typeof setTimeout> | undefined;
  const keep = () => history.replaceState({ scrolled: scrollY }, '');
  // A click may leave the entry before the timer has ended.
  addEventListener('click', keep, { capture: true });
  addEventListener('scroll', () => {
    const { hash } = location;
    clearTimeout(timer);
    // Browsers refuse many changes in a short time.
    timer = setTimeout(() => location.hash === hash && keep(), 150);
  }, { passive: true });
}

/** Scrolls to the stored position of this entry, else to its place, else to the top. */
export function scrollTo(place: string): void {
  const kept: unknown = history.state?.scrolled;
  const target = document.getElementById(place);
  if (typeof kept === 'number') globalThis.scrollTo(0, kept);
  else if (target) target.scrollIntoView();
  else globalThis.scrollTo(0, 0);
}
