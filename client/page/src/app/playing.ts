// Physics, which is loaded the first time the user plays. The user's latest choice always wins: only one start runs at a time, and it
// checks the choice again when it is ready. Leaving takes effect at once. After a failure, the page is not playing.
import type { Physics } from '../play/play';
import type { App } from './app';
import { asProblem } from './failures';
import { loadLater } from './later';

export class Playing {
  physics: Physics | undefined;
  private wanted = false;
  private entering = false;

  constructor(private readonly app: App) {}

  async enter(): Promise<void> {
    const { shown, play } = this.app.state;
    if (!shown || !this.app.stage || !this.app.view || this.wanted) return;
    this.wanted = true;
    if (!play) this.app.set({ play: { loading: true, running: true, slow: false, bodies: 0, resting: false } });
    if (this.entering) return;
    this.entering = true;
    try {
      const { startPlay } = await loadLater('/page/play.js', () => import('../play/play'));
      // By now the page may show a different answer.
      while (this.wanted && !this.physics && this.app.state.shown)
        await startPlay(this.app, () => (this.wanted ? this.app.state.shown?.answer : undefined), physics => {
          this.physics = physics;
        });
    } catch (error) {
      this.failed(error);
    } finally {
      this.entering = false;
    }
  }

  leave(): void {
    const { physics, app: { view, state } } = this;
    this.wanted = false;
    this.physics = undefined;
    physics?.stop();
    if (state.play) this.app.set({ play: undefined });
    view?.letGo(this.app.state.look);
  }
  toggle(): void {
    if (this.wanted) this.leave();
    else void this.enter();
  }

  /** Stops playing and shows the error, which occurred while loading or in a step. */
  failed(error: unknown): void {
    this.leave();
    // If the server is away, the request is repeated, and the message disappears when the server is back.
    this.app.service.noticed(error);
    this.app.set({ problem: asProblem(error), refused: undefined });
  }
}
