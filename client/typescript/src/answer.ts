// The fragments that the server returns, with methods to hit them again.
import { Glb, type Vector3 } from './glb.js';
import { type Bond, bondsOf, type Dropped, type Figures, figuresOf, type Fragment, fragmentsOf, passedThrough, type Piece, rootOf } from './fragments.js';
import { merge } from './merge.js';
import type { Choice, FractureOptions, Mesh } from './mesh.js';
import type { Parameters } from './parameters.js';
import { FractureError, localError } from './problems.js';
import type { Reply } from './transport.js';
import { within } from './watch.js';

/** The data from an answer's header fields. */
export interface AnswerHead {
  /** The address of the answer, valid while the answer is in the server's cache: /fractures/sha256:… */
  location: string | undefined;
  etag: string | undefined;
  requestId: string | undefined;
  /** The time in milliseconds for each stage: queue, import, prepare, tetrahedralize, clip, encode. `work` is the total without the queue. */
  timing: Record<string, number>;
  /** The caches that contained the answer (Cache-Status, RFC 9211). */
  cacheStatus: string | undefined;
  /** Number of HTTP requests, retries included. */
  exchanges: number;
}

export interface HitOptions extends FractureOptions {
  /** Number of cells with which a hit cuts fragments into pieces: one number for all hits, or one per hit. Default: the server's, 30. */
  sites?: number | readonly number[];
  /** Further parameters of a hit: `gravity`, `broken`. */
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
  /** The bytes of the GLB file. */
  readonly glb: Uint8Array;
  /** The parsed file: JSON and typed arrays. */
  readonly document: Glb;
  /** The object under extras.fracture of the root node: parameters, report, certificate, bonds, … */
  readonly figures: Figures;
  /** The mesh that was fractured. */
  readonly mesh: Mesh;
  private readFragments: Fragment[] | undefined;
  private byId: Map<number, Fragment> | undefined;
  private readBonds: Bond[] | undefined;

  /** Throws FractureError (damaged-answer) if `glb` is not a file from a fracture server. */
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
  /** All parameters of the answer, including those set by the material. */
  get parameters(): Record<string, any> {
    return this.figures.parameters;
  }
  /** The report's warnings. Each says what happened, how it affects the result, and what to do. */
  get warnings(): readonly string[] {
    return this.figures.report.warnings ?? [];
  }
  /** The report's notes about what the server did. They need no action. Servers with algorithm 22 or older put notes among the
   * warnings. */
  get notes(): readonly string[] {
    return this.figures.report.notes ?? [];
  }
  /** Things in the source that the answer does not contain, such as lights and animations. */
  get dropped(): readonly Dropped[] {
    return this.figures.report.dropped ?? [];
  }
  /** Changes that the server offers but did not make: another unit, walls for a room, … */
  get choices(): readonly Choice[] {
    return (this.figures.report['choices'] ?? []) as Choice[];
  }
  /** The position of the root node (m). To get a position in the mesh's file, add this to a position in the answer. [0, 0, 0] unless
   * the mesh is far from its origin. Renderers and physics engines use floats, so keep such a mesh near the origin there. */
  get offset(): Vector3 {
    return rootOf(this.document)?.translation ?? [0, 0, 0];
  }
  get fragments(): readonly Fragment[] {
    return (this.readFragments ??= fragmentsOf(this.document, this.figures));
  }
  /** The connections between fragments. */
  get bonds(): readonly Bond[] {
    return (this.readBonds ??= bondsOf(this.figures));
  }
  /** The mesh nodes that were left uncut. */
  get passedThrough(): Piece[] {
    return passedThrough(this.document, this.figures);
  }
  /** Returns the fragment with this id; undefined if no fragment has it. */
  fragment(id: number): Fragment | undefined {
    this.byId ??= new Map(this.fragments.map(fragment => [fragment.id, fragment]));
    return this.byId.get(id);
  }
  /** Returns the GLB file as a Blob, for saving or loading it. */
  blob(): Blob {
    return new Blob([this.glb as BlobPart], { type: 'model/gltf-binary' });
  }

  /** Breaks the fragments within `radius` (m) of `point` (m, in the answer's coordinates, before any fragment moved). Returns an answer
   * with all fragments. Several points are hits in sequence. The result equals the server's answer with delta=stated, but the server
   * usually sends only the changes. `figures.delta` lists the new, changed and removed ids. The request is realtime by default.
   * Throws FractureError. */
  async hit(point: Vector3 | readonly Vector3[], radius: number | readonly number[], hitOptions: HitOptions = {}): Promise<Answer> {
    const { sites, parameters, ...options } = hitOptions;
    const given = (typeof point[0] === 'number' ? [point] : point) as readonly Vector3[], [x, y, z] = this.offset;
    const points = given.map((place): Vector3 => [place[0] + x, place[1] + y, place[2] + z]);  // parameters use the file's coordinates
    const hit: Parameters = { ...parameters, local_point: points, local_radius: radius, local_sites: sites };
    const left = within(options.deadline ?? this.mesh.deadline);
    const ask = (delta: 'only' | 'stated') =>
      this.again({ ...hit, delta }, () => this.hitAsParameters(hit, points.length, delta), { realtime: true, ...options }, left);
    let changes: Answer;
    if (this.wholeOnly()) return ask('stated');
    try {
      changes = await ask('only');
    } catch (error) {
      // The server refuses the parameter `delta` if it cannot send a delta.
      if (error instanceof FractureError && error.problem === 'bad-parameter' && error.parameter === 'delta') return ask('stated');
      throw error;
    }
    const whole = merge(this.document, changes.document);
    return whole ? new Answer(whole, changes.head, this.meshOf) : ask('stated');
  }

  /** Breaks a single fragment again. The new answer contains only this fragment's parts, at the fragment's position. Throws FractureError. */
  async refracture(fragment: number, more: FractureOptions & { sites?: number; seed?: number } = {}): Promise<Answer> {
    const { sites, seed, ...options } = more, own: Parameters = { fragment, fragment_sites: sites, fragment_seed: seed };
    const left = within(options.deadline ?? this.mesh.deadline);
    return this.again(own, () => ({ ...this.parametersWithoutDelta(), ...own }), { realtime: true, ...options }, left);
  }

  /** Sends a request that refers to this answer's address. If the server has forgotten the answer, sends all parameters
   * instead of the address. The result has the same bytes. */
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

  /** Returns whether a hit needs the whole answer instead of a delta. With levels or anchors, it does, because a hit can change these in
   * all fragments. With interior detail, it does, because a delta lacks the tangents that the texture maps of the cuts need. */
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
      throw localError('bad-argument', 'This answer has only the pieces of one fragment and cannot be hit. Hit the answer that has ' +
        'all fragments.', { parameter: 'fragment' });
    return {
      ...parameters, ...more, delta, local_new: count, local_rest: local_rest ?? 'fractured',
      local_point: [...points, ...(local_point as readonly Vector3[])], local_radius: [...radii, ...all(local_radius, 0)],
      local_sites: [...sites, ...all(local_sites, 30)],
    };
  }
}
