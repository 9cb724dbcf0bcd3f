// Dialogs: keys, the certificate, the token.
import { html, nothing, type TemplateResult } from 'lit';
import { ref } from 'lit/directives/ref.js';
import type { App } from '../app/app';
import { words } from '../words/words';
import { certificate, judge } from './certificate';
import { icons } from './icons';

export function sheets(app: App): TemplateResult | typeof nothing {
  const { sheet, shown } = app.state;
  if (sheet === 'keys') return dialog(app, words.sheet.keys, html`<dl class="keys">${words.keys.map(([key, what]) => html`<div><dt><kbd>${key}</kbd></dt><dd>${what}</dd></div>`)}</dl><p class="hint"><a href="/page/licences.txt" target="_blank" rel="noreferrer">${words.sheet.licences}</a></p>`);
  if (sheet === 'seal' && shown) {
    return dialog(app, `${words.seal.title}: ${words.seal[judge(shown.answer)]}`, certificate(shown.answer));
  }
  if (sheet === 'token') {
    return dialog(app, words.sheet.tokenTitle, html`<form @submit=${(event: Event) => {
      event.preventDefault();
      app.service.useToken(new FormData(event.target as HTMLFormElement).get('token') as string);
    }}><p class="hint">${words.sheet.tokenHint}</p>
      ${app.service.hasToken ? html`<p class="red">${words.sheet.wrong}</p>` : nothing}
      <div class="row"><label for="token">${words.sheet.token}</label><input id="token" name="token" type="password" autocomplete="off" class="grow" required autofocus><button class="primary">${words.sheet.use}</button></div></form>`);
  }
  return nothing;
}

function dialog(app: App, title: string, body: TemplateResult): TemplateResult {
  const open = (element?: Element) => {
    const box = element as HTMLDialogElement | undefined;
    if (box?.isConnected && !box.open) box.showModal();
  };
  return html`<dialog aria-label=${title} ${ref(element => queueMicrotask(() => open(element)))} @close=${() => app.set({ sheet: undefined })}
    @click=${(event: MouseEvent) => event.target === event.currentTarget && app.set({ sheet: undefined })}>
    <div class="row between"><h2>${title}</h2><button class="plain" aria-label=${words.sheet.close} title=${words.sheet.close} @click=${() => app.set({ sheet: undefined })}>${icons.reset}</button></div>${body}</dialog>`;
}
