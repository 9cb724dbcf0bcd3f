// Dark or light, as somebody chose it: kept in the browser for the next time, as it is no secret. Without a choice the system says.
const KEY = 'fracture-theme';

/** Before anything is drawn. */
export function takeTheme(): void {
  try {
    const kept = localStorage.getItem(KEY);
    if (kept === 'dark' || kept === 'light') document.documentElement.dataset['theme'] = kept;
  } catch { /* a browser that keeps nothing has nothing */ }
}

export function chooseTheme(theme: 'dark' | 'light'): void {
  document.documentElement.dataset['theme'] = theme;
  try {
    localStorage.setItem(KEY, theme);
  } catch { /* it holds until the page is loaded again */ }
}
