"""The studio on the network: its routes, and what stands before them."""

from __future__ import annotations

import asyncio
import contextlib
import mimetypes
import tempfile
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import quote

import msgspec
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, RedirectResponse, Response, StreamingResponse
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from motes import ConfigError, MotesError
from motes.formats import registry
from motes_studio import commands, files, messages, protocol
from motes_studio.clients import Client
from motes_studio.files import Question
from motes_studio.film_worker import LaterError, prepare
from motes_studio.safety import COOKIE, FILM_ENDINGS, HEADERS, Guard, plain_name
from motes_studio.sessions import LiveSession
from motes_studio.studio import Studio, presets

PAGE = Path(__file__).with_name("page")
"""The files of the page."""
AGAIN = 1012
"""The code with which a WebSocket closes that is to be opened again."""
SOON = 409
"""The status where the film is read anew: the page asks again by itself."""
GIVEN_UP = 499
"""The status of an answer that nobody waits for any more."""
PIECE = 1 << 20
"""Bytes of a file that are sent at a time."""

Endpoint = Callable[[Request], Coroutine[Any, Any, Response]]


def app(studio: Studio, guard: Guard) -> ASGIApp:
    """Return the application that serves a studio."""

    @contextlib.asynccontextmanager
    async def life(_: Starlette) -> AsyncIterator[None]:
        asyncio.get_running_loop().set_exception_handler(_noted)
        prepare()
        tidy = asyncio.create_task(studio.tidy())
        try:
            yield
        finally:
            tidy.cancel()
            studio.close()

    api = _Api(studio)
    routes = [
        Route("/", _page),
        Mount("/static", StaticFiles(directory=PAGE), name="static"),
        Route("/api/films", _plain(api.films)),
        Route("/api/uploads", _plain(api.upload), methods=["POST"]),
        Route("/api/samples/{name}", _plain(api.sample), methods=["POST"]),
        Route("/api/presets", _plain(api.presets)),
        Route("/api/sessions", _plain(api.sessions)),
        Route("/api/sessions", _plain(api.begin), methods=["POST"]),
        Route("/api/sessions/{id}", _plain(api.session)),
        Route("/api/sessions/{id}", _plain(api.remove), methods=["DELETE"]),
        Route("/api/sessions/{id}/frames/{index:int}.jpg", _plain(api.frame)),
        Route("/api/sessions/{id}/overlays/{index:int}", api.about(files.overlay)),
        Route("/api/sessions/{id}/doubts", api.about(files.doubts)),
        Route("/api/sessions/{id}/times", api.about(files.times)),
        Route("/api/sessions/{id}/strip", api.about(files.strip)),
        Route("/api/sessions/{id}/export", api.about(files.export)),
        Route("/api/sessions/{id}/command", api.about(files.command)),
        Route("/api/sessions/{id}/film", api.about(files.film)),
        Route("/api/sessions/{id}/import", _plain(api.take), methods=["POST"]),
        Route("/api/formats", _plain(api.formats)),
        WebSocketRoute("/api/sessions/{id}/ws", api.talk),
    ]
    return _Gate(Starlette(routes=routes, lifespan=life), guard)


