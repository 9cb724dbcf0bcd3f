// Sends a request and retries it: after growing pauses if the server is absent, after the server's Retry-After if it is busy, at once
// if an answer is cut off or has a wrong digest. All requests can be repeated safely, because identical requests give identical bytes.
import { operations, type Operation, type OperationId } from './operations.js';
import { FractureError, localError, problemOf } from './problems.js';
import { digestMatches } from './sha256.js';
import { abortedError, now, pause, Watch } from './watch.js';

export interface Settings {
  /** Sent as `Authorization: Bearer …`. A function is called before each request. */
  token?: string | (() => string | Promise<string>);
  /** Used instead of the global fetch. */
  fetch?: typeof globalThis.fetch;
  /** Milliseconds for one request and its response, from the first byte sent to the last byte received. Default: 60000. */
  timeout?: number;
  /** Milliseconds for one call, retries included. Default: 120000. */
  deadline?: number;
  /** Maximum number of retries of one call. Default: 8. */
  retries?: number;
  /** Maximum size of an answer in bytes. Default: 256 MiB. */
  maxAnswerBytes?: number;
  /** Whether answers may be compressed. A browser unpacks compressed answers, so the client cannot check their Repr-Digest, which covers
   * the compressed bytes. The client checks all other answers. Default: false. */
  compressed?: boolean;
  /** Whether the platform can read a body while it arrives. If not, the client polls the progress of jobs. Default: detected. */
  streams?: boolean;
  /** Additional header fields for every request. */
  headers?: Record<string, string>;
}

/** Settings of a single call. */
export interface CallOptions {
  /** Aborts the call and its request. */
  signal?: AbortSignal | undefined;
  /** Milliseconds for one request and its response. Default: the client's. */
  timeout?: number | undefined;
  /** Milliseconds for the call, retries included. Default: the client's. */
  deadline?: number | undefined;
  /** Maximum number of retries. Default: the client's. */
  retries?: number | undefined;
}

export interface Ask extends CallOptions {
  path?: Record<string, string>;
  query?: Record<string, string | undefined>;
  headers?: Record<string, string | undefined>;
  body?: Blob | string;
  /** True if the response must be JSON. Any other response is treated as damaged. */
  json?: boolean;
  /** Called after a 404 with the problem not-found; decides whether to retry. `sentAt`: time of the request, as returned by now();
   * `left`: ms until the deadline. */
  onMissing?: (sentAt: number, left: number) => Promise<'retry' | 'retry-once' | 'give-up'>;
}

export interface Reply {
  status: number;
  headers: Headers;
  bytes: Uint8Array<ArrayBuffer>;
  /** Number of HTTP requests, retries included. */
  exchanges: number;
}

/** Parses the JSON in the reply to a request with `json`. */
export function json<Document>({ bytes }: Reply): Document {
  return JSON.parse(new TextDecoder().decode(bytes)) as Document;
}

const FIRST_PAUSE = 50, LONGEST_PAUSE = 1000;  // ms before a retry if the server is unreachable or busy; the pause doubles
const DAMAGED_ANSWERS = 3;                     // a call fails after this many damaged answers
const WRONG_SERVER = 'Check whether the address is that of a fracture server.';

const textOf = (error: unknown): string => {
  if (!(error instanceof Error)) return String(error);
  const cause = error.cause as { code?: string; message?: string } | undefined;
  return [error.message, cause?.code ?? cause?.message].filter(Boolean).join(': ');
};

export class Transport {
  readonly base: URL;

  constructor(url: string | URL, readonly settings: Settings) {
    // In a page the address may be relative: '' is the page's own server.
    const here = (globalThis as { location?: { href?: string } }).location?.href;
    try {
      this.base = new URL(url, here);
    } catch (cause) {
      throw localError('bad-argument', `'${url}' is not the address of a server. Write it like http://127.0.0.1:8080.`,
        { parameter: 'url', cause });
    }
    if (!/^https?:$/.test(this.base.protocol))
      throw localError('bad-argument', `The address '${url}' must begin with http:// or https://.`, { parameter: 'url' });
    if (this.base.username || this.base.password)
      throw localError('bad-argument', 'The address contains a user name or password, which cannot be sent. Use `token` or `headers` instead.',
        { parameter: 'url' });
    this.base.search = this.base.hash = '';
    if (!settings.fetch && typeof globalThis.fetch !== 'function')
      throw localError('bad-argument', 'This platform has no fetch(). Pass one in the settings, or use node 18 or newer.',
        { parameter: 'fetch' });
  }

  get deadline(): number {
    return this.settings.deadline ?? 120_000;
  }

