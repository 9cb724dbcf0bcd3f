// Waits that end: by the caller's AbortSignal or by a time. (AbortSignal.any is not in node 18.)
import { localError, type FractureError } from './problems.js';

export function abortedError(signal: AbortSignal, exchanges = 0): FractureError {
  return localError('aborted', 'The request was aborted by its caller.', { cause: signal.reason, exchanges });
}

/** One signal for an exchange, and why it fired. */
export class Watch {
  private readonly controller = new AbortController();
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly onAbort = () => this.stop('aborted');
  private readonly stopped: Promise<never>;
  /** Nothing while the exchange may go on. */
  cause: 'aborted' | 'timed-out' | undefined;

  /** `milliseconds`: Infinity for no limit. */
  constructor(private readonly outer: AbortSignal | undefined, private readonly milliseconds: number) {
    const { signal } = this.controller;
    this.stopped = new Promise((_, reject) => signal.addEventListener('abort', () => reject(signal.reason)));
    this.stopped.catch(() => {});  // nobody may be waiting
    if (outer?.aborted) this.stop('aborted');
    else outer?.addEventListener('abort', this.onAbort);
    this.restart();
  }

  get signal(): AbortSignal {
    return this.controller.signal;
  }

  /** The time begins again: something came. */
  restart(): void {
    clearTimeout(this.timer);
    // Longer times than a timer can hold are none.
    if (this.milliseconds < 2 ** 31 && !this.cause) this.timer = setTimeout(() => this.stop('timed-out'), this.milliseconds);
  }

  /** The promise, or a rejection when the watch stops first: also for a fetch that does not heed its signal. */
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

/** Rejects with a FractureError when the signal fires. */
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

/** What is left of a time that several requests share. */
export function within(milliseconds: number): () => number {
  const end = now() + milliseconds;
  return () => end - now();
}

/** Milliseconds since some point; never goes back. */
export const now = (): number => performance.now();
