// Turns the requested parameters and hits into an answer, with undo and redo: at once if possible, otherwise as a job.
import { type Answer, FractureError, type Mesh, type ParameterValue, type Vector3 } from 'fracture-client';
import { Asker } from '../service/asker';
import { firstPlace, moved, placesIn, withoutPlace } from '../state/places';
import { Gestures, type Hit, History, parametersOf, type Settings, type Step, underPattern, type Wish, withoutExcluded, withSetting } from '../state/request';
import { localProblem } from '../take/problems';
import { words } from '../words/words';
import type { App } from './app';
import type { Shown } from './state';

/** Time in ms that a live answer may take, retries included. If it takes longer, it becomes a job. */
const IMPATIENT = 6000;

/** Converts a place with the origin of the file to one below the root node. */
const below = ([x, y, z]: Vector3, [dx, dy, dz]: Vector3): Vector3 => [x - dx, y - dy, z - dz];

interface Question {
  wish: Wish;
  gesture: number;
  /** The answer to which the hit applies. If it is set, the server sends only the changes. */
  hitOn: { answer: Answer; hit: Hit } | undefined;
}

export class Breaking {
  readonly history = new History();
  private readonly gestures = new Gestures();
  private readonly asker: Asker<Question, Answer>;
  private job: AbortController | undefined;
  /** The settings that the page itself chose for a sample, until the user changes them. */
  private own: Settings = {};

  constructor(private readonly app: App) {
    this.asker = new Asker<Question, Answer>(
      (question, signal) => this.answerTo(question, signal),
      (answer, question, at) => void this.answered(answer, question, at),
      (error, question) => this.refused(error, question),
      inFlight => app.set({ inFlight }),
    );
  }

  /** Starts with a new mesh and its settings. */
  ask(wish: Wish): void {
    this.asker.put({ wish, gesture: this.alone(), hitOn: undefined });
  }
  owns(settings: Settings): void {
    this.own = settings;
  }
  /** Returns the settings with which a mesh of the user starts: it looks as it is, so it has no material, and nothing that the page chose
   * for a sample. */
  startOf(settings: Settings): Settings {
    const { service } = this.app, kept = Object.fromEntries(Object.entries(settings).filter(([name, value]) => name !== 'material' && JSON.stringify(this.own[name]) !== JSON.stringify(value)));
    const start = kept['exterior'] === 'material' ? withSetting(kept, 'exterior', undefined) : kept;
    return underPattern({ settings: start, hits: [] }, service.patternOf(start), service.parameters, 1).settings;
  }
  cancel(): void {
    this.asker.cancel();
    this.cancelJob();
  }

  /** Sets a parameter; undefined removes it. `settled`: the drag has ended with this value. */
  setParameter(name: string, value: ParameterValue | undefined, settled = true): void {
    const { wish } = this.app.state, next = { ...wish, settings: withSetting(wish.settings, name, value) };
    this.own = withSetting(this.own, name, undefined);
    this.wishFor(name === 'pattern' ? this.fitting(next) : next, name, settled);
  }
  setSettings(settings: Settings): void {
    this.wishFor({ settings, hits: this.app.state.wish.hits }, '', true);
  }

  wishFor(wish: Wish, cause: string, settled: boolean): void {
    // A slider repeats its last value when it is released.
    if (JSON.stringify(wish) === JSON.stringify(this.app.state.wish) && (this.asker.busy || this.app.state.shown?.wish === this.app.state.wish)) {
      if (settled) this.letGo();
      return;
    }
    const gesture = this.gestures.of(cause, settled, performance.now());
    this.app.set({ wish });
    this.app.showPlaces();
    const { source } = this.app.state;
    if (!source || this.app.state.bringing) return;
    this.cancelJob();
    // A different unit, axis or repair gives a different solid, so the mesh is opened again.
    if (JSON.stringify(this.app.bringing.solidOf(wish.settings)) !== JSON.stringify(this.app.bringing.solidOf(this.app.state.shown?.wish.settings ?? wish.settings))) {
      this.asker.cancel();
      if (source.sample) this.app.bringing.sample(source.sample, wish);
      else if (source.input) void this.app.bringing.mesh(source.input, source.label, { fetched: source.fetched, main: source.main, wish });
      else void this.app.bringing.known(source.mesh.id, source.label, wish);
      return;
    }
    this.asker.put({ wish, gesture, hitOn: undefined }, settled);
  }
  /** Makes the last value final, because dragging has ended or a key was released. */
  letGo(): void {
    this.gestures.letGo();
    this.asker.settle();
  }
  private alone(): number {
    return this.gestures.of('', true, performance.now());
  }

