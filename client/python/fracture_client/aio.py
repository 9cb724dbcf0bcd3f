"""The asyncio client. Its calls run in threads. If a task is cancelled, the task's connection closes at once, so the server stops
working on its request."""
from __future__ import annotations

import asyncio
import concurrent.futures
import functools
import ssl
from typing import Any, AsyncIterator, Callable, Dict, Iterator, Mapping, Optional, Sequence, TypeVar, Union

from .answer import Answer, Point
from .calls import Cancel
from .client import Client
from .errors import FractureError
from .http1 import Response
from .jobs import Job, JobState
from .mesh import Mesh, Parameters
from .pool import Settings
from .upload import Content, Files, Path

T = TypeVar("T")
THREADS = 64  # maximum number; most of the threads are waiting for one of the few connections or for job progress


class _Runner:
    """Runs the client's calls in its own threads."""

    def __init__(self) -> None:
        self._threads = concurrent.futures.ThreadPoolExecutor(THREADS, "fracture_client")

    async def run(self, work: Callable[..., T], *args: Any, **options: Any) -> T:
        """Runs work(*args, cancel=…, **options) in a thread. Cancelling the task also cancels the call."""
        token = Cancel()
        running = self._threads.submit(functools.partial(work, *args, cancel=token, **options))
        try:
            return await asyncio.wrap_future(running)
        except asyncio.CancelledError:
            token.cancel()  # a call that has not started yet ends as soon as it starts
            raise

    async def each(self, items: Iterator[T], token: Cancel) -> AsyncIterator[T]:
        """Yields the items of an iterator. `token`: the Cancel that was passed when the iterator was created."""
        end = object()
        try:
            while True:
                item: Any = await asyncio.wrap_future(self._threads.submit(lambda: next(items, end)))
                if item is end:
                    return
                yield item
        finally:
            token.cancel()

    async def close(self) -> None:
        await asyncio.get_running_loop().run_in_executor(None, self._threads.shutdown)


class AsyncAnswer(Answer):
    """An Answer whose hit() is a coroutine."""

    _runner: _Runner

    async def hit(self, point: Union[Point, Sequence[Point]], radius: Union[float, Sequence[float]],  # type: ignore[override]
                  sites: Union[int, Sequence[int], None] = None, *, timeout: Optional[float] = None,
                  realtime: Optional[bool] = None, **parameters: Any) -> "AsyncAnswer":
        """The same as Answer.hit()."""
        hit = functools.partial(Answer.hit, self, point, radius, sites, timeout=timeout, realtime=realtime, **parameters)
        return _of_answer(self._runner, await self._runner.run(hit))


class AsyncMesh:
    """The asyncio version of Mesh: its calls are coroutines. `sync` is the underlying Mesh."""

    def __init__(self, runner: _Runner, mesh: Mesh) -> None:
        self._runner = runner
        self.sync = mesh

    @property
    def id(self) -> str:
        """The same as Mesh.id."""
        return self.sync.id

    @property
    def stored(self) -> Dict[str, Any]:
        """The same as Mesh.stored."""
        return self.sync.stored

    @property
    def report(self) -> Dict[str, Any]:
        """The same as Mesh.report."""
        return self.sync.report

    async def refresh(self, *, timeout: Optional[float] = None) -> Dict[str, Any]:
        """The same as Mesh.refresh()."""
        return await self._runner.run(self.sync.refresh, timeout=timeout)

    async def fracture(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
                       realtime: Optional[bool] = None, **more: Any) -> AsyncAnswer:
        """The same as Mesh.fracture()."""
        answer = await self._runner.run(self.sync.fracture, parameters, timeout=timeout, realtime=realtime, **more)
        return _of_answer(self._runner, answer)

    async def figures(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
                      realtime: Optional[bool] = None, **more: Any) -> Dict[str, Any]:
        """The same as Mesh.figures()."""
        return await self._runner.run(self.sync.figures, parameters, timeout=timeout, realtime=realtime, **more)

    async def estimate(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None,
                       **more: Any) -> Dict[str, Any]:
        """The same as Mesh.estimate()."""
        return await self._runner.run(self.sync.estimate, parameters, timeout=timeout, **more)

    async def job(self, parameters: Optional[Parameters] = None, *, timeout: Optional[float] = None, **more: Any) -> "AsyncJob":
        """The same as Mesh.job()."""
        return AsyncJob(self._runner, await self._runner.run(self.sync.job, parameters, timeout=timeout, **more))

    async def forget(self, *, timeout: Optional[float] = None) -> bool:
        """The same as Mesh.forget()."""
        return await self._runner.run(self.sync.forget, timeout=timeout)


