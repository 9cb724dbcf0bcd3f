// What happens. Panels read `state` and call these methods, those of `bringing` (a mesh comes) and of `breaking` (a wish becomes an
// answer) and of `playing`, and nothing else.
import { FractureError } from 'fracture-client';
import type { Physics } from '../play/play';
import type { Stage } from '../scene/stage';
import type { Look, View } from '../scene/view';
import { Service } from '../service/service';
import { placesIn } from '../state/places';
import { Breaking } from './breaking';
import { Bringing } from './bringing';
import { asProblem, placesOf } from './failures';
import { Playing } from './playing';
import { firstState, type State } from './state';
import { chooseTheme } from './theme';

export class App {
  state: State = firstState();
  readonly service: Service;
  readonly bringing: Bringing;
  readonly breaking: Breaking;
  readonly playing: Playing;
  stage: Stage | undefined;
  view: View | undefined;
  /** Milliseconds after the navigation. */
  readonly marks: { at: Record<string, number> } = { at: {} };
  private unanswered: (() => void) | undefined;

  constructor(private readonly draw: () => void) {
    this.service = new Service(() => this.serviceChanged(), () => this.serverIsBack());
    this.breaking = new Breaking(this);
    this.bringing = new Bringing(this);
    this.playing = new Playing(this);
  }

  set(change: Partial<State>): void {
    this.state = { ...this.state, ...change };
    this.draw();
  }
  look(change: Partial<Look>): void {
    this.set({ look: { ...this.state.look, ...change } });
    if (change.explode !== undefined) this.view?.makeRoom(change.explode);
    this.view?.apply(this.state.look);
  }

  /** What is in the picture was asked earlier: what is wanted now was refused, taken back, or nobody answers. */
  get isOfEarlier(): boolean {
    const { shown, wish, unmet, inFlight, job, bringing } = this.state;
    return shown !== undefined && unmet === wish && shown.wish !== wish && inFlight === 0 && !job && !bringing;
  }

  // -- the server

  private serviceChanged(): void {
    if (this.service.state === 'token') this.set({ sheet: 'token' });
    else if (this.state.sheet === 'token' && this.service.state === 'ready') this.set({ sheet: undefined });
    else this.draw();
  }
  private serverIsBack(): void {
    const { unanswered } = this;
    this.unanswered = undefined;
    if (this.state.problem?.problem === 'server-absent') this.set({ problem: undefined });
    this.draw();
    if (unanswered) unanswered();
  }
  /** What is done when the server is there. */
  whenReady(what: () => void): void {
    if (this.service.state === 'ready') what();
    else this.unanswered = what;
  }
  /** `refused`: the file that it is about. */
  failed(error: unknown, again: () => void, refused?: string): void {
    if (error instanceof FractureError && error.problem === 'aborted') return;
    if (this.service.noticed(error)) {
      this.unanswered = again;
      this.draw();
      return;
    }
    const problem = asProblem(error);
    this.set({ problem, refused });
    // Of a file that was refused while another mesh is there the place is not in that one.
    this.view?.mark(refused && this.state.source ? [] : placesOf(problem));
  }

  // -- looking at it

  /** The places that are wanted now. */
  showPlaces(): void {
    this.view?.wished(this.state.wish.settings, placesIn(this.service.parameters));
  }

  dismiss(): void {
    this.set({ problem: undefined, refused: undefined, note: undefined, leftOut: undefined });
    this.view?.mark([]);
  }
  fit(): void {
    const { view, stage } = this;
    if (!view?.batch || !stage) return;
    const { min, max } = view.batch.bounds();
    stage.frame(min, max, true);
    view.makeRoom(this.state.look.explode);
  }
  turnTheme(): void {
    const dark = getComputedStyle(document.documentElement).colorScheme === 'dark', theme = dark ? 'light' : 'dark';
    chooseTheme(theme);
    this.themeChanged();
  }
  themeChanged: () => void = () => {};

  choose(ids: Iterable<number>): void {
    this.look({ chosen: new Set(ids) });
  }
  toggle(id: number, more: boolean): void {
    const { chosen } = this.state.look, next = new Set(more ? chosen : []);
    if (!chosen.has(id) || (!more && chosen.size > 1)) next.add(id);
    else next.delete(id);
    this.choose(next);
  }
  /** One that may be hidden among the others: they make room. */
  chooseAndShow(id: number): void {
    this.look({ chosen: new Set([id]), explode: Math.max(0.5, this.state.look.explode) });
  }
  /** Open edges and fills are those of the whole mesh: it is shown assembled. */
  showRepairs(repairs: boolean): void {
    this.look({ repairs, ...(repairs ? { explode: 0 } : {}) });
  }

  /** While something is played. */
  get physics(): Physics | undefined {
    return this.playing.physics;
  }
}