  /** Handles a click with the Hit tool, which breaks the area around the point. The first click also sets the pattern's impact, if
   * the pattern uses impacts. */
  hitAt(point: Vector3): void {
    const { wish, shown, radius, sites } = this.app.state, rounded = this.given(point);
    if (!shown || this.asker.busy) return;
    if (this.onlyOne !== undefined) {
      this.app.set({ problem: localProblem(words.pieces.noHit) });
      return;
    }
    const hit = { point: rounded, radius, ...(sites === undefined ? {} : { sites }) };
    if (wish.settings['impacts'] === undefined && wish.hits.length === 0 && this.takesImpacts(wish.settings)) {
      this.wishFor({ hits: [hit], settings: { ...wish.settings, impacts: [rounded] } }, 'impacts', true);
      return;
    }
    const next = { settings: wish.settings, hits: [...wish.hits, hit] };
    this.app.set({ wish: next });
    this.asker.put({ wish: next, gesture: this.alone(), hitOn: { answer: shown.answer, hit } });
  }
  /** The offset of the mesh (Answer.offset). */
  private get offset(): Vector3 {
    return this.app.state.source?.whole.offset ?? [0, 0, 0];
  }
  /** Converts a place on the shown mesh to a parameter, which has the origin of the file. */
  private given(point: Vector3): Vector3 {
    const { offset } = this;
    return point.map((value, k) => {
      const rounded = Number(value.toPrecision(6));
      return offset[k] === 0 ? rounded : Number((rounded + offset[k]!).toPrecision(15));
    }) as Vector3;
  }
  aimAt(point: Vector3): void {
    const { settings, hits } = this.app.state.wish, known = this.takesImpacts(settings);
    const next = { ...settings, impacts: [this.given(point)] };
    this.wishFor({ hits, settings: known ? next : { ...next, pattern: 'impact' } }, 'impacts', true);
  }
  /** Returns whether the settings accept impacts. If a pattern is chosen, it must use impacts. Otherwise a material is enough,
   * because the server then chooses a pattern that uses them. */
  private takesImpacts(settings: Settings): boolean {
    const { patterns = [] } = this.app.service.knowledge?.patterns ?? {}, pattern = settings['pattern'];
    if (pattern === undefined) return settings['material'] !== undefined;
    return patterns.find(({ name }) => name === pattern)?.parameters.some(({ name }) => name === 'impacts') ?? false;
  }

  /** The fragment of which only the pieces are shown; undefined if the whole mesh is shown. */
  get onlyOne(): number | undefined {
    return this.app.state.wish.settings['fragment'] as number | undefined;
  }
  /** Breaks a fragment again. The answer contains only the pieces of this fragment. */
  again(id: number): void {
    const { wish } = this.app.state;
    this.app.set({ look: { ...this.app.state.look, chosen: new Set(), hidden: new Set() } });
    this.wishFor({ ...wish, settings: { ...wish.settings, fragment: id } }, '', true);
  }
  /** Shows the whole mesh again. */
  allFragments(): void {
    const { wish } = this.app.state, settings = Object.fromEntries(Object.entries(wish.settings).filter(([name]) => !/^fragment(_|$)/.test(name)));
    this.wishFor({ ...wish, settings }, '', true);
  }

  /** Removes all hits and impacts, and requests an answer without them. */
  clearHits(): void {
    this.wishFor({ settings: withSetting(this.app.state.wish.settings, 'impacts', undefined), hits: [] }, '', true);
  }

  private async answerTo({ wish, hitOn }: Question, signal: AbortSignal): Promise<Answer> {
    // Two retries, because the server may have forgotten the mesh, which is then sent again.
    const options = { signal, realtime: true, retries: 2, deadline: IMPATIENT };
    if (hitOn) return hitOn.answer.hit(below(hitOn.hit.point, hitOn.answer.offset), hitOn.hit.radius, { ...options, ...(hitOn.hit.sites === undefined ? {} : { sites: hitOn.hit.sites }) });
    const { mesh } = await this.app.bringing.dressed(wish.settings, signal);
    void this.estimate(mesh, wish, signal);
    return mesh.fracture(parametersOf(wish), options);
  }