class AsyncJob:
    """The asyncio version of Job: its calls are coroutines. `sync` is the underlying Job."""

    def __init__(self, runner: _Runner, job: Job) -> None:
        self._runner = runner
        self.sync = job

    @property
    def id(self) -> str:
        """The same as Job.id."""
        return self.sync.id

    @property
    def state(self) -> JobState:
        """The same as Job.state."""
        return self.sync.state

    async def refresh(self, *, timeout: Optional[float] = None) -> JobState:
        """The same as Job.refresh()."""
        return await self._runner.run(self.sync.refresh, timeout=timeout)

    def progress(self, *, timeout: Optional[float] = None) -> AsyncIterator[JobState]:
        """The same as Job.progress(): `async for state in job.progress(): …`"""
        token = Cancel()
        return self._runner.each(self.sync.progress(timeout=timeout, cancel=token), token)

    async def wait(self, *, timeout: Optional[float] = None) -> JobState:
        """The same as Job.wait()."""
        return await self._runner.run(self.sync.wait, timeout=timeout)

    async def result(self, *, timeout: Optional[float] = None) -> AsyncAnswer:
        """The same as Job.result()."""
        return _of_answer(self._runner, await self._runner.run(self.sync.result, timeout=timeout))

    async def cancel(self, *, timeout: Optional[float] = None) -> bool:
        """The same as Job.cancel()."""
        return await self._runner.run(self.sync.cancel, timeout=timeout)


