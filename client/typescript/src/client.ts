// The client for a server.
//
//     const client = new Client('http://127.0.0.1:8080');
//     const mesh = await client.put(file);
//     const answer = await mesh.fracture({ material: 'stone', fragments: 40 }, { signal });
import { Answer, type AnswerHead, headOf } from './answer.js';
import { type Asset, formOf, type MeshFormat, type MeshInput, readAsset } from './asset.js';
import { Job, type JobDocument, type JobState } from './jobs.js';
import { type FractureOptions, Mesh, type StoredMesh } from './mesh.js';
import type { OperationId } from './operations.js';
import { type Parameters, parametersText } from './parameters.js';
import { FractureError } from './problems.js';
import { type Ask, type CallOptions, Interrupted, json, type Reply, type Settings, Transport } from './transport.js';
import { now, Watch, within } from './watch.js';

/** A parameter as GET /limits and GET /patterns describe it. */
export interface ParameterDescription {
  name: string;
  type: string;
  description: string;
  [member: string]: any;
}
export interface Limits {
  max_body_bytes: number;
  deadline_ms: number;
  formats: string[];
  parameters: ParameterDescription[];
  [limit: string]: any;
}
export interface Patterns {
  patterns: { name: string; description: string; parameters: any[]; [member: string]: any }[];
  parameters: ParameterDescription[];
  materials: { name: string; description: string; parameters: Record<string, any>; [member: string]: any }[];
}

/** The client's record of a mesh that it sent, or looked for on the server. */
interface Put {
  pending?: Promise<unknown> | undefined;
  storedAt: number;
  stored?: StoredMesh;
}

interface JobPage {
  jobs: JobDocument[];
  next?: string;
}

export interface PutOptions extends CallOptions, MeshFormat {
  /** The parameters that shape the solid (`material`, `shell`, `repair`, `unit`, …) in later fractures. The server prepares the mesh
   * with these parameters. If a fracture has other values, the server prepares the mesh again. */
  parameters?: Parameters;
  /** Whether to ask if the server has the mesh before sending it. If the server does not have it, browsers log the 404 in their
   * console. Default: only for meshes over 64 KiB. */
  ask?: boolean;
}

/** Bytes. Smaller meshes are sent at once, because that is faster than asking. */
const SMALL = 1 << 16;

export class Client {
  private readonly transport: Transport;
  private readonly puts = new Map<string, Put>();
  private readonly assets = new Map<string, WeakRef<Asset>>();
  private formats: Promise<readonly string[]> | undefined;

  /** `url`: the server's address, which may include a path. Throws FractureError (bad-argument). */
  constructor(url: string | URL, settings: Settings = {}) {
    this.transport = new Transport(url, settings);
  }

  // -- meshes

  /** Stores a mesh on the server under its digest, unless the server already has it. Throws FractureError. */
  async put(input: MeshInput, { parameters, format, main, ask, ...call }: PutOptions = {}): Promise<Mesh> {
    const asset = await this.read(input, { format, main }, call), { stored } = this.puts.get(asset.id) ?? {};
    if (stored) return new Mesh(this, asset, asset.id, stored);
    const size = [asset.main, ...asset.files].reduce((sum, { data }) => sum + data.size, 0), left = within(call.deadline ?? this.deadline);
    if (ask ?? size > SMALL) {
      const mesh = new Mesh(this, asset, asset.id, undefined);
      try {
        this.putOf(asset.id).stored = await mesh.refresh(call);
        return mesh;
      } catch (error) {
        if (!(error instanceof FractureError) || error.problem !== 'not-found') throw error;
      }
    }
    const sent = await this.send(asset, parameters, { ...call, deadline: left() });
    return new Mesh(this, asset, sent.id, sent);
  }

  /** Returns a report on a mesh without fracturing it. The client sends the mesh, and the server stores it. Throws FractureError. */
  async inspect(input: MeshInput, { parameters, format, main, ...call }: PutOptions = {}): Promise<StoredMesh> {
    const body = formOf(await this.read(input, { format, main }, call), parameters && parametersText(parameters));
    return json<StoredMesh>(await this.request('postMesh', { ...call, body, headers: { 'Content-Type': body.type }, json: true }));
  }

