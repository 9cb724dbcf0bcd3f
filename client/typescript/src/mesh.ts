// A mesh that the server keeps under its content key, and fractures of it.
import type { Answer } from './answer.js';
import { type Asset, formOf } from './asset.js';
import type { Client } from './client.js';
import type { Figures } from './fragments.js';
import { Job, type JobDocument } from './jobs.js';
import { localError } from './problems.js';
import { type Parameters, parametersText } from './parameters.js';
import { type Ask, type CallOptions, json, type Reply } from './transport.js';

/** What the server says of a mesh that it keeps. */
export interface StoredMesh {
  id: string;
  format: string;
  /** Of the mesh and its further files. */
  bytes: number;
  /** How many further files it has. */
  files: number;
  /** Seconds after its last use until it is forgotten. */
  ttl_s: number;
  /** What it is worth: verdict (closed, repaired), solid, frame, nodes, materials, images, warnings. */
  report: Record<string, any>;
}

export interface FractureOptions extends CallOptions {
  /** For the moment of a collision: goes before batch work, and has a shorter deadline (realtime_deadline_ms of GET
   * /limits, 2 s). Default: false; of hits: true. */
  realtime?: boolean;
  /** RFC 9218, instead of `realtime`: 0 to 2 realtime, 3 to 7 batch. */
  priority?: number;
}

/** The server's limit for the body of a fracture of a stored mesh (max_parameters_bytes of GET /limits). */
const MOST_PARAMETERS = 4096;

export class Mesh {
  /** `asset`: the bytes, where this client has them; kept for a server that forgets the mesh. */
  constructor(private readonly client: Client, private readonly asset: Asset | undefined, /** "sha256:…" */ readonly id: string,
              /** As the server said it last; undefined where it was not asked. */ public stored: StoredMesh | undefined) {}

  get report(): Record<string, any> | undefined {
    return this.stored?.report;
  }

  /** Fractures it. `parameters` as GET /patterns lists them. A server that has forgotten the mesh gets it again. */
  async fracture(parameters: Parameters = {}, options: FractureOptions = {}): Promise<Answer> {
    const reply = await this.ask(parameters, options, { Accept: 'model/gltf-binary' });
    return this.client.answerOf(reply);
  }

  /** The figures alone, without geometry. */
  async figures(parameters: Parameters = {}, options: FractureOptions = {}): Promise<Figures> {
    return json<Figures>(await this.ask(parameters, options, { Accept: 'application/json' }));
  }

  /** The same as one JSON text with the buffer in a data URI (model/gltf+json). */
  async gltf(parameters: Parameters = {}, options: FractureOptions = {}): Promise<string> {
    return new TextDecoder().decode((await this.ask(parameters, options, { Accept: 'model/gltf+json' })).bytes);
  }

  /** Starts a job: work that nobody waits for on a connection, with a deadline of its own (30 minutes). `wait`: seconds in
   * which the answer may come at once. */
  async job(parameters: Parameters = {}, { wait, ...options }: CallOptions & { wait?: number } = {}): Promise<Job> {
    const prefer = wait === undefined ? 'respond-async' : `respond-async, wait=${wait}`;
    const reply = await this.ask(parameters, options, { Accept: 'model/gltf-binary', Prefer: prefer });
    return reply.status === 202 ? new Job(this.client, json<JobDocument>(reply)) : Job.done(this.client, this.client.answerOf(reply));
  }

  /** What the server keeps of it now. FractureError (not-found) where it has forgotten it. */
  async refresh(options: CallOptions = {}): Promise<StoredMesh> {
    return (this.stored = json<StoredMesh>(await this.client.request('getMesh', { ...options, path: { id: this.id }, json: true })));
  }

  /** Makes the server forget it. */
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
    // Points of a pattern, say: they go with the mesh, as a form.
    if (!asset)
      throw localError('bad-argument',
        `The parameters have over ${MOST_PARAMETERS} bytes, which go with the bytes of the mesh alone: put() it first.`,
        { parameter: 'parameters' });
    const body = formOf(asset, text);
    return this.client.request('postFracture', { ...call, headers: { ...headers, 'Content-Type': body.type }, body });
  }
}
