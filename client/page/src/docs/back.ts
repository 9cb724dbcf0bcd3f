// Back to the page that somebody came from, with what they have made there. The browser knows which of the entries before this one it
// is: each headline that was followed here is one, too.

/** As much of the Navigation API as it takes; browsers without it follow the link. */
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
  // Another tab or window is a new page.
  if (event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
  const { navigation } = globalThis as { navigation?: History }, now = navigation?.currentEntry?.index ?? 0;
  const page = navigation?.entries().slice(0, now).reverse().find(({ url }) => url !== null && new URL(url).pathname === '/');
  if (!navigation || !page) return;
  event.preventDefault();
  navigation.traverseTo(page.key);
}
