// Converts all errors to the form of the server's errors, because one notice shows them all.
import { FractureError } from 'fracture-client';
import { words } from '../words/words';

export function asProblem(error: unknown): FractureError {
  if (error instanceof FractureError) return error;
  const detail = error instanceof Error ? error.message : String(error);
  return new FractureError({ type: 'page:error', status: 0, title: words.problem.page, detail, cause: error });
}

/** Returns whether the file is a mesh that cannot be broken. Only then can the page show the mesh. */
export const isOfTheSolid = (error: unknown): boolean =>
  error instanceof FractureError && ['mesh-not-closed', 'too-complex', 'no-fragments', 'unsound'].includes(error.problem);

/** Returns whether the error is about the server or the connection, not about the mesh. */
export const isAway = (error: unknown): boolean =>
  error instanceof FractureError && ['server-absent', 'timed-out', 'draining', 'unauthorized', 'overloaded', 'aborted'].includes(error.problem);

/** Returns the points of the mesh that an error refers to. */
export function placesOf({ document }: FractureError): number[][] {
  if (!document) return [];
  const { edge, sample } = document as { edge?: number[][]; sample?: number[] };
  return [...(edge ?? []), ...(sample && !edge ? [sample] : [])].filter(point => Array.isArray(point) && point.length === 3);
}
