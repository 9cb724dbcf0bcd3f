// The page: canvas and panels around a single App.
import { Color } from 'three';
import { render } from 'lit';
import { App } from './app/app';
import { listenToKeys } from './app/keys';
import { takeTheme } from './app/theme';
import { listen } from './app/viewport';
import { filesOf } from './mesh/files';
import { shell } from './panels/shell';
import { Stage } from './scene/stage';
import { View } from './scene/view';
import { hashOf, readLink } from './take/link';
import { words } from './words/words';

const root = document.getElementById('app')!, canvas = document.createElement('canvas');
canvas.tabIndex = 0;
canvas.setAttribute('role', 'img');
canvas.setAttribute('aria-label', `${words.tools.viewport}. ${words.tools.enter}`);

let drawing = 0, written = '';
const app = new App(() => {
  drawing ||= requestAnimationFrame(() => {
    drawing = 0;
    render(shell(app, canvas), root);
    // Browsers refuse to change the address a hundred times in half a minute, so it is updated only when nothing changes any more.
    if (app.state.shown && app.state.inFlight === 0) later();
  });
});
let timer: ReturnType<typeof setTimeout> | undefined;
function later(): void {
  clearTimeout(timer);
  timer = setTimeout(() => {
    const hash = hashOf(app);
    if (hash !== written && hash !== '') history.replaceState(null, '', (written = hash));
  }, 400);
}

function colours(): void {
  const style = getComputedStyle(document.documentElement), value = (name: string) => style.getPropertyValue(name).trim();
  app.stage?.colours(value('--view'), value('--grid'));
  app.view?.accent(new Color(value('--accent')));
  if (app.state.shown) app.look({});
}

takeTheme();
// The server can answer while the renderer is created.
void app.service.start();
render(shell(app, canvas), root);
try {
  app.stage = new Stage(canvas);
  app.stage.lost = lost => app.set({ lost });
  app.view = new View(app.stage, new Color('#5aa2ff'));
  listen(app, canvas);
} catch {
  app.set({ webgl: false });
  canvas.hidden = true;
}
app.themeChanged = colours;
matchMedia('(prefers-color-scheme: light)').addEventListener('change', colours);
colours();
listenToKeys(app);

addEventListener('dragover', event => {
  event.preventDefault();
  document.documentElement.classList.add('dropping');
});
addEventListener('dragleave', event => {
  if (event.relatedTarget === null) document.documentElement.classList.remove('dropping');
});
addEventListener('drop', async event => {
  event.preventDefault();
  document.documentElement.classList.remove('dropping');
  const dropped = event.dataTransfer && await filesOf(event.dataTransfer);
  if (dropped) app.whenReady(() => app.bringing.files(dropped));
});

function open(): void {
  const link = readLink(location.hash);
  written = location.hash;
  if (link?.sample) app.bringing.sample(link.sample, link.wish);
  else if (link?.mesh) void app.bringing.known(link.mesh, link.name, link.wish);
  else app.bringing.sample('vase');
}
addEventListener('hashchange', () => {
  if (location.hash !== written) app.whenReady(open);
});
app.whenReady(open);
// For the tests, and for curious users.
Object.assign(globalThis, { fracture: app });