class AsyncClient:
    """The asyncio version of Client: its calls are coroutines. Cancelling a task closes its connection. `sync` is the underlying Client.

        async with AsyncClient("http://127.0.0.1:8080") as client:
            mesh = await client.put("barrel.glb")
            answer = await mesh.fracture(material="wood", fragments=40)
    """

    def __init__(self, url: str, token: Optional[str] = None, timeout: Optional[float] = 300.0, *, realtime: bool = False,
                 tls: Optional[ssl.SSLContext] = None, settings: Settings = Settings()) -> None:
        """Takes the arguments of Client, and raises the same errors."""
        self.sync = Client(url, token, timeout, realtime=realtime, tls=tls, settings=settings)
        self._runner = _Runner()

    async def __aenter__(self) -> "AsyncClient":
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Cancels all running calls and closes the connections."""
        self.sync.close()
        await self._runner.close()

    async def put(self, mesh: Union[Path, Content], *, files: Optional[Files] = None, format: Optional[str] = None,
                  timeout: Optional[float] = None, **preparation: Any) -> AsyncMesh:
        """The same as Client.put()."""
        made = await self._runner.run(self.sync.put, mesh, files=files, format=format, timeout=timeout, **preparation)
        return AsyncMesh(self._runner, made)

    def mesh(self, id: str) -> AsyncMesh:
        """The same as Client.mesh()."""
        return AsyncMesh(self._runner, self.sync.mesh(id))

    async def inspect(self, mesh: Union[Path, Content], *, files: Optional[Files] = None, format: Optional[str] = None,
                      timeout: Optional[float] = None, **preparation: Any) -> Dict[str, Any]:
        """The same as Client.inspect()."""
        return await self._runner.run(self.sync.inspect, mesh, files=files, format=format, timeout=timeout, **preparation)

    async def fracture(self, mesh: Union[AsyncMesh, Path, Content], parameters: Optional[Parameters] = None, *,
                       files: Optional[Files] = None, format: Optional[str] = None, timeout: Optional[float] = None,
                       realtime: Optional[bool] = None, **more: Any) -> AsyncAnswer:
        """The same as Client.fracture()."""
        of = mesh.sync if isinstance(mesh, AsyncMesh) else mesh
        answer = await self._runner.run(self.sync.fracture, of, parameters, files=files, format=format, timeout=timeout,
                                        realtime=realtime, **more)
        return _of_answer(self._runner, answer)

    async def answer(self, location: str, *, unless: Optional[str] = None,
                     timeout: Optional[float] = None) -> Optional[AsyncAnswer]:
        """The same as Client.answer()."""
        answer = await self._runner.run(self.sync.answer, location, unless=unless, timeout=timeout)
        return None if answer is None else _of_answer(self._runner, answer)

    async def job(self, mesh: Union[AsyncMesh, Path, Content], parameters: Optional[Parameters] = None, *,
                  timeout: Optional[float] = None, **more: Any) -> AsyncJob:
        """The same as Client.job()."""
        of = mesh.sync if isinstance(mesh, AsyncMesh) else mesh
        return AsyncJob(self._runner, await self._runner.run(self.sync.job, of, parameters, timeout=timeout, **more))

    async def find_job(self, id: str, *, timeout: Optional[float] = None) -> AsyncJob:
        """The same as Client.find_job()."""
        return AsyncJob(self._runner, await self._runner.run(self.sync.find_job, id, timeout=timeout))

    async def jobs(self, state: Optional[str] = None, *, timeout: Optional[float] = None) -> AsyncIterator[AsyncJob]:
        """The same as Client.jobs(): `async for job in client.jobs(): …`"""
        token = Cancel()
        async for job in self._runner.each(self.sync.jobs(state, timeout=timeout, cancel=token), token):
            yield AsyncJob(self._runner, job)

    async def index(self, *, timeout: Optional[float] = None) -> Dict[str, Any]:
        """The same as Client.index()."""
        return await self._runner.run(self.sync.index, timeout=timeout)

    async def version(self, *, timeout: Optional[float] = None) -> Dict[str, Any]:
        """The same as Client.version()."""
        return await self._runner.run(self.sync.version, timeout=timeout)

    async def limits(self, *, timeout: Optional[float] = None) -> Dict[str, Any]:
        """The same as Client.limits()."""
        return await self._runner.run(self.sync.limits, timeout=timeout)

    async def patterns(self, *, timeout: Optional[float] = None) -> Dict[str, Any]:
        """The same as Client.patterns()."""
        return await self._runner.run(self.sync.patterns, timeout=timeout)

    async def openapi(self, *, timeout: Optional[float] = None) -> Dict[str, Any]:
        """The same as Client.openapi()."""
        return await self._runner.run(self.sync.openapi, timeout=timeout)

    async def explain(self, problem: Union[str, FractureError], *, timeout: Optional[float] = None) -> str:
        """The same as Client.explain()."""
        return await self._runner.run(self.sync.explain, problem, timeout=timeout)

    async def request(self, method: str, path: str, *, body: bytes = b"", headers: Optional[Mapping[str, str]] = None,
                      timeout: Optional[float] = None) -> Response:
        """The same as Client.request()."""
        return await self._runner.run(self.sync.request, method, path, body=body, headers=headers, timeout=timeout)


def _of_answer(runner: _Runner, answer: Answer) -> AsyncAnswer:
    made = AsyncAnswer.__new__(AsyncAnswer)  # skips __init__(), which would parse the file again
    made.__dict__.update(answer.__dict__, _runner=runner)
    return made
