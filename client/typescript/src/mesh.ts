// A mesh that is stored on the server under its digest, and its fractures.
import type { Answer } from './answer.js';
import { type Asset, formOf } from './asset.js';
import type { Client } from './client.js';
import type { Dropped, Figures } from './fragments.js';
import { Job, type JobDocument } from './jobs.js';
import { localError } from './problems.js';
import { type Parameters, parametersText } from './parameters.js';
import { type Ask, type CallOptions, json, type Reply } from './transport.js';

/** A change that the server only offers, because it changes what the mesh is. To get it, fracture with its parameters. */
export interface Choice {
  kind: 'unit' | 'room' | 'lid' | 'crack';
  /** Values by parameter name. */
  parameters: Record<string, number | string>;
  /** States what was found, and the effect of the parameters. */
  text: string;
}

/** An estimate of an answer and its cost. The numbers are usually correct within a factor of two. */
export interface Estimate {
  sites: number;
  fragments: number;
  /** Triangles of all fragments. */
  triangles: number;
  /** Size of the GLB. */
  bytes: number;
  working_bytes: number;
  /** The working memory that a computation may use; null: no limit. */
  limit_bytes: number | null;
  /** False if the server would refuse the fracture at once. */
  fits: boolean;
  /** The parameter that takes most of the memory; null if the mesh itself does. */
  costliest: string | null;
  /** If working_bytes exceeds limit_bytes: the reason, and what to change. Otherwise null. */
  advice: string | null;
}

/** The server's description of a stored mesh. */
export interface StoredMesh {
  id: string;
  format: string;
  /** Total bytes of the mesh and its additional files. */
  bytes: number;
  /** Number of additional files. */
  files: number;
  /** Seconds from the last use until the server forgets the mesh. */
  ttl_s: number;
  /** The report on the mesh: verdict (closed, repaired), solid, volume_once, frame, nodes, materials, images, warnings, notes, choices, dropped, and contacts between parts. */
  report: Record<string, any>;
}

export interface FractureOptions extends CallOptions {
  /** For games: the request is served before batch work, with a shorter deadline (realtime_deadline_ms in GET /limits; 2 s by default).
   * Default: true for hits, otherwise false. */
  realtime?: boolean;
  /** The RFC 9218 priority, instead of `realtime`: 0 to 2 are realtime, 3 to 7 are batch work. */
  priority?: number;
}

/** The server's limit for the body of a request that fractures a stored mesh (max_parameters_bytes in GET /limits). */
const MOST_PARAMETERS = 64 * 1024;

export class Mesh {
  /** `asset`: the files to send again if the server forgets the mesh; undefined if this client does not have the files. */
  constructor(private readonly client: Client, private readonly asset: Asset | undefined, /** "sha256:…" */ readonly id: string,
              /** The last known description; undefined before the first request. */ public stored: StoredMesh | undefined) {}

  get report(): Record<string, any> | undefined {
    return this.stored?.report;
  }

  /** Changes that the server offers for this mesh, but makes only on request. */
  get choices(): readonly Choice[] {
    return (this.report?.['choices'] ?? []) as Choice[];
  }
  /** Things in the file that answers do not contain, such as lights and animations. Empty before the server has described the mesh. */
  get dropped(): readonly Dropped[] {
    return (this.report?.['dropped'] ?? []) as Dropped[];
  }

  /** Breaks the mesh. `parameters`: see GET /patterns. If the server has forgotten the mesh, the client sends it
   * again. Throws FractureError. */
  async fracture(parameters: Parameters = {}, options: FractureOptions = {}): Promise<Answer> {
    const reply = await this.ask(parameters, options, { Accept: 'model/gltf-binary' });
    return this.client.answerOf(reply);
  }

  /** Breaks the mesh and returns only the data, not the geometry. Throws FractureError. */
  async figures(parameters: Parameters = {}, options: FractureOptions = {}): Promise<Figures> {
    return json<Figures>(await this.ask(parameters, options, { Accept: 'application/json' }));
  }

  /** Breaks the mesh and returns a single JSON document, with the buffer in a data URI (model/gltf+json). Throws
   * FractureError. */
  async gltf(parameters: Parameters = {}, options: FractureOptions = {}): Promise<string> {
    return new TextDecoder().decode((await this.ask(parameters, options, { Accept: 'model/gltf+json' })).bytes);
  }

  /** Starts a job: background work with its own deadline (30 minutes by default). `wait`: maximum time (s) that the server
   * waits for the answer before it responds. Throws FractureError. */
  async job(parameters: Parameters = {}, { wait, ...options }: CallOptions & { wait?: number } = {}): Promise<Job> {
    const prefer = wait === undefined ? 'respond-async' : `respond-async, wait=${wait}`;
    const reply = await this.ask(parameters, options, { Accept: 'model/gltf-binary', Prefer: prefer });
    return reply.status === 202 ? new Job(this.client, json<JobDocument>(reply)) : Job.done(this.client, this.client.answerOf(reply));
  }

  /** Estimates the answer of fracture() with these parameters, without computing it. Throws FractureError. */
  async estimate(parameters: Parameters = {}, options: CallOptions = {}): Promise<Estimate> {
    return json<Estimate>(await this.client.request('postMeshEstimate', {
      ...options, json: true, path: { id: this.id }, body: parametersText(parameters), headers: { 'Content-Type': 'application/json' },
      onMissing: (sentAt, left) => this.client.putMissing(this.asset, sentAt, { ...options, deadline: left }),
    }));
  }

  /** Fetches the server's description of the mesh. Throws FractureError (not-found) if the server has forgotten it. */
  async refresh(options: CallOptions = {}): Promise<StoredMesh> {
    return (this.stored = json<StoredMesh>(await this.client.request('getMesh', { ...options, path: { id: this.id }, json: true })));
  }

  /** Deletes the mesh on the server. Throws FractureError. */
  async delete(options: CallOptions = {}): Promise<void> {
    await this.client.request('deleteMesh', { ...options, path: { id: this.id } });
    this.stored = undefined;
    this.client.forget(this.id);
  }

  /** @internal */
  get deadline(): number {
    return this.client.deadline;
  }

  private ask(parameters: Parameters, { realtime, priority, ...call }: FractureOptions, fields: Record<string, string>): Promise<Reply> {
    const text = parametersText(parameters), { asset } = this;
    const headers: Ask['headers'] = { ...fields, 'Content-Type': 'application/json' };
    if (!fields['Prefer']) {
      headers['Priority'] = `u=${priority ?? (realtime ? 1 : 3)}`;
      headers['Request-Timeout'] = this.client.requestTimeout(call);
    }
    if (new TextEncoder().encode(text).length <= MOST_PARAMETERS)
      return this.client.request('postMeshFracture', {
        ...call, headers, path: { id: this.id }, body: text,
        onMissing: (sentAt, left) => this.client.putMissing(asset, sentAt, { ...call, deadline: left }),
      });
    // Long parameters, such as a pattern's points, are sent in a form together with the mesh.
    if (!asset)
      throw localError('bad-argument',
        `The parameters have more than ${MOST_PARAMETERS.toLocaleString('en')} bytes, so they must be sent together with the mesh, ` +
        'which this client does not have. Call put() with the mesh first.',
        { parameter: 'parameters' });
    const body = formOf(asset, text);
    return this.client.request('postFracture', { ...call, headers: { ...headers, 'Content-Type': body.type }, body });
  }
}
