// Shown while the fragments are bodies.
import { html, type TemplateResult } from 'lit';
import type { App } from '../app/app';
import { words } from '../words/words';
import { icons } from './icons';

export function playBar(app: App): TemplateResult {
  const play = app.state.play!;
  if (play.loading) return html`<div class="dock floating playing"><span class="busy"></span>${words.play.loading}<button @click=${() => app.playing.leave()}>${words.play.stop}</button></div>`;
  return html`<div class="dock floating playing">
    <button class="primary" @click=${() => app.playing.leave()}>${words.play.stop}</button>
    <button @click=${() => app.physics?.throwMiddle()}>${icons.aim}<span>${words.play.throw}</span></button>
    <button aria-pressed=${play.slow} @click=${() => app.physics?.setSlow(!play.slow)}>${words.play.slow}</button>
    <button @click=${() => app.physics?.pause()}>${play.running ? words.play.pause : words.play.go}</button>
    <button @click=${() => app.physics?.reset()}>${words.play.reset}</button>
    <span class="figure" role="status">${words.play.bodies(play.bodies)}, ${play.resting ? words.play.rest : words.play.moving}</span>
    <span class="hint">${words.play.hint}</span>
  </div>`;
}
