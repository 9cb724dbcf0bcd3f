// Lints the OpenAPI document with Redocly's recommended rules. Exit codes: 0 if clean, 1 if there are problems, 77 if node_modules is
// missing. Usage: node lint.mjs DOCUMENT
import path from 'node:path';

const file = path.resolve(process.argv[2]);

let redocly;
try {
  redocly = await import('@redocly/openapi-core');
} catch {
  console.log('skipped: tests/contract/node_modules is missing (npm ci there)');
  process.exit(77);
}

const config = await redocly.createConfig({
  extends: ['recommended'],
  rules: {
    // The `default` response documents the problems of every operation.
    'operation-4xx-response': 'off',
    'no-empty-servers': 'error',
    'operation-operationId': 'error',
    'operation-operationId-unique': 'error',
    'path-parameters-defined': 'error',
    'no-unused-components': 'error',
  },
});
const problems = await redocly.lint({ref: file, config});
for (const problem of problems) {
  const at = problem.location[0];
  console.log(`${problem.severity}: ${problem.ruleId} at ${at?.pointer ?? '?'}: ${problem.message}`);
}
console.log(`${problems.length} problems`);
process.exit(problems.length === 0 ? 0 : 1);
