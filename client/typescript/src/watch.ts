// Waits that end when the caller's AbortSignal fires or the time is up. (node 18 does not have AbortSignal.any.)
import { localError, type FractureError } from './problems.js';

export function abortedError(signal: AbortSignal, exchanges = 0): FractureError {
  return localError('aborted', 'The request was aborted with its AbortSignal.', { cause: signal.reason, exchanges });
}

/** The signal that ends one request, and the reason why it fired. */
export class Watch {
  private readonly controller = new AbortController();
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly onAbort = () => this.stop('aborted');
  private readonly stopped: Promise<never>;
  /** Undefined until the signal fires. */
  cause: 'aborted' | 'timed-out' | undefined;

  /** `milliseconds`: Infinity for no limit. */
  constructor(private readonly outer: AbortSignal | undefined, private readonly milliseconds: number) {
    const { signal } = this.controller;
    this.stopped = new Promise((_, reject) => signal.addEventListener('abort', () => reject(signal.reason)));
    this.stopped.catch(() => {});  // if no caller is waiting, the rejection must not be reported as unhandled
    if (outer?.aborted) this.stop('aborted');
    else outer?.addEventListener('abort', this.onAbort);
    this.restart();
  }

  get signal(): AbortSignal {
    return this.controller.signal;
  }

  /** Restarts the timer. Called when a piece of the response arrives. */
  restart(): void {
    clearTimeout(this.timer);
    // A time that is too long for a timer means no limit.
    if (this.milliseconds < 2 ** 31 && !this.cause) this.timer = setTimeout(() => this.stop('timed-out'), this.milliseconds);
  }

  /** Returns the promise's result, or rejects if the watch stops first. This works even for a fetch that ignores its signal. */
  race<T>(promise: Promise<T>): Promise<T> {
    return Promise.race([promise, this.stopped]);
  }

  stop(cause: 'aborted' | 'timed-out'): void {
    this.cause ??= cause;
    this.release();
    this.controller.abort(new Error(cause));
  }

  release(): void {
    clearTimeout(this.timer);
    this.outer?.removeEventListener('abort', this.onAbort);
  }
}

/** Waits. Rejects with a FractureError when the signal fires. */
export function pause(milliseconds: number, signal: AbortSignal | undefined, exchanges = 0): Promise<void> {
  return new Promise((resolve, reject) => {
    if (signal?.aborted) return reject(abortedError(signal, exchanges));
    const onAbort = () => {
      clearTimeout(timer);
      reject(abortedError(signal!, exchanges));
    };
    const timer = setTimeout(() => {
      signal?.removeEventListener('abort', onAbort);
      resolve();
    }, milliseconds);
    signal?.addEventListener('abort', onAbort, { once: true });
  });
}

/** Starts a time limit that several requests share. Returns a function that returns the remaining milliseconds. */
export function within(milliseconds: number): () => number {
  const end = now() + milliseconds;
  return () => end - now();
}

/** Returns the milliseconds of a clock that never goes backwards. */
export const now = (): number => performance.now();
