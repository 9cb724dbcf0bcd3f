// Opens a mesh: a sample, files, or a mesh that the server has. A refused mesh is shown as it is.
import { type Answer, FractureError, type MeshInput } from 'fracture-client';
import { type Dropped, meshesOf } from '../mesh/files';
import { framed, trianglesOf } from '../mesh/preview';
import { lookOf } from '../mesh/looks';
import { sampleOf } from '../mesh/samples';
import { withoutPlaces } from '../state/places';
import type { Settings, Wish } from '../state/request';
import { words } from '../words/words';
import type { App } from './app';
import { isOfTheSolid } from './failures';
import { firstState, type Offered, type Source, type State } from './state';

/** Bytes. Smaller meshes are sent at once, because that is faster than asking whether the server has them. */
const ASK_FIRST = 8 << 20;

export class Bringing {
  private abort: AbortController | undefined;
  /** Opens the refused mesh again, as slabs of this thickness. */
  refusedMesh: ((thickness: number) => void) | undefined;

  /** The mesh that was shown before a refused mesh replaced it in the view. */
  private before: { state: Pick<State, 'source' | 'shown' | 'wish' | 'radius'>; restoreSteps: () => void } | undefined;

  constructor(private readonly app: App) {}

  sample(name: string, wish?: Wish): void {
    const sample = sampleOf(name);
    if (!sample) return;
    const own = this.knownSettings(sample.settings), wanted = wish ?? { settings: own, hits: [] };
    this.app.breaking.owns(own);
    void this.mesh(this.made(name, wanted.settings), name, { sample: name, wish: wanted });
  }
  private made(name: string, { material }: Settings): { name: string; data: Uint8Array } {
    const known = this.app.service.knowledge?.patterns.materials.find(each => each.name === material);
    return { name: `${name}.glb`, data: sampleOf(name)!.make(lookOf(known)) };
  }

  /** Fetches the list of meshes that the server offers, after the first picture is drawn. */
  async lookForOffers(): Promise<void> {
    try {
      const answer = await fetch('/page/samples.json');
      if (answer.ok) this.app.set({ offered: await answer.json() as Offered[] });
    } catch { /* the next request shows that the server is away */ }
  }
  async offered(offer: Offered): Promise<void> {
    this.app.set({ bringing: offer.name, problem: undefined });
    try {
      const answer = await fetch(`/page/${offer.file}`);
      if (!answer.ok) throw new Error(`${offer.name}: ${answer.status}`);
      const data = new Uint8Array(await answer.arrayBuffer()), { settings } = this.app.state.wish;
      await this.mesh({ name: offer.name, data }, offer.name, { fetched: true, wish: { settings: this.keepable(settings), hits: [] } });
    } catch (cause) {
      this.app.set({ bringing: undefined });
      const away = new FractureError({ type: 'client:server-absent', status: 0, title: words.problem.away, detail: words.problem.awayDetail, cause });
      this.app.failed(cause instanceof TypeError ? away : cause, () => void this.offered(offer), offer.name);
    }
  }

  /** Returns the source for these settings. A sample gets the look of its material, and the server receives it once per look. */
  async dressed(settings: Settings, signal?: AbortSignal): Promise<Source> {
    const { source } = this.app.state, material = String(settings['material'] ?? '');
    if (!source) throw new DOMException('', 'AbortError');
    if (!source.sample) return source;
    let dress = source.dresses.get(material);
    if (!dress) {
      const input = this.made(source.sample, settings), mesh = await this.app.service.client.put(input, { ask: false, ...(signal ? { signal } : {}), parameters: this.solidOf(settings) });
      source.dresses.set(material, dress = { ...source, input, mesh });
    }
    return dress;
  }
  /** Returns the mesh of an answer; undefined if the answer does not belong to the current mesh. */
  sourceOf({ mesh: { id } }: Answer): Source | undefined {
    const { source } = this.app.state;
    return source?.mesh.id === id ? source : [...source?.dresses.values() ?? []].find(({ mesh }) => mesh.id === id);
  }

  files({ files, label }: Dropped): void {
    // Opens one mesh with the files that belong to it; other meshes are left out.
    const [main, ...leftOut] = files.length > 1 ? meshesOf(files, this.app.service.knowledge?.limits.formats ?? []) : [];
    const taken = files.filter(file => !leftOut.includes(file)), short = ({ name }: { name: string }) => name.split('/').pop()!;
    const { wanted } = this.app.state, { settings } = this.app.state.wish;
    const wish = wanted?.wish ?? { settings: this.keepable(settings), hits: [] };
    void this.mesh(taken.length === 1 ? taken[0]! : taken, main ? short(main) : label, { main: taken.length === 1 ? undefined : main?.name, wish });
    if (main && leftOut.length > 0) this.app.set({ leftOut: { taken: short(main), others: leftOut.map(short) } });
  }

