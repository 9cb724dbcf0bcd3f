// Keys that work everywhere except in text fields. words.keys lists them for users.
import { colourModes } from '../scene/colours';
import { saveGlb } from '../take/files';
import type { App } from './app';
import type { Tab } from './state';

const TABS: readonly Tab[] = ['mesh', 'break', 'pieces', 'take'];

export function listenToKeys(app: App): void {
  addEventListener('keydown', event => {
    const target = event.target as HTMLElement, { key } = event;
    const typing = target.matches('input:not([type=range]):not([type=checkbox]), textarea, select');
    if (document.querySelector('dialog[open]')) return;
    if ((event.ctrlKey || event.metaKey) && !event.altKey && !typing) {
      const by = key.toLowerCase() === 'y' || (key.toLowerCase() === 'z' && event.shiftKey) ? 1 : key.toLowerCase() === 'z' ? -1 : 0;
      if (by !== 0) {
        event.preventDefault();
        void app.breaking.step(by);
      }
      return;
    }
    if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
    // Buttons handle Space and Enter themselves.
    if (key === ' ' && target.matches('button, a, summary, label')) return;
    const act = app.state.play ? whilePlaying(app, key) : onTheBench(app, key);
    if (!act) return;
    event.preventDefault();
    act();
  });
}

function whilePlaying(app: App, key: string): (() => void) | undefined {
  switch (key) {
    case 'p': case 'Escape': return () => app.playing.leave();
    case ' ': return () => app.physics?.throwMiddle();
    case 'r': return () => app.physics?.reset();
    case 't': return () => app.physics?.setSlow(!app.state.play?.slow);
    case '?': return () => app.set({ sheet: 'keys' });
    default: return undefined;
  }
}

function onTheBench(app: App, key: string): (() => void) | undefined {
  const { look, radius, shown } = app.state;
  switch (key) {
    case '?': return () => app.set({ sheet: 'keys' });
    case 'Escape': return () => {
      app.dismiss();
      app.breaking.pickFor('');
      app.choose([]);
      app.set({ sheet: undefined });
    };
    case 'h': return () => app.set({ tool: 'hit' });
    case 'a': return () => app.set({ tool: 'aim' });
    case 's': return () => app.set({ tool: 'select' });
    case '1': case '2': case '3': case '4': return () => app.set({ tab: TABS[Number(key) - 1]! });
    case '[': return () => app.set({ radius: Number((radius / 1.2).toPrecision(2)) });
    case ']': return () => app.set({ radius: Number((radius * 1.2).toPrecision(2)) });
    default:
  }
  if (!shown) return undefined;
  switch (key) {
    case 'e': return () => app.look({ explode: look.explode > 0 ? 0 : 0.35 });
    case 'c': return () => app.look({ cutsOnly: !look.cutsOnly });
    case 'w': return () => app.look({ wireframe: !look.wireframe });
    case 'b': return () => app.look({ bonds: !look.bonds });
    case 'k': return () => app.look({ colours: colourModes[(colourModes.indexOf(look.colours) + 1) % colourModes.length]! });
    case 'f': return () => app.fit();
    case 'r': return () => app.breaking.reseed();
    case 'p': return () => app.playing.toggle();
    case 'd': return () => void saveGlb(app, {});
    default: return undefined;
  }
}
