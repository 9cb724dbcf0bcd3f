// Icons drawn as strokes in the text colour.
import { svg, type TemplateResult } from 'lit';
import { html } from 'lit';

const icon = (strokes: TemplateResult) => html`<svg class="icon" viewBox="0 0 20 20" aria-hidden="true">${strokes}</svg>`;

export const icons = {
  hit: icon(svg`<path d="M3 17 9 11M8 8l4 4M9.500 6.500l4 4 3.500-4-3.500-3.500z"/>`),
  aim: icon(svg`<circle cx="10" cy="10" r="5.500"/><path d="M10 2v5M10 13v5M2 10h5M13 10h5"/>`),
  select: icon(svg`<path d="M5 3l10 7-4.600.900L13 16l-2.200 1-2.500-5L5 15z"/>`),
  undo: icon(svg`<path d="M7 5 3.500 8.500 7 12M4 8.500h7.500a4 4 0 0 1 0 8H9"/>`),
  redo: icon(svg`<path d="M13 5l3.500 3.500L13 12M16 8.500H8.500a4 4 0 0 0 0 8H11"/>`),
  keys: icon(svg`<circle cx="10" cy="10" r="7.500"/><path d="M7.800 8a2.200 2.200 0 1 1 3 2.100c-.600.300-.800.700-.800 1.400M10 14v.200"/>`),
  docs: icon(svg`<path d="M5 2.500h7l3.500 3.500v11.500H5zM12 2.500V6h3.500M7.500 9.500h5M7.500 12.500h5"/>`),
  theme: icon(svg`<circle cx="10" cy="10" r="6.500"/><path class="fill" d="M10 3.500a6.500 6.500 0 0 1 0 13z"/>`),
  play: icon(svg`<path class="fill" d="M6 4l10 6-10 6z"/>`),
  fit: icon(svg`<path d="M3 7V3h4M13 3h4v4M17 13v4h-4M7 17H3v-4"/><rect x="7" y="7" width="6" height="6"/>`),
  cuts: icon(svg`<path d="M10 2.500 16.500 6v8L10 17.500 3.500 14V6zM10 2.500v7l6.500 4.500M10 9.500 3.500 14"/>`),
  wire: icon(svg`<path d="M10 3 17 16H3zM10 3v13M6.500 9.500 17 16M13.500 9.500 3 16"/>`),
  bonds: icon(svg`<circle cx="5" cy="6" r="2"/><circle cx="15" cy="5" r="2"/><circle cx="11" cy="15" r="2"/><path d="M7 5.800 13 5.200M6 7.800l4 5.400M14.300 6.900l-2.600 6.200"/>`),
  down: icon(svg`<path d="M10 3v9M6 8.500l4 4 4-4M3.500 16.500h13"/>`),
  copy: icon(svg`<rect x="7" y="7" width="9.500" height="9.500" rx="1.500"/><path d="M13 7V3.500H3.500V13H7"/>`),
  seal: icon(svg`<path d="M10 2.500l6 2v5.500c0 4-2.600 6.500-6 7.500-3.400-1-6-3.500-6-7.500V4.500z"/><path d="M7 10l2.200 2.200L13.200 8"/>`),
  unsealed: icon(svg`<path d="M10 2.500l6 2v5.500c0 4-2.600 6.500-6 7.500-3.400-1-6-3.500-6-7.500V4.500z"/><path d="M10 6.500v4.500M10 13.300v.200"/>`),
  dice: icon(svg`<rect x="3.500" y="3.500" width="13" height="13" rx="2.500"/><path d="M7 7v.100M13 13v.100M10 10v.100M13 7v.100M7 13v.100" class="dots"/>`),
  none: html`<svg class="icon none" viewBox="0 0 44 44" aria-hidden="true"><rect x="1" y="1" width="42" height="42" rx="7"/><path d="M6 38 38 6"/></svg>`,
  open: icon(svg`<path d="M2.500 16V4.500h5l1.500 2h6.500v2.500M2.500 16l2.500-7h13l-2.500 7z"/>`),
  reset: icon(svg`<path d="M5 5l10 10M15 5 5 15"/>`),
  file: icon(svg`<path d="M10 13V4M6.500 7.500 10 4l3.500 3.500M3.500 13v3.500h13V13"/>`),
};
