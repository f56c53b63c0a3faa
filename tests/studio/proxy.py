"""A reverse proxy that takes a prefix off, as `location /studio/` with `proxy_pass …/` does."""

from __future__ import annotations

import asyncio
import contextlib
import threading

PIECE = 2**16


class Proxy:
    """Listens on a port of its own, on a thread; `with` it, then `port` says where."""

    def __init__(self, prefix: str) -> None:
        self.prefix, self.port, self.behind = prefix, 0, 0
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> Proxy:
        self._thread.start()
        assert self._ready.wait(10)
        return self

    def __exit__(self, *_error: object) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(10)

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        server = self._loop.run_until_complete(
            asyncio.start_server(self._passed_on, "127.0.0.1", 0, limit=PIECE)
        )
        self.port = server.sockets[0].getsockname()[1]
        self._ready.set()
        self._loop.run_forever()
        server.close()
        for task in asyncio.all_tasks(self._loop):
            task.cancel()
        self._loop.run_until_complete(asyncio.sleep(0.05))
        self._loop.close()

    async def _passed_on(self, near: asyncio.StreamReader, back: asyncio.StreamWriter) -> None:
        """One request, or one socket to its end: the path without the prefix, all else as it is."""
        with contextlib.suppress(OSError, asyncio.IncompleteReadError, asyncio.CancelledError):
            head = (await near.readuntil(b"\r\n\r\n")).decode("latin-1")
            method, path, rest = head.split(" ", 2)
            if not path.startswith(self.prefix + "/"):
                back.write(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")
                back.close()
                return
            if "upgrade: websocket" not in rest.lower():
                rest = rest.replace("\r\n\r\n", "\r\nConnection: close\r\n\r\n")
            far, forth = await asyncio.open_connection("127.0.0.1", self.behind)
            forth.write(f"{method} {path.removeprefix(self.prefix)} {rest}".encode("latin-1"))
            await asyncio.gather(_copied(near, forth), _copied(far, back))


async def _copied(source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):
        while piece := await source.read(PIECE):
            target.write(piece)
            await target.drain()
    target.close()
