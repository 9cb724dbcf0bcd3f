// All operations in proto/openapi.yaml with their paths. The client builds its requests from this table. A test compares the table
// with the document.

export interface Operation {
  readonly method: 'GET' | 'POST' | 'PUT' | 'DELETE';
  readonly path: string;
  /** Statuses of successful responses. */
  readonly good: readonly number[];
  /** True if responses have a Repr-Digest, which the client checks. The client treats a response without one as damaged. */
  readonly digest?: boolean;
  /** True if the operation is on the admin port, which has another address. */
  readonly admin?: boolean;
}

export const operations = {
  getIndex: { method: 'GET', path: '/', good: [200, 304] },
  getDocs: { method: 'GET', path: '/docs', good: [200, 304] },  // for browsers, as is getPageFile
  getPageFile: { method: 'GET', path: '/page/{file}', good: [200, 304] },
  getVersion: { method: 'GET', path: '/version', good: [200] },
  getLimits: { method: 'GET', path: '/limits', good: [200] },
  getPatterns: { method: 'GET', path: '/patterns', good: [200] },
  getOpenapi: { method: 'GET', path: '/openapi.json', good: [200] },
  getLlms: { method: 'GET', path: '/llms.txt', good: [200] },
  getProblem: { method: 'GET', path: '/problems/{name}', good: [200] },
  postFracture: { method: 'POST', path: '/fracture', good: [200, 202], digest: true },
  getFracture: { method: 'GET', path: '/fractures/{id}', good: [200, 206, 304], digest: true },
  postMesh: { method: 'POST', path: '/meshes', good: [200, 201] },
  putMesh: { method: 'PUT', path: '/meshes/{id}', good: [200, 201] },
  getMesh: { method: 'GET', path: '/meshes/{id}', good: [200] },
  deleteMesh: { method: 'DELETE', path: '/meshes/{id}', good: [204] },
  postMeshFracture: { method: 'POST', path: '/meshes/{id}/fracture', good: [200, 202], digest: true },
  postMeshEstimate: { method: 'POST', path: '/meshes/{id}/estimate', good: [200] },
  getJobs: { method: 'GET', path: '/jobs', good: [200] },
  getJob: { method: 'GET', path: '/jobs/{id}', good: [200] },
  deleteJob: { method: 'DELETE', path: '/jobs/{id}', good: [204] },
  getJobEvents: { method: 'GET', path: '/jobs/{id}/events', good: [200] },
  getLivez: { method: 'GET', path: '/livez', good: [200], admin: true },
  getReadyz: { method: 'GET', path: '/readyz', good: [200], admin: true },
  getMetrics: { method: 'GET', path: '/metrics', good: [200], admin: true },
} as const satisfies Record<string, Operation>;

export type OperationId = keyof typeof operations;

/** Request header fields that the document describes, except Authorization and Accept. */
export const requestFields = [
  'Half-Close', 'If-Match', 'If-None-Match', 'If-Range', 'Prefer', 'Priority', 'Range', 'Request-Timeout',
] as const;

/** Error statuses that the document lists. The client also throws a FractureError for all other error statuses. */
export const problemStatuses = [400, 404, 406, 408, 412, 413, 415, 416, 422, 503, 504] as const;
