// Fragments as the service gave them, and what is asked about them again.
import { Glb, type Vector3 } from './glb.js';
import { type Bond, bondsOf, type Figures, figuresOf, type Fragment, fragmentsOf, passedThrough, type Piece } from './fragments.js';
import { merge } from './merge.js';
import type { FractureOptions, Mesh } from './mesh.js';
import type { Parameters } from './parameters.js';
import { FractureError, localError } from './problems.js';
import type { Reply } from './transport.js';
import { within } from './watch.js';

/** What the headers of an answer say. */
export interface AnswerHead {
  /** Where the answer can be had again while it is cached: /fractures/sha256:… */
  location: string | undefined;
  etag: string | undefined;
  requestId: string | undefined;
  /** Milliseconds in each stage: queue, import, prepare, tetrahedralize, clip, encode; work: all without the queue. */
  timing: Record<string, number>;
  /** RFC 9211: which caches had it. */
  cacheStatus: string | undefined;
  /** HTTP requests that it took. */
  exchanges: number;
}

export interface HitOptions extends FractureOptions {
  /** Sites that each hit adds, or one number for each of them. Default: the server's, 30. */
  sites?: number | readonly number[];
  /** What else may be given beside a hit: `gravity`, `broken`. */
  parameters?: Parameters;
}

export function headOf({ headers, exchanges }: Pick<Reply, 'headers' | 'exchanges'>): AnswerHead {
  const timing: Record<string, number> = {};
  const stages = (headers.get('server-timing') ?? '').matchAll(/([\w-]+)\s*;[^,]*?dur=(\d+(?:\.\d+)?)(?=\s*(?:[,;]|$))/g);
  for (const [, stage, milliseconds] of stages) timing[stage!] = Number(milliseconds);
  const text = (name: string) => headers.get(name) ?? undefined;
  return {
    location: text('content-location'), etag: text('etag'), requestId: text('x-request-id'), cacheStatus: text('cache-status'),
    timing, exchanges,
  };
}

export class Answer {
  /** The whole file, as it is saved. */
  readonly glb: Uint8Array;
  /** Its JSON and typed arrays. */
  readonly document: Glb;
  /** The object under extras.fracture of the root node: parameters, report, certificate, bonds, … */
  readonly figures: Figures;
  /** The mesh that was fractured. */
  readonly mesh: Mesh;
  private readFragments: Fragment[] | undefined;
  private byId: Map<number, Fragment> | undefined;
  private readBonds: Bond[] | undefined;

  /** Throws FractureError (damaged-answer) for what the service did not write. */
  constructor(glb: Uint8Array, readonly head: AnswerHead, private readonly meshOf: (id: string) => Mesh) {
    this.document = new Glb(glb);
    this.glb = this.document.bytes;
    this.figures = figuresOf(this.document);
    this.mesh = meshOf(this.figures.mesh);
  }

  get location(): string | undefined {
    return this.head.location;
  }
  get report(): Figures['report'] {
    return this.figures.report;
  }
  get certificate(): Figures['certificate'] {
    return this.figures.certificate;
  }
  /** What the answer was made with: all of them, those of the material too. */
  get parameters(): Record<string, any> {
    return this.figures.parameters;
  }
  get warnings(): readonly string[] {
    return this.figures.report.warnings ?? [];
  }
  get fragments(): readonly Fragment[] {
    return (this.readFragments ??= fragmentsOf(this.document, this.figures));
  }
  /** Which fragments hold together. */
  get bonds(): readonly Bond[] {
    return (this.readBonds ??= bondsOf(this.figures));
  }
  /** Nodes of the mesh that were not to be fractured. */
  get passedThrough(): Piece[] {
    return passedThrough(this.document, this.figures);
  }
  fragment(id: number): Fragment | undefined {
    this.byId ??= new Map(this.fragments.map(fragment => [fragment.id, fragment]));
    return this.byId.get(id);
  }
  /** The file as a Blob, to be saved or loaded. */
  blob(): Blob {
    return new Blob([this.glb as BlobPart], { type: 'model/gltf-binary' });
  }

