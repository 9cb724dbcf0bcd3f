// Returns to the page from which the user came, with everything they made there. The browser knows which history entry that is. It may
// be several entries back, because every link to a heading here adds an entry.

/** The part of the Navigation API that is used; browsers without it follow the link. */
interface Entry {
  key: string;
  url: string | null;
  index: number;
}
interface History {
  currentEntry: Entry | null;
  entries(): Entry[];
  traverseTo(key: string): unknown;
}

export function backToPage(event: MouseEvent): void {
  // Another tab or window opens a new page.
  if (event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
  const { navigation } = globalThis as { navigation?: History }, now = navigation?.currentEntry?.index ?? 0;
  const page = navigation?.entries().slice(0, now).reverse().find(({ url }) => url !== null && new URL(url).pathname === '/');
  if (!navigation || !page) return;
  event.preventDefault();
  navigation.traverseTo(page.key);
}
