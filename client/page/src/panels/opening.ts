// How a mesh is opened: the button in the header, and the samples on the first screen.
import { html, nothing, type TemplateResult } from 'lit';
import type { App } from '../app/app';
import { chosenFiles } from '../mesh/files';
import { samples } from '../mesh/samples';
import { words } from '../words/words';
import { icons } from './icons';

/** A button that opens files, or a folder. */
export function chooser(app: App, label: string, folder: boolean, look = ''): TemplateResult {
  return html`<label class="button ${look}" title=${folder ? nothing : words.mesh.openHint}>${folder ? nothing : icons.open} ${label}<input class="hidden-input" type="file" multiple ?webkitdirectory=${folder}
    @change=${(event: Event) => {
      const input = event.target as HTMLInputElement, dropped = chosenFiles(input.files ?? []);
      input.value = '';
      if (dropped) app.whenReady(() => app.bringing.files(dropped));
    }}></label>`;
}

/** Returns whether the bar of samples is shown: until a mesh of the user is open. */
export const offersSamples = ({ state: { source } }: App): boolean => source === undefined || source.sample !== undefined;

export const sampleChips = (app: App): TemplateResult[] => samples.map(({ name }) => html`<button class="chip" aria-pressed=${app.state.source?.sample === name}
  ?disabled=${app.service.state !== 'ready'} @click=${() => app.bringing.sample(name)}>${name}</button>`);

export function sampleBar(app: App): TemplateResult | typeof nothing {
  if (!offersSamples(app)) return nothing;
  return html`<nav class="samples" aria-label=${words.mesh.samples}><span class="hint">${words.mesh.or}</span>${sampleChips(app)}</nav>`;
}
