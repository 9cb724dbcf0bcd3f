// What goes wrong, in one class: the server's problem documents (RFC 9457), and what this side of the wire finds.

/** Last segments of the `type` of the server's problems. A test holds them and proto/openapi.yaml together. */
export const serverProblems = [
  'bad-parameter', 'unknown-parameter', 'bad-json', 'empty-body', 'unknown-format', 'malformed-mesh', 'unsupported-feature',
  'external-resource', 'importer-crashed', 'importer-limit', 'too-large', 'empty-mesh', 'not-finite', 'mesh-not-closed',
  'too-complex', 'no-fragments', 'no-such-fragment', 'no-such-answer', 'unsound', 'cancelled', 'deadline-exceeded', 'job-lost',
  'out-of-memory', 'internal', 'malformed-request', 'malformed-multipart', 'malformed-coding', 'content-digest-mismatch',
  'unauthorized', 'forbidden', 'not-found', 'method-not-allowed', 'not-acceptable', 'request-timeout', 'precondition-failed',
  'body-too-large', 'uri-too-long', 'unsupported-coding', 'unsupported-media-type', 'range-not-satisfiable', 'digest-mismatch',
  'expectation-failed', 'too-many-connections', 'over-share', 'foreign-host', 'foreign-origin', 'header-too-large',
  'client-closed-request', 'not-implemented', 'overloaded', 'draining', 'version-not-supported',
] as const;

/** What no server answers. */
export const localProblems = {
  'server-absent': 'Nobody answers at this address',
  'timed-out': 'The answer did not come in time',
  'damaged-answer': 'The answer was damaged on its way',
  'answer-too-large': 'The answer is over the limit of this client',
  'bad-argument': 'The call is wrong, and nothing was sent',
  aborted: 'The caller took the request back',
} as const;

export type ServerProblem = (typeof serverProblems)[number];
export type LocalProblem = keyof typeof localProblems;

/** As the server sends it, application/problem+json. */
export interface ProblemDocument {
  type: string;
  title: string;
  status: number;
  detail: string;
  parameter?: string;
  request_id?: string;
  errors?: { detail: string; parameter?: string; pointer?: string }[];
  more_errors?: number;
  bytes?: number;
  [member: string]: unknown;
}

export interface FractureErrorFields {
  type: string;
  status: number;
  title: string;
  detail: string;
  parameter?: string | undefined;
  retryAfter?: number | undefined;
  document?: ProblemDocument | undefined;
  exchanges?: number;
  cause?: unknown;
}

/** The only thing that this package throws, or rejects with. */
export class FractureError extends Error {
  /** `/problems/bad-parameter` as the server names it; `client:timed-out` for what this side found. */
  readonly type: string;
  /** Of the HTTP answer; 0 where there was none. */
  readonly status: number;
  readonly title: string;
  /** What was wrong in this request, with the offending value and the limit; for people. */
  readonly detail: string;
  /** The parameter, part or argument concerned. */
  readonly parameter: string | undefined;
  /** The last segment of `type`: what programs decide by. Also a name that this version of the package does not know;
   * 'unknown' where the answer is no problem document, of a proxy for one. */
  readonly problem: ServerProblem | LocalProblem | 'unknown' | (string & {});
  /** Seconds after which a busy server wants to be asked again. */
  readonly retryAfter: number | undefined;
  /** All that the server said: `errors`, `request_id`, … */
  readonly document: ProblemDocument | undefined;
  /** How many HTTP requests it took to know. */
  exchanges: number;

  constructor(fields: FractureErrorFields) {
    super(fields.detail || fields.title, fields.cause === undefined ? undefined : { cause: fields.cause });
    this.type = fields.type;
    this.status = fields.status;
    this.title = fields.title;
    this.detail = fields.detail;
    this.parameter = fields.parameter;
    this.problem = fields.type === 'about:blank' ? 'unknown' : /[^/:]*$/.exec(fields.type)![0];
    this.retryAfter = fields.retryAfter;
    this.document = fields.document;
    this.exchanges = fields.exchanges ?? 0;
    // Who looks for an abort by its name, as with fetch, finds it.
    this.name = this.problem === 'aborted' ? 'AbortError' : 'FractureError';
  }
}

export function localError(problem: LocalProblem, detail: string, more: Partial<FractureErrorFields> = {}): FractureError {
  return new FractureError({ type: `client:${problem}`, status: 0, title: localProblems[problem], detail, ...more });
}

const FOREIGN = ', not in the words of a fracture-server: is this its address?';

/** Of an answer that is no good: also of a proxy's page, which is no problem document. */
export function problemOf(status: number, headers: Headers, bytes: Uint8Array, exchanges: number): FractureError {
  let document: Partial<ProblemDocument> = {};
  try {
    const read: unknown = JSON.parse(new TextDecoder().decode(bytes));
    if (typeof read === 'object' && read !== null) document = read as Partial<ProblemDocument>;
  } catch {
    // Not the service's words.
  }
  const text = (value: unknown) => (typeof value === 'string' && value !== '' ? value : undefined);
  const type = text(document.type);
  return new FractureError({
    type: type ?? 'about:blank',
    status,
    title: text(document.title) ?? `HTTP status ${status}`,
    detail: text(document.detail) ?? `The server answered ${status}${type ? '.' : FOREIGN}`,
    parameter: text(document.parameter),
    retryAfter: retryAfter(headers),
    document: type === undefined ? undefined : (document as ProblemDocument),
    exchanges,
  });
}

/** Of a problem inside of another document: a job that failed. */
export function problemIn(document: ProblemDocument): FractureError {
  const { type, status, title, detail, parameter } = document;
  return new FractureError({ type, status, title, detail, parameter, document });
}

/** Retry-After in whole seconds (RFC 9110, 10.2.3); nothing for a date or nonsense, or beyond a day. */
export function retryAfter(headers: Headers): number | undefined {
  const text = headers.get('retry-after')?.trim() ?? '';
  return /^\d{1,5}$/.test(text) && Number(text) <= 86400 ? Number(text) : undefined;
}
