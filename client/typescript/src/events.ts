// Server-sent events (WHATWG HTML, section 9.2) from the body of a fetch. EventSource is not used because it cannot send a token.

export interface ServerEvent {
  event: string;
  data: string;
  id: string;
}

/** Reads events from pieces of text, which may be split anywhere. */
export class EventParser {
  private rest = '';
  private event = '';
  private data: string[] = [];
  private id = '';

  push(text: string): ServerEvent[] {
    const events: ServerEvent[] = [];
    this.rest += text;
    for (;;) {
      // A carriage return at the end may be half of a line break.
      const at = this.rest.search(/\r\n|\n|\r(?!$)/);
      if (at < 0) return events;
      const line = this.rest.slice(0, at);
      this.rest = this.rest.slice(at + (this.rest.startsWith('\r\n', at) ? 2 : 1));
      if (line !== '') this.field(line);
      else if (this.data.length > 0 || this.event !== '') events.push(this.finish());
    }
  }

  private field(line: string): void {
    const colon = line.indexOf(':'), name = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? '' : line.slice(colon + (line[colon + 1] === ' ' ? 2 : 1));
    if (name === 'event') this.event = value;
    if (name === 'data') this.data.push(value);
    if (name === 'id') this.id = value;
  }

  private finish(): ServerEvent {
    const event = { event: this.event || 'message', data: this.data.join('\n'), id: this.id };
    this.event = '';
    this.data = [];
    return event;
  }
}