  /** Returns the stored mesh with this digest ("sha256:…"). Sends no request. */
  mesh(id: string): Mesh {
    return new Mesh(this, this.assets.get(id)?.deref(), id, undefined);
  }

  /** Sends the mesh and parameters in one request; the server does not store the mesh. Use this call for a mesh that you fracture only
   * once. Throws FractureError. */
  async fracture(input: MeshInput, parameters: Parameters = {}, options: FractureOptions & MeshFormat = {}): Promise<Answer> {
    const { format, main, realtime, priority, ...call } = options;
    const body = formOf(await this.read(input, { format, main }, call), parametersText(parameters));
    const headers = {
      'Content-Type': body.type, Accept: 'model/gltf-binary', Priority: `u=${priority ?? (realtime ? 1 : 3)}`,
      'Request-Timeout': this.requestTimeout(call),
    };
    return this.answerOf(await this.request('postFracture', { ...call, body, headers }));
  }

  // -- results and jobs

  /** Returns an answer that is still in the server's cache. `location`: its address (/fractures/sha256:…) or id (sha256:…). Throws
   * FractureError (not-found). */
  async answer(location: string, call: CallOptions = {}): Promise<Answer> {
    const id = location.slice(location.lastIndexOf('/') + 1);
    return this.answerOf(await this.request('getFracture', { ...call, path: { id }, headers: { Accept: 'model/gltf-binary' } }));
  }

  /** Opens an answer that was saved as a GLB. You can hit the answer as long as the server has its mesh. Throws FractureError
   * (damaged-answer). */
  open(glb: Uint8Array): Answer {
    return this.answerOf({ bytes: glb, headers: new Headers(), exchanges: 0 });
  }

  /** Returns an existing job by its id. Throws FractureError (not-found). */
  async job(id: string, call: CallOptions = {}): Promise<Job> {
    return new Job(this, json<JobDocument>(await this.request('getJob', { ...call, path: { id }, json: true })));
  }

  /** Yields your jobs, newest first. `limit`: jobs per page, 1 to 100; further pages are fetched as needed. Throws FractureError. */
  async *jobs({ state, limit, ...call }: CallOptions & { state?: JobState; limit?: number } = {}): AsyncGenerator<Job, void, undefined> {
    for (let query: Ask['query'] = { state, limit: limit?.toString() }; ;) {
      const page: JobPage = json<JobPage>(await this.request('getJobs', { ...call, query, json: true }));
      for (const document of page.jobs) yield new Job(this, document);
      if (!page.next) return;
      query = Object.fromEntries(new URL(page.next, this.transport.base).searchParams);
    }
  }

  // -- discovery

  /** Returns the start page of the interface: the server's name, version and links. Throws FractureError. */
  async index(call: CallOptions = {}): Promise<Record<string, any>> {
    return this.discover('getIndex', call);
  }
  /** Returns the server version and the algorithm version. Throws FractureError. */
  async version(call: CallOptions = {}): Promise<{ name: string; version: string; algorithm: number }> {
    return this.discover('getVersion', call);
  }
  /** Returns the server's limits, every parameter with its range, and the formats that the server reads. Throws
   * FractureError. */
  async limits(call: CallOptions = {}): Promise<Limits> {
    return this.discover('getLimits', call);
  }
  /** Returns the server's patterns and materials, with their parameters. Throws FractureError. */
  async patterns(call: CallOptions = {}): Promise<Patterns> {
    return this.discover('getPatterns', call);
  }
  /** Returns the OpenAPI 3.1 description of the interface. Throws FractureError. */
  async openapi(call: CallOptions = {}): Promise<Record<string, any>> {
    return this.discover('getOpenapi', call);
  }
  /** Returns a text that explains an error and what to do about it. `problem`: the error's name or type. Throws FractureError. */
  async explain(problem: string, call: CallOptions = {}): Promise<string> {
    const name = problem.slice(problem.lastIndexOf('/') + 1);
    const { bytes } = await this.request('getProblem', { ...call, path: { name }, headers: { Accept: 'text/plain' } });
    return new TextDecoder().decode(bytes);
  }

  /** Sends any request of the interface, with this client's token, timeouts, retries and digest checks. Throws FractureError. */
  request(operation: OperationId, ask: Ask = {}): Promise<Reply> {
    return this.transport.request(operation, ask);
  }

