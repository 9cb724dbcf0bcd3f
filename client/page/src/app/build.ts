// Identifies the sources of this page (set by build.mjs). Parts that are loaded later must come from the same sources.
declare const BUILD: string;
export const build: string = BUILD;
