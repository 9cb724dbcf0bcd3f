// A single class for all errors: the server's problem documents (RFC 9457), and errors from this client.
/** The names of the server errors: the last segments of `type`. A test compares them with proto/openapi.yaml. */
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

/** The errors that this client itself reports. */
export const localProblems = {
  'server-absent': 'No server answers at this address',
  'timed-out': 'The response did not arrive completely in time',
  'damaged-answer': 'The answer was damaged in transit',
  'answer-too-large': 'The answer is larger than this client accepts',
  'bad-argument': 'An argument of the call is wrong, so no request was sent',
  aborted: 'The request was aborted',
} as const;

export type ServerProblem = (typeof serverProblems)[number];
export type LocalProblem = keyof typeof localProblems;

/** A problem document from the server (application/problem+json, RFC 9457). */
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

/** The class of all errors that this package throws, or with which its promises reject. */
export class FractureError extends Error {
  /** `/problems/bad-parameter` for an error from the server, `client:timed-out` for an error from this client. */
  readonly type: string;
  /** The status of the HTTP response; 0 without a response. */
  readonly status: number;
  /** The meaning of the type in a few words. */
  readonly title: string;
  /** The message about this request, including the wrong value and the limit. */
  readonly detail: string;
  /** The name of the wrong parameter, form part or argument. */
  readonly parameter: string | undefined;
  /** The last segment of `type`, for programs. A newer server can send a name that is not in serverProblems. 'unknown' if
   * the response is not a problem document but, for example, a proxy's page. */
  readonly problem: ServerProblem | LocalProblem | 'unknown' | (string & {});
  /** If the server is busy: seconds to wait before a retry. */
  readonly retryAfter: number | undefined;
  /** The whole problem document: `errors`, `request_id`, … */
  readonly document: ProblemDocument | undefined;
  /** Number of HTTP requests that were sent. */
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
    // As with fetch, code can recognize an abort by this name.
    this.name = this.problem === 'aborted' ? 'AbortError' : 'FractureError';
  }
}

export function localError(problem: LocalProblem, detail: string, more: Partial<FractureErrorFields> = {}): FractureError {
  return new FractureError({ type: `client:${problem}`, status: 0, title: localProblems[problem], detail, ...more });
}

const FOREIGN = 'has no problem document from a fracture server. Check the address: a proxy or another server may be answering there.';

/** Returns the error for an unsuccessful response, which can be a proxy's page instead of a problem document. */
export function problemOf(status: number, headers: Headers, bytes: Uint8Array, exchanges: number): FractureError {
  let document: Partial<ProblemDocument> = {};
  try {
    const read: unknown = JSON.parse(new TextDecoder().decode(bytes));
    if (typeof read === 'object' && read !== null) document = read as Partial<ProblemDocument>;
  } catch {
    // Not a problem document.
  }
  const text = (value: unknown) => (typeof value === 'string' && value !== '' ? value : undefined);
  const type = text(document.type);
  return new FractureError({
    type: type ?? 'about:blank',
    status,
    title: text(document.title) ?? `HTTP status ${status}`,
    detail: text(document.detail) ?? `The response (HTTP ${status}) ${type ? 'has no description.' : FOREIGN}`,
    parameter: text(document.parameter),
    retryAfter: retryAfter(headers),
    document: type === undefined ? undefined : (document as ProblemDocument),
    exchanges,
  });
}

/** Returns the error in a problem document that is nested in another document, as in a failed job. */
export function problemIn(document: ProblemDocument): FractureError {
  const { type, status, title, detail, parameter } = document;
  return new FractureError({ type, status, title, detail, parameter, document });
}

/** Returns Retry-After in seconds (RFC 9110, section 10.2.3); undefined if it is not a whole number (a date, for example) or
 * exceeds a day. */
export function retryAfter(headers: Headers): number | undefined {
  const text = headers.get('retry-after')?.trim() ?? '';
  return /^\d{1,5}$/.test(text) && Number(text) <= 86400 ? Number(text) : undefined;
}
