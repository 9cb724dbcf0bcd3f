// The settings as a file, for use with other meshes. Points and regions are left out, because they belong to one mesh.
import type { App } from '../app/app';
import { withoutPlaces } from '../state/places';
import type { Settings } from '../state/request';
import { localProblem } from './problems';
import { words } from '../words/words';

const KIND = 'fracture-preset';

export function presetOf(app: App): string {
  const kept = withoutPlaces(app.state.wish.settings, app.service.parameters);
  return `${JSON.stringify({ kind: KIND, version: 1, algorithm: app.service.knowledge?.version.algorithm, parameters: kept }, undefined, 2)}\n`;
}

export function readPreset(app: App, text: string): void {
  const settings = settingsIn(text);
  if (settings) app.breaking.wishFor({ settings, hits: [] }, '', true);
  else app.set({ problem: localProblem(words.take.wrongPreset) });
}

function settingsIn(text: string): Settings | undefined {
  try {
    const { kind, parameters } = JSON.parse(text) as { kind?: unknown; parameters?: unknown };
    return kind === KIND && typeof parameters === 'object' && parameters !== null && !Array.isArray(parameters) ? parameters as Settings : undefined;
  } catch {
    return undefined;
  }
}
