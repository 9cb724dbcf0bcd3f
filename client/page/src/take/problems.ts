import { FractureError } from 'fracture-client';

/** Creates an error of the page itself, in the form of the server's errors. */
export const localProblem = (detail: string): FractureError => new FractureError({ type: 'page:refused', status: 0, title: detail, detail: '' });