def _noted(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Pass over a connection that the system does not give; the loop waits and tries again."""
    if not isinstance(context.get("exception"), OSError):
        loop.default_exception_handler(context)


async def _page(_: Request) -> Response:
    return FileResponse(PAGE / "index.html", media_type="text/html; charset=utf-8")


def _json(content: Any, status: int = 200) -> Response:
    return Response(msgspec.json.encode(content), status, media_type="application/json")


def _refused(error: str, status: int) -> Response:
    return _json(messages.Failure(error), status)


def _plain(answer: Endpoint) -> Endpoint:
    """Return an endpoint whose errors are one line of JSON."""

    async def endpoint(request: Request) -> Response:
        try:
            if request.method == "GET":
                return await _while_wanted(request, answer)
            return await answer(request)
        except (msgspec.MsgspecError, RecursionError) as error:
            return _refused(f"The request cannot be read: {error}.", 400)
        except MotesError as error:
            return _refused(str(error), SOON if isinstance(error, LaterError) else 400)
        except ClientDisconnect:
            return Response(status_code=GIVEN_UP)
        except OSError as error:  # as when no file can be opened any more
            return _refused(f"The system refuses: {error.strerror or error}. Try again later.", 503)

    return endpoint


async def _while_wanted(request: Request, answer: Endpoint) -> Response:
    """Return the answer to a request; cancel the work on it once the page has given it up."""
    work, left = asyncio.ensure_future(answer(request)), asyncio.create_task(_left(request))
    try:
        await asyncio.wait((work, left), return_when=asyncio.FIRST_COMPLETED)
        return work.result() if work.done() else Response(status_code=GIVEN_UP)
    finally:
        work.cancel()
        left.cancel()


async def _left(request: Request) -> None:
    """Wait until the page has given a request up."""
    while (await request.receive())["type"] != "http.disconnect":
        pass


class _Api:
    """The answers to requests."""

    def __init__(self, studio: Studio) -> None:
        self._studio = studio

    async def films(self, _: Request) -> Response:
        return _json(await asyncio.to_thread(self._studio.films.listed))

    async def upload(self, request: Request) -> Response:
        length = request.headers.get("content-length", "")
        name = request.query_params.get("name", "")
        size = int(length) if length.isdecimal() else None
        film = await self._studio.films.upload(name, size, request.stream())
        return _json(film, 201)

    async def sample(self, request: Request) -> Response:
        name = request.path_params["name"]
        return _json(await asyncio.to_thread(self._studio.films.sample, name), 201)

    async def presets(self, _: Request) -> Response:
        return _json(presets())

    async def sessions(self, _: Request) -> Response:
        return _json(self._studio.store.sessions())

    async def begin(self, request: Request) -> Response:
        parts = [part async for part in _parts(request, protocol.LARGEST_MESSAGE)]
        body = b"".join(parts)
        wanted = msgspec.json.decode(body, type=messages.Open)
        session = await self._studio.begin(**msgspec.structs.asdict(wanted))
        return _json(session.state(), 201)

    async def session(self, request: Request) -> Response:
        return _json((await self._session(request)).state())

    async def remove(self, request: Request) -> Response:
        self._studio.remove(request.path_params["id"])
        return Response(status_code=204)

    async def frame(self, request: Request) -> Response:
        session, about = await self._asked(request)
        index, width = about.index, about.width
        # A film does not change while it is open, so that a frame may stay with the browser.
        kind = "whole" if session.whole else "quick"
        tag = f'"{session.name}-{kind}-{index}-{width}"'
        headers = {"ETag": tag, "Cache-Control": "private, max-age=3600"}
        if request.headers.get("if-none-match") == tag:
            return Response(status_code=304, headers=headers)
        data = await session.picture(index, width)
        return Response(data, media_type="image/jpeg", headers=headers)

    def about(self, answer: Callable[[LiveSession, Question], Awaitable[object]]) -> Endpoint:
        """Return an endpoint that answers a question about a session, by a file or by JSON."""

        async def endpoint(request: Request) -> Response:
            found = await answer(*await self._asked(request))
            return _download(found) if isinstance(found, files.File) else _json(found)

        return _plain(endpoint)

    async def _asked(self, request: Request) -> tuple[LiveSession, Question]:
        words = {**request.query_params, **request.path_params}
        return await self._session(request), msgspec.convert(words, Question, strict=False)

    async def _session(self, request: Request) -> LiveSession:
        return await self._studio.session(request.path_params["id"])

    async def take(self, request: Request) -> Response:
        session = await self._session(request)
        most = self._studio.limits.imported
        name, form = (request.query_params.get(each) for each in ("name", "format"))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / plain_name(name or "rows")
            with path.open("xb") as file:
                async for part in _parts(request, most):
                    file.write(part)
            return _json(await files.take(session, path, form or None, most), 201)

    async def formats(self, _: Request) -> Response:
        every = registry.FORMATS.usable().items()
        known = {use: {name: form.title for name, form in every if getattr(form, use)}
                 for use in ("read", "write")}  # fmt: skip
        return _json({**known, "films": sorted(FILM_ENDINGS)})

    async def talk(self, socket: WebSocket) -> None:
        """Talk with a page, until it leaves."""
        await socket.accept()
        try:
            session = await self._studio.session(socket.path_params["id"])
        except MotesError as failed:
            await socket.send_text(protocol.encode(messages.Failure(str(failed))))
            await socket.close()
            return
        client = session.join()
        sending = asyncio.create_task(_send_to(client, socket))
        try:
            while True:
                text = await socket.receive_text()
                try:
                    command = protocol.decode(text)
                except ConfigError as error:
                    client.reply(messages.Reply(protocol.id_of(text), str(error)))
                    continue
                if isinstance(command, commands.Acknowledge):
                    client.acknowledge(command.number)
                else:
                    client.reply(session.obey(command))
        except (WebSocketDisconnect, KeyError):  # KeyError: a message of bytes
            pass
        finally:
            sending.cancel()
            session.leave(client)


async def _send_to(client: Client, socket: WebSocket) -> None:
    """Send a page what waits for it; at the end, let it connect again."""
    await client.run(socket.send_text)
    await socket.close(AGAIN)


async def _parts(request: Request, most: int) -> AsyncIterator[bytes]:
    """Yield the body of a request; raise a ConfigError if it is larger than `most` bytes."""
    size = 0
    async for part in request.stream():
        size += len(part)
        if size > most:
            raise ConfigError(f"This is larger than {most >> 10} kB; send less.")
        yield part


def _download(file: files.File) -> Response:
    name = quote(file.name)
    headers = {"Content-Disposition": f"attachment; filename*=UTF-8''{name}"}
    if file.said:
        headers["Motes-Said"] = file.said
    kind = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
    return StreamingResponse(_content(file.data), media_type=kind, headers=headers)


async def _content(data: BinaryIO) -> AsyncIterator[bytes]:
    with data:
        while part := data.read(PIECE):
            yield part


class _Gate:
    """Lets requests through that the guard allows, and gives all answers their headers."""

    def __init__(self, inner: ASGIApp, guard: Guard) -> None:
        self._inner, self._guard = inner, guard

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._inner(scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        answer = self._refusal(scope)
        if answer is None:
            await self._inner(scope, receive, with_headers)
        elif scope["type"] == "websocket":
            await WebSocket(scope, receive, send).close(4403)
        else:
            await answer(scope, receive, with_headers)

    def _refusal(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        error = self._guard.refusal(headers)
        if error is not None:
            return _refused(error, 403)
        request = Request({**scope, "type": "http"})
        if self._guard.knows(request.cookies.get(COOKIE)):
            return None
        given = request.query_params.get("token")
        opening = scope["type"] == "http" and scope["path"] == "/"
        if opening and given is not None and self._guard.knows(given):
            answer = RedirectResponse("/", 303)
            answer.set_cookie(COOKIE, given, httponly=True, samesite="strict")
            return answer
        return _refused("The token is missing; open the address that the studio has printed.", 403)