  // -- for the other classes of this package

  /** @internal */
  get streams(): boolean {
    return this.transport.settings.streams ?? (typeof Response === 'function' && 'body' in Response.prototype);
  }
  /** @internal */
  get timeout(): number {
    return this.transport.settings.timeout ?? 60_000;
  }
  /** @internal */
  get deadline(): number {
    return this.transport.deadline;
  }
  /** Returns the value of Request-Timeout: the seconds after which this client no longer waits for the answer. @internal */
  requestTimeout({ timeout = this.timeout, deadline = this.transport.settings.deadline ?? Infinity }: CallOptions): string | undefined {
    const seconds = Math.min(timeout, deadline) / 1000;
    return seconds > 0 && seconds <= 86400 ? String(Number(seconds.toFixed(3))) : undefined;
  }
  /** @internal */
  stream(operation: OperationId, ask: Ask, idle: number): Promise<{ response: Response; watch: Watch }> {
    return this.transport.stream(operation, ask, idle);
  }
  /** @internal */
  interrupted(error: unknown, watch: Watch, idle: number, signal: AbortSignal | undefined): FractureError {
    return error instanceof FractureError ? error : new Interrupted(error, watch, true).as(this.transport.base, 1, idle, signal);
  }
  /** @internal */
  answerOf(reply: Pick<Reply, 'bytes' | 'headers' | 'exchanges'> | { bytes: Uint8Array; headers: Headers; exchanges: number }): Answer {
    const head: AnswerHead = headOf(reply);
    return new Answer(reply.bytes, head, id => this.mesh(id));
  }

  /** Sends a missing mesh after a 404. If several calls find the mesh missing at the same time, one sends it; the others wait and retry.
   * @internal */
  async putMissing(asset: Asset | undefined, sentAt: number, call: CallOptions): Promise<'retry' | 'retry-once' | 'give-up'> {
    if (!asset) return 'give-up';
    const put = this.putOf(asset.id);
    if (put.storedAt >= sentAt) return 'retry';
    if (put.pending) {
      const watch = new Watch(call.signal, call.deadline ?? Infinity);
      await watch.race(put.pending).catch(() => {});  // if sending failed, the next request shows it
      watch.release();
      return 'retry';
    }
    await this.send(asset, undefined, call);
    return 'retry-once';
  }

  /** Called after the mesh was deleted on the server. @internal */
  forget(id: string): void {
    this.puts.delete(id);
  }

  private async discover<Document>(operation: OperationId, call: CallOptions): Promise<Document> {
    return json<Document>(await this.request(operation, { ...call, headers: { Accept: 'application/json' }, json: true }));
  }

  private async read(input: MeshInput, format: MeshFormat, call: CallOptions): Promise<Asset> {
    const asset = await readAsset(input, format,
      () => (this.formats ??= this.limits(call).then(limits => limits.formats).catch(error => {
        this.formats = undefined;
        throw error;
      })));
    this.assets.set(asset.id, new WeakRef(asset));
    return asset;
  }

  private async send(asset: Asset, parameters: Parameters | undefined, call: CallOptions): Promise<StoredMesh> {
    const body = formOf(asset, parameters && parametersText(parameters));
    const ask = { ...call, body, headers: { 'Content-Type': body.type }, json: true };
    const put = this.putOf(asset.id);
    const sending = this.request('putMesh', { ...ask, path: { id: asset.id } }).catch((error: unknown) => {
      // A server that sorts the names of additional files differently computes another digest. The client then uses the server's digest.
      if (!(error instanceof FractureError) || error.problem !== 'digest-mismatch' || asset.files.length === 0) throw error;
      return this.request('postMesh', ask);
    });
    put.pending = sending;
    try {
      const stored = json<StoredMesh>(await sending);
      Object.assign(put, { storedAt: now(), stored });
      this.puts.set((asset.id = stored.id), put);
      this.assets.set(asset.id, new WeakRef(asset));
      return stored;
    } finally {
      put.pending = undefined;
    }
  }

  private putOf(id: string): Put {
    let put = this.puts.get(id);
    if (!put) this.puts.set(id, (put = { storedAt: -Infinity }));
    return put;
  }
}
