// Sets properties of an element's style by its object model: the policy of the page allows no style in markup.
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
