// Of which sources this page is made: build.mjs says it. What is loaded later must be of the same.
declare const BUILD: string;
export const build: string = BUILD;
