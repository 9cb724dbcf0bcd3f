// Sets an element's style properties from code, because the page's policy forbids inline styles.
import { noChange } from 'lit';
import { Directive, directive, type ElementPart } from 'lit/directive.js';

class Css extends Directive {
  render(_: Record<string, string>) {
    return noChange;
  }
  override update(part: ElementPart, [properties]: [Record<string, string>]) {
    for (const [name, value] of Object.entries(properties)) (part.element as HTMLElement).style.setProperty(name, value);
    return noChange;
  }
}
export const css = directive(Css);
