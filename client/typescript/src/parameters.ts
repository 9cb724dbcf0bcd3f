// What may be asked for. No name stands here: GET /patterns and GET /limits list them, with type, unit, range and default.
import { localError } from './problems.js';

/** Values of parameters as JSON has them; typed arrays are lists of numbers. */
export type ParameterValue = string | number | boolean | readonly ParameterValue[] | Float32Array | Float64Array | Int32Array | Uint32Array;
/** By the names that GET /patterns and GET /limits list. */
export interface Parameters {
  readonly [name: string]: ParameterValue | undefined;
}

/** Typed arrays are lists of numbers, too. */
export function parametersText(parameters: Parameters): string {
  try {
    return JSON.stringify(parameters, (_, value: unknown) => {
      if (typeof value === 'number' && !Number.isFinite(value)) throw new Error(`${value} is no number of JSON`);
      return ArrayBuffer.isView(value) && !(value instanceof DataView) ? Array.from(value as Float64Array) : value;
    }) ?? '{}';
  } catch (cause) {
    const why = (cause as Error).message;
    throw localError('bad-argument', `The parameters cannot be written as JSON: ${why}.`, { parameter: 'parameters', cause });
  }
}
