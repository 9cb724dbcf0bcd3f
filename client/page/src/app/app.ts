// All actions of the page. Panels read `state` and call only these methods and those of `bringing` (opens a mesh), `breaking` (turns
// requests into answers) and `playing`.
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
  /** Times of events by name, in milliseconds since the navigation. */
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

  /** True if the view shows an earlier request: the current one was refused or undone, or the server does not answer. */
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
  /** Calls `what` at once if the server is available, otherwise as soon as it is. */
  whenReady(what: () => void): void {
    if (this.service.state === 'ready') what();
    else this.unanswered = what;
  }
  /** Shows an error. `again` is called when the server is back, if that was the reason. `refused`: the file that was refused. */
  failed(error: unknown, again: () => void, refused?: string): void {
    if (error instanceof FractureError && error.problem === 'aborted') return;
    if (this.service.noticed(error)) {
      this.unanswered = again;
      this.draw();
      return;
    }
    const problem = asProblem(error);
    this.set({ problem, refused });
    // If a file was refused while another mesh is shown, the location of the problem is not in that mesh.
    this.view?.mark(refused && this.state.source ? [] : placesOf(problem));
  }

  // -- viewing

  /** Shows the points and regions that are currently set. */
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
  /** Selects the fragment that was clicked in the view, and shows what can be done with it. */
  chooseInView(id: number, more: boolean): void {
    this.toggle(id, more);
    if (this.state.look.chosen.size > 0) this.set({ tab: 'pieces' });
  }
  /** Fills the view with the selected fragments. */
  frameChosen(): void {
    const { view, stage } = this, around = view?.around(this.state.look.chosen);
    if (around) stage?.aim(around.center, around.radius);
  }
  /** Hides the selected fragments and ends the selection. */
  hideChosen(): void {
    const { chosen, hidden } = this.state.look;
    this.look({ hidden: new Set([...hidden, ...chosen]), chosen: new Set() });
  }
  showAll(): void {
    this.look({ hidden: new Set() });
  }
  /** Gives a fragment a name, which the list and saved files use. The server's name is used again if the text is empty or equals it. */
  nameFragment(id: number, text: string): void {
    const names = new Map(this.state.names), name = text.trim();
    if (name === '' || name === this.state.shown?.answer.fragment(id)?.name) names.delete(id);
    else names.set(id, name);
    this.set({ names });
  }
  nameOf({ id, name }: { id: number; name: string }): string {
    return this.state.names.get(id) ?? name;
  }

  /** Selects a fragment and moves the fragments apart, because it may be hidden among the others. */
  chooseAndShow(id: number): void {
    this.look({ chosen: new Set([id]), explode: Math.max(0.5, this.state.look.explode) });
  }
  /** Shows or hides open edges and filled holes. They belong to the whole mesh, so the fragments are assembled. */
  showRepairs(repairs: boolean): void {
    this.look({ repairs, ...(repairs ? { explode: 0 } : {}) });
  }

  /** The running physics; undefined unless the user is playing. */
  get physics(): Physics | undefined {
    return this.playing.physics;
  }
}