  async mesh(input: MeshInput, label: string, { sample, fetched = sample !== undefined, main, wish }: { sample?: string; fetched?: boolean; main?: string | undefined; wish: Wish }): Promise<void> {
    this.app.breaking.cancel();
    this.abort?.abort();
    const { signal } = this.abort = new AbortController(), { wanted } = this.app.state;
    this.app.set({ bringing: label, problem: undefined, refused: undefined, note: undefined, leftOut: undefined });
    this.refusedMesh = undefined;
    try {
      const size = input instanceof Object && 'data' in input ? sizeOf(input.data) : 0;
      const { client } = this.app.service, options = { signal, ask: size > ASK_FIRST, ...(main ? { main } : {}), parameters: this.solidOf(wish.settings) };
      const mesh = await client.put(input, options);
      if (wanted && wanted.mesh !== mesh.id) this.app.set({ note: `digest ${mesh.id}` });
      const whole = await mesh.fracture({ ...this.solidOf(wish.settings), sites: 1, physics: 'none' }, { signal });
      if (signal.aborted) return;
      const source: Source = { label, sample, fetched, input, main, mesh, dresses: new Map(), whole };
      source.dresses.set(String(wish.settings['material'] ?? ''), source);
      await this.present(source, wish);
    } catch (error) {
      if (signal.aborted) return;
      this.app.set({ bringing: undefined });
      const again = (thickness: number) => {
        const options = { ...(sample ? { sample } : {}), fetched, main, wish: { settings: { ...wish.settings, sheets: 'solid', thickness }, hits: [] } };
        void this.mesh(input, label, options);
      };
      if (this.app.service.solidParameters.has('thickness')) this.refusedMesh = again;
      if (isOfTheSolid(error)) await this.showRefused(input, main, wish);
      this.app.failed(error, () => void this.mesh(input, label, { ...(sample ? { sample } : {}), fetched, main, wish }), label);
    }
  }

  /** Shows the refused mesh as it is, so that users can see the problem's location in it. */
  private async showRefused(input: MeshInput, main: string | undefined, { settings }: Wish): Promise<void> {
    const files = (Symbol.iterator in Object(input) ? [...input as Iterable<unknown>] : [input]) as { name?: string; data?: Blob | Uint8Array }[];
    const file = files.find(({ name }) => name === main) ?? files[0], bytes = file?.data instanceof Blob ? new Uint8Array(await file.data.arrayBuffer()) : file?.data;
    const points = file?.name && bytes ? trianglesOf(file.name, bytes) : undefined;
    // If there is nothing to show instead, the previous mesh stays: a file that is not a mesh removes nothing.
    if (!points || points.length === 0) return;
    const { source, shown, wish, radius } = this.app.state;
    if (source && shown) this.before = { state: { source, shown, wish, radius }, restoreSteps: this.app.breaking.history.keep() };
    this.app.breaking.history.clear();
    this.app.playing.leave();
    this.app.set({ source: undefined, shown: undefined });
    this.app.view?.clear();
    this.app.view?.showRaw(framed(points, settings['unit'], settings['up']));
  }

  /** The name of the mesh that was shown before the refused mesh. */
  get replaced(): string | undefined {
    return this.app.state.source ? undefined : this.before?.state.source?.label;
  }
  async restore(): Promise<void> {
    const { before } = this;
    if (!before || this.replaced === undefined) return;
    this.before = undefined;
    this.app.set({ ...before.state, problem: undefined, refused: undefined });
    await this.app.view?.show(before.state.source!.whole, true);
    this.app.view?.repaired(before.state.source!.whole);
    this.app.view?.makeRoom(this.app.state.look.explode);
    before.restoreSteps();
    await this.app.breaking.showAnswer(before.state.shown!.answer, before.state.wish, 0, performance.now());
  }

  /** Opens a mesh that the server has, as a link requests. */
  async known(id: string, label: string, wish: Wish): Promise<void> {
    this.app.set({ bringing: label });
    try {
      const mesh = this.app.service.client.mesh(id), whole = await mesh.fracture({ ...this.solidOf(wish.settings), sites: 1, physics: 'none' });
      await this.present({ label, sample: undefined, fetched: false, input: undefined, main: undefined, mesh, dresses: new Map(), whole }, wish);
    } catch (error) {
      this.app.set({ bringing: undefined });
      if (error instanceof FractureError && error.problem === 'not-found') this.app.set({ wanted: { mesh: id, name: label, wish }, tab: 'mesh' });
      else this.app.failed(error, () => void this.known(id, label, wish));
    }
  }

  private async present(source: Source, wish: Wish): Promise<void> {
    const { wanted } = this.app.state;
    const note = wanted && wanted.mesh !== source.mesh.id ? 'digest' : undefined;
    this.app.breaking.history.clear();
    this.before = undefined;
    this.app.playing.leave();
    if (!source.sample) this.app.breaking.owns({});
    // A repair or a unit opens the same mesh again; its fragments keep the names that the user gave them.
    const names = source.mesh.id === this.app.state.source?.mesh.id ? this.app.state.names : new Map<number, string>();
    this.app.set({ source, bringing: undefined, shown: undefined, wanted: undefined, note, names });
    this.app.breaking.ask(wish);
    await this.app.view?.show(source.whole, true);
    this.app.view?.repaired(source.whole);
    this.app.view?.mark([]);
    this.app.set({ wish, radius: Number((0.12 * (this.app.view?.size ?? 1)).toPrecision(2)), look: { ...this.app.state.look, explode: firstState().look.explode, chosen: new Set(), hidden: new Set() } });
    this.app.view?.apply({ ...this.app.state.look, explode: 0 });
  }

  /** Returns the settings that shape the solid. */
  solidOf(settings: Settings): Settings {
    const names = this.app.service.solidParameters;
    return Object.fromEntries(Object.entries(settings).filter(([name]) => names.has(name)));
  }
  private knownSettings(settings: Settings): Settings {
    const names = new Set(this.app.service.parameters.map(({ name }) => name));
    return Object.fromEntries(Object.entries(settings).filter(([name]) => names.has(name)));
  }
  /** Returns the settings that also make sense for another mesh. These exclude points, regions and the material. */
  private keepable(settings: Settings): Settings {
    const solid = this.app.service.solidParameters;
    const kept = Object.fromEntries(Object.entries(withoutPlaces(settings, this.app.service.parameters)).filter(([name]) => !solid.has(name)));
    return this.app.breaking.startOf(kept);
  }
}

const sizeOf = (data: unknown): number => (data instanceof Blob ? data.size : (data as { byteLength?: number }).byteLength ?? 0);
