// The answer as files. Variants are the same fragments in another form, which the server produces.
import type { Parameters } from 'fracture-client';
import type { App } from '../app/app';
import { asProblem } from '../app/failures';
import { parametersOf } from '../state/request';
import { saveAs } from './browser';
import { piecesAlone, renamed } from './pieces';

const GLB = { type: 'model/gltf-binary' };
const nameOf = (app: App, ending: string) => `${(app.state.source?.label ?? 'mesh').replace(/\.[^.]*$/, '')}_fragments${ending}`;

export async function saveGlb(app: App, variant: Parameters): Promise<void> {
  const { shown, source } = app.state;
  if (!shown || !source) return;
  const changed = Object.entries(variant);
  try {
    const answer = changed.length === 0 ? shown.answer : await source.mesh.fracture({ ...parametersOf(shown.wish), ...variant });
    saveAs(new Blob([renamed(answer.document, app.state.names) as BlobPart], GLB), nameOf(app, `${changed.map(([, value]) => `_${String(value)}`).join('')}.glb`));
  } catch (error) {
    if (!app.service.noticed(error)) app.set({ problem: asProblem(error) });
  }
}

/** Saves the selected fragments alone. */
export function saveChosen(app: App): void {
  const { shown, look: { chosen }, names } = app.state, [first] = chosen;
  if (!shown || first === undefined) return;
  const one = chosen.size === 1 ? shown.answer.fragment(first) : undefined, word = one ? app.nameOf(one).replace(/[^\p{L}\p{N}._-]+/gu, '_') : 'pieces';
  saveAs(new Blob([piecesAlone(shown.answer.document, chosen, names) as BlobPart], GLB), nameOf(app, `_${word}.glb`));
}

/** Saves a sample, or a mesh offered by the server, because neither is on the user's disk. */
export function saveMesh({ state: { source } }: App): void {
  const { name, data } = (source?.fetched && source.input ? source.input : {}) as { name?: string; data?: Uint8Array<ArrayBuffer> };
  if (name && data) saveAs(new Blob([data], { type: name.endsWith('.glb') ? 'model/gltf-binary' : 'application/octet-stream' }), name);
}

export function saveFigures(app: App): void {
  const { shown } = app.state;
  if (shown) saveAs(new Blob([JSON.stringify(shown.answer.figures, undefined, 1)], { type: 'application/json' }), nameOf(app, '.json'));
}

export async function savePicture(app: App): Promise<void> {
  if (app.stage) saveAs(await app.stage.picture(), nameOf(app, '.png'));
}
