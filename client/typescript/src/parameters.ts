// Parameters of fractures. GET /patterns and GET /limits list their names, types, units, ranges and defaults.
import { localError } from './problems.js';

/** The value of a parameter: a JSON value, or a typed array, which is sent as a list of numbers. */
export type ParameterValue = string | number | boolean | readonly ParameterValue[] | Assignment | Float32Array | Float64Array | Int32Array | Uint32Array;
/** An entry of `assign`, which sets the materials of individual parts of a mesh. A part must match all given selectors. Other members
 * are parameters that a material sets; GET /limits marks them as `assignable`. */
export interface Assignment {
  /** Names or indices of nodes, or patterns such as Wall_*. A node includes all nodes below it. */
  readonly node?: string | readonly string[];
  /** Names or indices of the mesh's materials, or patterns. The material that covers most of a part's surface counts. */
  readonly slot?: string | readonly string[];
  /** Numbers of parts, as in `part` of a fragment. */
  readonly part?: number | readonly number[];
  readonly material?: string;
  readonly [parameter: string]: ParameterValue | undefined;
}
/** Parameters by name. GET /patterns and GET /limits list the names. */
export interface Parameters {
  /** At most 64 entries, or the text selector:material;selector:material. The first entry that matches a part applies to it. */
  readonly assign?: string | readonly Assignment[];
  readonly [name: string]: ParameterValue | undefined;
}

/** Returns the parameters as JSON. Typed arrays become lists of numbers. Throws FractureError (bad-argument). */
export function parametersText(parameters: Parameters): string {
  try {
    return JSON.stringify(parameters, (_, value: unknown) => {
      if (typeof value === 'number' && !Number.isFinite(value)) throw new Error(`JSON cannot represent the number ${value}`);
      return ArrayBuffer.isView(value) && !(value instanceof DataView) ? Array.from(value as Float64Array) : value;
    }) ?? '{}';
  } catch (cause) {
    const why = (cause as Error).message;
    throw localError('bad-argument', `The parameters cannot be written as JSON: ${why}.`, { parameter: 'parameters', cause });
  }
}