  /** Shows what the request will make, while it is computed. A server without estimates, or a failure, shows nothing. */
  private async estimate(mesh: Mesh, wish: Wish, signal: AbortSignal): Promise<void> {
    const expected = await mesh.estimate(parametersOf(wish), { signal, retries: 0, deadline: IMPATIENT }).catch(() => undefined);
    if (!signal.aborted && this.app.state.wish === wish) this.app.set({ expected });
  }

  private async answered(answer: Answer, { wish, gesture }: Question, at: number): Promise<void> {
    const toAnswer = performance.now() - at;
    if (this.app.state.source && !this.app.bringing.sourceOf(answer)) return;
    await this.showAnswer(answer, wish, toAnswer, at);
    this.history.push({ ...wish, answer, gesture });
  }

  async showAnswer(answer: Answer, wish: Wish, toAnswer: number, at: number): Promise<void> {
    const { look } = this.app.state, [still, hidden] = [look.chosen, look.hidden].map(ids => new Set([...ids].filter(id => answer.fragment(id)))) as [Set<number>, Set<number>];
    const source = this.app.bringing.sourceOf(answer) ?? this.app.state.source;
    this.app.set({ source, problem: undefined, refused: undefined, job: undefined, look: { ...look, chosen: still, hidden } });
    const shown: Shown = { answer, wish, toAnswer, toPicture: 0 };
    await this.app.view?.show(answer, false);
    // If the user is playing, physics restarts with the new fragments.
    const plays = this.app.state.play !== undefined;
    if (plays) this.app.playing.leave();
    this.app.view?.apply(this.app.state.look);
    this.app.view?.mark([]);
    this.app.showPlaces();
    const alone = (before: Shown | undefined) => before?.answer.parameters['fragment'] as number | undefined, turned = alone(this.app.state.shown) !== alone(shown);
    this.app.set({ shown });
    if (turned) this.app.fit();
    if (plays) void this.app.playing.enter();
    await this.app.stage?.drawn();
    if (this.app.marks.at['picture'] === undefined) {
      this.app.marks.at['picture'] = performance.now();
      // Reflections are added later, because they would delay the first picture.
      setTimeout(() => this.app.stage?.reflect(), 50);
      void this.app.bringing.lookForOffers();
    }
    if (this.app.state.shown === shown) this.app.set({ shown: { ...shown, toPicture: performance.now() - at } });
  }

  private refused(error: unknown, question: Question): void {
    const problem = error instanceof FractureError ? error.problem : '';
    // This takes too long for a live answer, so it becomes a job with progress.
    if (['deadline-exceeded', 'overloaded', 'over-share', 'request-timeout', 'timed-out'].includes(problem)) {
      void this.runJob(question);
      return;
    }
    // The fragment that was broken again does not exist with these settings.
    if (problem === 'no-such-fragment' && this.onlyOne !== undefined && this.app.state.wish === question.wish) {
      this.allFragments();
      return;
    }
    // Settings of the user take precedence over those that the page chose.
    const details = error instanceof FractureError && problem === 'bad-parameter' ? [error.detail, ...(error.document?.errors ?? []).map(({ detail }) => detail)] : [];
    const settings = withoutExcluded(question.wish.settings, this.own, details);
    if (settings && this.app.state.wish === question.wish) {
      const wish = { ...question.wish, settings };
      this.app.set({ wish });
      this.asker.put({ ...question, wish });
      return;
    }
    this.app.set({ unmet: question.wish });
    this.app.failed(error, () => this.asker.put(question));
  }

  // -- jobs

  private async runJob({ wish, gesture }: Question): Promise<void> {
    const { source } = this.app.state;
    if (!source) return;
    this.cancelJob();
    const abort = this.job = new AbortController(), at = performance.now(), { signal } = abort;
    try {
      const { mesh } = await this.app.bringing.dressed(wish.settings, signal), job = await mesh.job(parametersOf(wish), { signal });
      signal.addEventListener('abort', () => void job.cancel().catch(() => {}));
      const answer = await job.result({ signal, deadline: 1_800_000, onProgress: document => {
        if (!signal.aborted) this.app.set({ job: { ...document } });
      } });
      if (!signal.aborted) await this.answered(answer, { wish, gesture, hitOn: undefined }, at);
    } catch (error) {
      this.app.set({ unmet: wish });
      if (!signal.aborted) this.app.failed(error, () => void this.runJob({ wish, gesture, hitOn: undefined }));
    } finally {
      if (this.job === abort) {
        this.job = undefined;
        this.app.set({ job: undefined });
      }
    }
  }
  /** Cancels the job, because the user no longer wants to wait. */
  giveUp(): void {
    this.cancelJob();
    this.app.set({ unmet: this.app.state.wish });
  }
  cancelJob(): void {
    this.job?.abort();
    this.job = undefined;
    if (this.app.state.job) this.app.set({ job: undefined });
  }