  /** Breaks what is near `point` (metres, in the frame of the mesh, where nothing has moved yet) within `radius`; several
   * hits come one after the other. Only what changed travels; the result is the whole, equal to what the service gives
   * with delta=stated. Its `figures.delta` says which fragments are new, changed and gone. Realtime unless said otherwise. */
  async hit(point: Vector3 | readonly Vector3[], radius: number | readonly number[], hitOptions: HitOptions = {}): Promise<Answer> {
    const { sites, parameters, ...options } = hitOptions;
    const points = (typeof point[0] === 'number' ? [point] : point) as readonly Vector3[];
    const hit: Parameters = { ...parameters, local_point: points, local_radius: radius, local_sites: sites };
    const left = within(options.deadline ?? this.mesh.deadline);
    const ask = (delta: 'only' | 'stated') =>
      this.again({ ...hit, delta }, () => this.hitAsParameters(hit, points.length, delta), { realtime: true, ...options }, left);
    let changes: Answer;
    if (this.wholeOnly()) return ask('stated');
    try {
      changes = await ask('only');
    } catch (error) {
      // Where there is no delta the service says so by this parameter.
      if (error instanceof FractureError && error.problem === 'bad-parameter' && error.parameter === 'delta') return ask('stated');
      throw error;
    }
    const whole = merge(this.document, changes.document);
    return whole ? new Answer(whole, changes.head, this.meshOf) : ask('stated');
  }

  /** Fractures one fragment again: its parts are the answer, where the fragment was. */
  async refracture(fragment: number, more: FractureOptions & { sites?: number; seed?: number } = {}): Promise<Answer> {
    const { sites, seed, ...options } = more, own: Parameters = { fragment, fragment_sites: sites, fragment_seed: seed };
    const left = within(options.deadline ?? this.mesh.deadline);
    return this.again(own, () => ({ ...this.parametersWithoutDelta(), ...own }), { realtime: true, ...options }, left);
  }

  /** By the address of this answer; where the server does not know it any more, by its parameters: the bytes are the same. */
  private async again(more: Parameters, parameters: () => Parameters, options: FractureOptions, left: () => number): Promise<Answer> {
    const { location, mesh } = this;
    if (location !== undefined) {
      try {
        return await mesh.fracture({ ...more, of: location }, { ...options, deadline: left() });
      } catch (error) {
        if (!(error instanceof FractureError) || error.problem !== 'no-such-answer') throw error;
      }
    }
    return mesh.fracture(parameters(), { ...options, deadline: left() });
  }

  /** Levels and anchors are about all fragments; with maps of the cuts a delta has not the tangents that they need. */
  private wholeOnly(): boolean {
    const { interior_detail: detail, ...names } = this.parameters;
    return this.figures.levels !== undefined || (detail ?? 'none') !== 'none' ||
           Object.keys(names).some(name => name.startsWith('anchor_'));
  }

  private parametersWithoutDelta(): Record<string, any> {
    const { delta: _, local_new: __, ...parameters } = this.parameters;
    return parameters;
  }

  private hitAsParameters({ local_point, local_radius, local_sites, ...more }: Parameters, count: number, delta: string): Parameters {
    const { local_point: points = [], local_radius: radii = [], local_sites: sites = [], local_rest, ...parameters } =
      this.parametersWithoutDelta();
    const all = (value: unknown, otherwise: number): number[] =>
      Array.isArray(value) ? value.length === 1 ? Array(count).fill(value[0]) : value : Array(count).fill(value ?? otherwise);
    if (parameters['fragment'] !== undefined)
      throw localError('bad-argument', 'This answer has the parts of one fragment; hits need a whole one.', { parameter: 'fragment' });
    return {
      ...parameters, ...more, delta, local_new: count, local_rest: local_rest ?? 'fractured',
      local_point: [...points, ...(local_point as readonly Vector3[])], local_radius: [...radii, ...all(local_radius, 0)],
      local_sites: [...sites, ...all(local_sites, 30)],
    };
  }
}
