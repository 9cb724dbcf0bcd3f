// Whatever goes wrong is shown in one form: the server's, or one like it.
import { FractureError } from 'fracture-client';

export function asProblem(error: unknown): FractureError {
  if (error instanceof FractureError) return error;
  const detail = error instanceof Error ? error.message : String(error);
  return new FractureError({ type: 'page:error', status: 0, title: 'The page went wrong', detail, cause: error });
}

/** The file was read, and what is in it cannot be broken: that is seen in its picture. All others are no mesh at all. */
export const isOfTheSolid = (error: unknown): boolean =>
  error instanceof FractureError && ['mesh-not-closed', 'too-complex', 'no-fragments', 'unsound'].includes(error.problem);

/** It says nothing about the mesh. */
export const isAway = (error: unknown): boolean =>
  error instanceof FractureError && ['server-absent', 'timed-out', 'draining', 'unauthorized', 'overloaded', 'aborted'].includes(error.problem);

/** Where a problem says that it is. */
export function placesOf({ document }: FractureError): number[][] {
  if (!document) return [];
  const { edge, sample } = document as { edge?: number[][]; sample?: number[] };
  return [...(edge ?? []), ...(sample && !edge ? [sample] : [])].filter(point => Array.isArray(point) && point.length === 3);
}
