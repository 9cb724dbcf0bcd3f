import { FractureError } from 'fracture-client';

/** What the page itself refuses, in the form of the server's problems. */
export const localProblem = (detail: string): FractureError => new FractureError({ type: 'page:refused', status: 0, title: detail, detail: '' });
