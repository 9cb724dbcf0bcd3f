// Parameters of fractures. GET /patterns and GET /limits list their names, types, units, ranges and defaults.
import { localError } from './problems.js';

/** The value of a parameter: a JSON value, or a typed array, which is sent as a list of numbers. */
export type ParameterValue = string | number | boolean | readonly ParameterValue[] | Float32Array | Float64Array | Int32Array | Uint32Array;
/** Parameters by name. GET /patterns and GET /limits list the names. */
export interface Parameters {
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
