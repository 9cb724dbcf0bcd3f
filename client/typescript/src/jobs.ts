// Jobs: long fractures that the server computes in the background.
import type { Answer } from './answer.js';
import type { Client } from './client.js';
import { EventParser } from './events.js';
import { FractureError, problemIn, type ProblemDocument } from './problems.js';
import { type CallOptions, json } from './transport.js';

export type JobState = 'queued' | 'running' | 'done' | 'failed' | 'cancelled';

export interface JobDocument {
  id: string;
  state: JobState;
  stage: '' | 'import' | 'prepare' | 'tetrahedralize' | 'clip' | 'encode';
  /** 0 to 100; never decreases while the server runs. */
  percent: number;
  created: string;
  finished?: string;
  /** True if the job survives a restart of the server. */
  durable: boolean;
  /** Number of jobs ahead while this job is queued. */
  queue_position?: number;
  /** The address of the answer, if the job is done. */
  result?: string;
  error?: ProblemDocument;
  links: { self?: string; events?: string };
}

const KEEP_ALIVE = 30_000;  // ms without a byte, after which a stream is considered broken; the server sends something every 10 s
const STREAMS = 3;          // after this many broken streams, the job is only polled
const WAIT = 20;            // s; maximum time that a poll waits for the job to finish

export class Job {
  private answer: Answer | undefined;

  constructor(private readonly client: Client, /** The last known state. */ public document: JobDocument) {}

  /** Returns a finished job for an answer that arrived at once. The server has no such job. */
  static done(client: Client, answer: Answer): Job {
    const created = new Date().toISOString();
    const job = new Job(client, { id: '', state: 'done', stage: 'encode', percent: 100, created, durable: false, links: {} });
    job.answer = answer;
    return job;
  }

  get id(): string {
    return this.document.id;
  }
  get state(): JobState {
    return this.document.state;
  }
  get percent(): number {
    return this.document.percent;
  }
  /** Whether the job is done, failed or cancelled. */
  get finished(): boolean {
    return this.state === 'done' || this.state === 'failed' || this.state === 'cancelled';
  }

  /** Asks the server for the state, and returns it. `wait`: maximum time (s) that the server waits for the job to finish before it
   * responds. Throws FractureError. */
  async refresh({ wait, ...options }: CallOptions & { wait?: number } = {}): Promise<JobDocument> {
    if (this.id === '') return this.document;
    const headers = { Prefer: wait === undefined ? undefined : `wait=${wait}` };
    const reply = await this.client.request('getJob', { ...options, headers, path: { id: this.id }, json: true });
    return (this.document = json<JobDocument>(reply));
  }

  /** Yields the state whenever it changes, until the job has finished. Uses server-sent events, or polls the server if event streams are
   * unavailable or break. Aborting ends the iteration, not the job. Throws FractureError. */
  async *progress(options: CallOptions = {}): AsyncGenerator<JobDocument, void, undefined> {
    yield this.document;
    for (let broken = 0; !this.finished;) {
      if (broken < STREAMS && this.client.streams) {
        try {
          for await (const document of this.events(options)) yield (this.document = document);
        } catch (error) {
          if (!(error instanceof FractureError) || error.problem === 'aborted') throw error;
          if (error.status !== 0 && error.status !== 429 && error.status !== 503) throw error;
        }
        ++broken;
      }
      if (this.finished) return;
      // The server must not wait longer than the timeout of the request.
      const wait = Math.max(1, Math.min(WAIT, Math.floor((options.timeout ?? this.client.timeout) / 2000)));
      const before = JSON.stringify(this.document);
      await this.refresh({ ...options, wait });
      if (JSON.stringify(this.document) !== before) yield this.document;
    }
  }

  /** Waits for the job and returns its answer. Throws FractureError if the job failed or was cancelled. Aborting ends the wait, not
   * the job. */
  async result({ onProgress, ...options }: CallOptions & { onProgress?: (job: JobDocument) => void } = {}): Promise<Answer> {
    if (this.answer) return this.answer;
    for await (const document of this.progress(options)) onProgress?.(document);
    if (this.document.error) throw problemIn(this.document.error);
    return (this.answer = await this.client.answer(this.document.result!, options));
  }

  /** Cancels the job, or deletes it if it has finished. Throws FractureError. */
  async cancel(options: CallOptions = {}): Promise<void> {
    if (this.id !== '') await this.client.request('deleteJob', { ...options, path: { id: this.id } });
  }

  private async *events({ signal }: CallOptions): AsyncGenerator<JobDocument, void, undefined> {
    const ask = { signal, path: { id: this.id }, headers: { Accept: 'text/event-stream' } };
    const { response, watch } = await this.client.stream('getJobEvents', ask, KEEP_ALIVE);
    const reader = response.body?.getReader(), parser = new EventParser(), utf8 = new TextDecoder();
    try {
      while (reader) {
        const { done, value } = await watch.race(reader.read());
        if (done) return;
        watch.restart();
        for (const { data } of parser.push(utf8.decode(value, { stream: true }))) yield JSON.parse(data) as JobDocument;
      }
    } catch (error) {
      throw this.client.interrupted(error, watch, KEEP_ALIVE, signal);
    } finally {
      watch.release();
      reader?.cancel().catch(() => {});
    }
  }
}