  // -- undo and redo

  get canUndo(): boolean {
    return this.history.canUndo || this.app.isOfEarlier || this.app.bringing.replaced !== undefined;
  }
  async step(by: 1 | -1): Promise<void> {
    if (by === -1 && this.app.bringing.replaced !== undefined) {
      await this.app.bringing.restore();
      return;
    }
    // A refused request is not a step: undo returns to what is shown.
    const step: Step | undefined = this.history.move(by === -1 && this.app.isOfEarlier ? 0 : by);
    if (!step) return;
    this.cancel();
    const wish = { settings: step.settings, hits: step.hits }, at = performance.now();
    this.app.set({ wish, problem: undefined, refused: undefined });
    if (step.answer) {
      await this.showAnswer(step.answer, wish, 0, at);
      return;
    }
    try {
      const { mesh } = await this.app.bringing.dressed(wish.settings);
      step.answer = await mesh.fracture(parametersOf(wish));
      if (this.app.state.wish === wish) await this.showAnswer(step.answer, wish, performance.now() - at, at);
    } catch (error) {
      this.app.set({ unmet: wish });
      this.app.failed(error, () => void this.asker.put({ wish, gesture: this.alone(), hitOn: undefined }));
    }
  }

  /** The parameter whose point is set by the next click on the mesh. */
  pickingFor: string | undefined;
  /** Starts or ends choosing a point for this parameter. '' ends it. */
  pickFor(name: string): void {
    this.pickingFor = name === '' || this.pickingFor === name ? undefined : name;
    this.app.set({});
  }
  reseed(): void {
    this.setParameter('seed', Number(this.app.state.wish.settings['seed'] ?? 1) + 1);
  }

  /** Sets the chosen parameter to the point that was clicked. If the parameter is a list, the point becomes its only entry. */
  givePoint(point: Vector3): void {
    const name = this.pickingFor, parameter = this.app.service.parameters.find(each => each.name === name);
    this.pickingFor = undefined;
    if (!name || !parameter) return;
    const rounded = this.given(point);
    this.setParameter(name, String(parameter['text']).includes(';') ? [rounded] : rounded);
  }
  /** Adds a region with this name at its initial position, to be dragged; removes it if it exists. */
  togglePlace(name: string): void {
    const { wish } = this.app.state, places = placesIn(this.app.service.parameters), kind = places.get(name), bounds = this.app.view?.bounds;
    if (!kind || !bounds) return;
    const { service } = this.app, material = service.knowledge?.patterns.materials.find(each => each.name === wish.settings['material']);
    const known = (material?.parameters[name] ?? service.parameters.find(parameter => parameter.name === name)?.['default']) as ParameterValue | undefined;
    const settings = wish.settings[name] === undefined ? { ...wish.settings, ...moved(firstPlace(name, kind, bounds, known), places, this.offset) } : withoutPlace(wish.settings, name);
    this.wishFor({ ...wish, settings }, '', true);
  }
  /** Applies the settings that result from dragging a handle. `settled`: the drag has ended. */
  drag(handle: string, settings: Settings, settled: boolean): void {
    const { wish } = this.app.state;
    const given = moved(settings, placesIn(this.app.service.parameters), this.offset);
    this.wishFor({ ...wish, settings: { ...wish.settings, ...given } }, handle, settled);
  }

  /** Sets the material. It also removes the pattern setting, so that the material's own pattern is used. */
  chooseMaterial(material: string | undefined): void {
    const { wish } = this.app.state, settings = withSetting(withSetting(wish.settings, 'material', material), 'pattern', undefined);
    this.wishFor(this.fitting({ ...wish, settings }), 'material', true);
  }
  /** Removes settings that the pattern does not use, because the server would refuse them. */
  private fitting(wish: Wish): Wish {
    const { service, state: { radius } } = this.app, takes = this.takesImpacts(wish.settings);
    return underPattern(wish, service.patternOf(wish.settings), service.parameters.filter(({ name }) => name !== 'impacts' || !takes), radius);
  }
}