  urlOf(operation: OperationId, ask: Pick<Ask, 'path' | 'query'>): string {
    const path = operations[operation].path.replace(/\{(\w+)\}/g, (_, name: string) =>
      encodeURIComponent(ask.path?.[name] ?? '').replaceAll('%3A', ':'));
    const url = new URL(this.base);
    url.pathname = this.base.pathname.replace(/\/$/, '') + path;
    for (const [name, value] of Object.entries(ask.query ?? {})) if (value !== undefined) url.searchParams.set(name, value);
    return url.href;
  }

  /** Sends a request, with retries, until it succeeds. Throws FractureError. */
  async request(operation: OperationId, ask: Ask = {}): Promise<Reply> {
    const { good, digest }: Operation = operations[operation];
    const timeout = ask.timeout ?? this.settings.timeout ?? 60_000, retries = ask.retries ?? this.settings.retries ?? 8;
    const end = now() + (ask.deadline ?? this.deadline);
    let longer = FIRST_PAUSE, damaged = 0;
    for (let exchanges = 1; ; ++exchanges) {
      const sentAt = now(), milliseconds = Math.max(0, Math.min(timeout, end - sentAt));
      let wait = longer, failure: FractureError;
      const said = { exchanges };
      try {
        const reply = { ...(await this.exchange(operation, ask, milliseconds)), exchanges };
        const { status, headers, bytes } = reply;
        if (good.includes(status)) {
          const wrong = status === 304 ? undefined : await damage(reply, digest === true && status !== 202, ask.json === true);
          if (!wrong) return reply;
          failure = localError('damaged-answer', wrong, { status, ...said });
        } else {
          failure = problemOf(status, headers, bytes, exchanges);
          if (status === 429 || status === 503) {
            wait = failure.retryAfter === undefined ? longer : 1000 * failure.retryAfter;
          } else {
            const what = status === 404 && failure.problem === 'not-found' ? await ask.onMissing?.(sentAt, end - now()) : undefined;
            if (what === undefined || what === 'give-up') throw failure;
            if (what === 'retry-once') ask = { ...ask, onMissing: async () => 'give-up' };
            wait = 0;
          }
        }
      } catch (error) {
        if (error instanceof FractureError) error.exchanges = exchanges;
        if (!(error instanceof Interrupted)) throw error;
        failure = error.as(this.base, exchanges, milliseconds, ask.signal);
      }
      if (failure.problem === 'aborted' || failure.problem === 'answer-too-large' || failure.problem === 'bad-argument') throw failure;
      if (failure.problem === 'damaged-answer') {
        if (++damaged >= DAMAGED_ANSWERS) throw failure;
        wait = 0;
      }
      if (exchanges > retries || now() + wait > end) throw failure;
      if (wait > 0) await pause(wait, ask.signal, exchanges);
      longer = Math.min(2 * longer, LONGEST_PAUSE);
    }
  }

  /** Sends a request without retries. The caller reads the body of the response while it arrives. The watch limits the time between
   * two pieces of the body. */
  async stream(operation: OperationId, ask: Ask, idle: number): Promise<{ response: Response; watch: Watch }> {
    const watch = new Watch(ask.signal, idle);
    try {
      const response = await this.send(operation, ask, watch);
      watch.restart();
      if ((operations[operation].good as readonly number[]).includes(response.status)) return { response, watch };
      throw problemOf(response.status, response.headers, await readBody(response, watch, 1 << 20), 1);
    } catch (error) {
      watch.release();
      throw error instanceof FractureError ? error : new Interrupted(error, watch, false).as(this.base, 1, idle, ask.signal);
    }
  }

  private async exchange(operation: OperationId, ask: Ask, milliseconds: number): Promise<Omit<Reply, 'exchanges'>> {
    const watch = new Watch(ask.signal, milliseconds);
    let response: Response | undefined;
    try {
      response = await this.send(operation, ask, watch);
      const bytes = await readBody(response, watch, this.settings.maxAnswerBytes ?? 2 ** 28);
      return { status: response.status, headers: response.headers, bytes };
    } catch (error) {
      throw error instanceof FractureError ? error : new Interrupted(error, watch, response !== undefined);
    } finally {
      watch.release();
    }
  }

