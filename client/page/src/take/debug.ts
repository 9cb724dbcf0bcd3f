// Everything needed to reproduce what is shown: versions, parameters, digests, report, problem. No token, no mesh.
import type { App } from '../app/app';
import { parametersOf } from '../state/request';
import { linkOf } from './link';

export function debugInformation(app: App): string {
  const { source, shown, problem, wish, look } = app.state, { knowledge } = app.service;
  return JSON.stringify({
    server: knowledge?.version, page: { link: source ? linkOf(app) : location.href, browser: navigator.userAgent, view: { ...look, chosen: [...look.chosen], hidden: [...look.hidden] } },
    mesh: source && { id: source.mesh.id, name: source.label, stored: source.mesh.stored },
    asked: parametersOf(wish),
    answer: shown && {
      location: shown.answer.location, etag: shown.answer.head.etag, request_id: shown.answer.head.requestId, cache: shown.answer.head.cacheStatus,
      timing: shown.answer.head.timing, to_answer_ms: shown.toAnswer, to_picture_ms: shown.toPicture,
      parameters: shown.answer.parameters, report: shown.answer.report, certificate: shown.answer.certificate,
    },
    problem: problem && (problem.document ?? { type: problem.type, title: problem.title, detail: problem.detail }),
  }, undefined, 2);
}
