// Fetches answers while a slider moves. Not every value is requested, but the newest always is. An older answer never replaces a newer
// one.
//
//   values   1  2  3  4  5  6  7 …
//   asked    1  2        5     7      at most `MOST` at a time; the newest value waits for a slot, others are dropped
//   shown       2        5     7      an answer that arrives cancels all older requests

/** Maximum number of requests in progress. The server works on two at a time, and a third would only wait in
 * front of the newest. */
const MOST = 2;

interface Asked {
  number: number;
  abort: AbortController;
}

export class Asker<Question, Answer> {
  private readonly flying = new Set<Asked>();
  private waiting: { number: number; question: Question; at: number } | undefined;
  private last = 0;
  private shown = 0;

  /** `ask` is called with the time of the input. `show` is called only with an answer newer than the last one, and
   * `fail` only with the error of the newest request. */
  constructor(private readonly ask: (question: Question, signal: AbortSignal) => Promise<Answer>,
              private readonly show: (answer: Answer, question: Question, at: number) => void,
              private readonly fail: (error: unknown, question: Question) => void,
              private readonly changed: (inFlight: number) => void) {}

  /** Requests an answer. `settled`: the user has stopped dragging, so older requests are cancelled. */
  put(question: Question, settled = true): void {
    const next = { number: ++this.last, question, at: performance.now() };
    if (settled) this.drop(next.number);
    if (this.flying.size < MOST) this.send(next);
    else this.waiting = next;
  }

  /** Cancels all requests but the latest, because its value is final. */
  settle(): void {
    this.drop(this.last);
    const next = this.waiting;
    if (next && this.flying.size < MOST) {
      this.waiting = undefined;
      void this.send(next);
    }
  }

  /** Cancels all requests. */
  cancel(): void {
    this.waiting = undefined;
    this.shown = this.last;
    this.drop(Infinity);
  }

  get busy(): boolean {
    return this.flying.size > 0 || this.waiting !== undefined;
  }

  private drop(before: number): void {
    for (const asked of this.flying) {
      if (asked.number >= before) continue;
      this.flying.delete(asked);
      asked.abort.abort();
    }
    this.changed(this.flying.size);
  }

  private async send({ number, question, at }: { number: number; question: Question; at: number }): Promise<void> {
    const asked: Asked = { number, abort: new AbortController() };
    this.flying.add(asked);
    this.changed(this.flying.size);
    try {
      const answer = await this.ask(question, asked.abort.signal);
      if (number > this.shown && !asked.abort.signal.aborted) {
        this.shown = number;
        this.drop(number);
        this.show(answer, question, at);
      }
    } catch (error) {
      if (!asked.abort.signal.aborted && number === this.last) this.fail(error, question);
    } finally {
      this.flying.delete(asked);
      this.changed(this.flying.size);
      const next = this.waiting;
      if (next && this.flying.size < MOST) {
        this.waiting = undefined;
        void this.send(next);
      }
    }
  }
}
