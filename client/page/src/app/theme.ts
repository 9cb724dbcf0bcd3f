// Dark or light, as chosen by the user. The browser stores the choice. Without a choice, the system's theme applies.
const KEY = 'fracture-theme';

/** Applies the stored theme. It is called before anything is drawn. */
export function takeTheme(): void {
  try {
    const kept = localStorage.getItem(KEY);
    if (kept === 'dark' || kept === 'light') document.documentElement.dataset['theme'] = kept;
  } catch { /* without storage, no choice is stored */ }
}

export function chooseTheme(theme: 'dark' | 'light'): void {
  document.documentElement.dataset['theme'] = theme;
  try {
    localStorage.setItem(KEY, theme);
  } catch { /* without storage, the choice lasts until a reload */ }
}