  private async send(operation: OperationId, ask: Ask, watch: Watch): Promise<Response> {
    const { method, digest }: Operation = operations[operation], { token, headers: everywhere } = this.settings;
    const fields: Record<string, string | undefined> = { ...everywhere, ...ask.headers };
    const given = typeof token === 'function' ? await watch.race(asked(token)) : token;
    if (given) fields['Authorization'] = `Bearer ${given}`;
    if (digest && !this.settings.compressed) {
      // Only an uncompressed answer can be compared with its digest. A page must not set Accept-Encoding, but the response to a range
      // request is not compressed: browsers then accept no coding (Fetch standard, HTTP-network-or-cache fetch), and the server applies
      // none. This range covers the whole answer.
      fields['Range'] ??= 'bytes=0-';
    }
    let headers: Headers;
    try {
      headers = new Headers(Object.entries(fields).filter((field): field is [string, string] => field[1] !== undefined));
    } catch (cause) {
      throw localError('bad-argument', `The token or one of the \`headers\` cannot be sent: ${textOf(cause)}`, { parameter: 'token', cause });
    }
    const request: RequestInit = { method, headers, signal: watch.signal };
    if (ask.body !== undefined) request.body = ask.body;
    return watch.race((this.settings.fetch ?? globalThis.fetch)(this.urlOf(operation, ask), request));
  }
}

/** A request that ended without a complete response. */
export class Interrupted {
  constructor(private readonly error: unknown, private readonly watch: Watch, private readonly began: boolean) {}

  as(base: URL, exchanges: number, milliseconds: number, signal: AbortSignal | undefined): FractureError {
    const said = { exchanges, cause: this.error };
    if (this.watch.cause === 'aborted') return abortedError(signal!, exchanges);
    if (this.watch.cause === 'timed-out')
      return localError('timed-out', `${base.origin} did not answer within ${Math.round(milliseconds) / 1000} s.`, said);
    if (this.began) return localError('damaged-answer', `The response was cut off: ${textOf(this.error)}.`, said);
    // A browser does not reveal whether the server is absent or refuses requests from this page.
    const page = (globalThis as { location?: { origin?: string } }).location?.origin;
    const cors = page && page !== base.origin ? ` If the server is running, restart it with --cors-origin ${page}, because browsers hide refused cross-origin answers.` : '';
    return localError('server-absent', `No server answers at ${base.origin} (${textOf(this.error)}).${cors}`, said);
  }
}

async function asked(token: () => string | Promise<string>): Promise<string> {
  try {
    return await token();
  } catch (cause) {
    throw localError('bad-argument', `The function \`token\` failed: ${textOf(cause)}`, { parameter: 'token', cause });
  }
}

/** Returns whether the answer was compressed. A page from another origin may be unable to see Content-Encoding, but it can see the ETag. */
const coded = (headers: Headers) => !['', 'identity'].includes(headers.get('content-encoding') ?? '') ||
                                    /\.(gzip|zstd)"$/.test(headers.get('etag') ?? '');

async function readBody(response: Response, watch: Watch, limit: number): Promise<Uint8Array<ArrayBuffer>> {
  const tooLarge = () => {
    response.body?.cancel().catch(() => {});
    const detail = `The answer has more than ${limit.toLocaleString('en')} bytes, which is this client's limit (maxAnswerBytes). ` +
      'Request fewer fragments, or raise the limit.';
    return localError('answer-too-large', detail, { status: response.status });
  };
  // If the length is known, the buffer has that size from the start. The digest shows whether the answer was cut off.
  const declared = coded(response.headers) ? 0 : Number(response.headers.get('content-length') ?? 0);
  if (declared > limit) throw tooLarge();
  if (!response.body) return new Uint8Array(await watch.race(response.arrayBuffer()));
  const reader = response.body.getReader();
  let bytes = new Uint8Array(declared > 0 ? declared : 1 << 14), size = 0;
  for (;;) {
    const { done, value } = await watch.race(reader.read());
    if (done) break;
    if (size + value.byteLength > limit) throw tooLarge();
    if (size + value.byteLength > bytes.length) {
      const larger = new Uint8Array(Math.max(2 * bytes.length, size + value.byteLength));
      larger.set(bytes.subarray(0, size));
      bytes = larger;
    }
    bytes.set(value, size);
    size += value.byteLength;
  }
  return size === bytes.length ? bytes : bytes.slice(0, size);
}

/** Returns a description of an answer's damage; undefined if the answer is intact. */
async function damage({ status, headers, bytes }: Reply, digest: boolean, json: boolean): Promise<string | undefined> {
  if (json) {
    try {
      JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(bytes));
    } catch {
      return `The response is not JSON. ${WRONG_SERVER}`;
    }
  }
  if (!digest) return undefined;
  if (status === 206 && headers.get('content-range') !== `bytes 0-${bytes.byteLength - 1}/${bytes.byteLength}`)
    return 'Only part of the answer arrived.';
  const field = headers.get('repr-digest');
  if (field === null) return `The answer has no Repr-Digest, so it cannot be checked. ${WRONG_SERVER}`;
  // A compressed answer is already unpacked here; unpacking verified the checksum of its coding.
  if (coded(headers) || await digestMatches(field, bytes)) return undefined;
  return 'The bytes of the answer do not match its Repr-Digest: they were changed in transit.';
}
