"""One page's server, in a thread of its own beside the run that it shows."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Awaitable, Callable
from types import TracebackType

from motorid.errors import UsageError
from motorid.web.address import Address
from motorid.web.guard import App, Guard

LONGEST_MESSAGE = 1024  # bytes that a page may send at once
MOST_CONNECTIONS = 128
LAST_WORDS_S = 2.0  # for pages to take the last status, and for the thread to end
NEEDED = "the live page needs starlette, uvicorn and websockets: pip install 'motorid[web]'"


class Server:
    """Serves what ``app`` makes at an address while it lasts. ``url`` is what a person opens.

    Raises UsageError where the address is taken, or the extra [web] is not installed.
    """

    def __init__(self, app: Callable[[], App], address: Address) -> None:
        try:
            import uvicorn
            import websockets  # noqa: F401 - uvicorn's, for the frames
        except ImportError:
            raise UsageError(NEEDED) from None
        self._socket = address.bind()
        self.port = int(self._socket.getsockname()[1])
        self.url = address.url(self.port)
        config = uvicorn.Config(
            Guard(app(), address),
            http="h11",
            ws="websockets-sansio",
            ws_max_size=LONGEST_MESSAGE,
            ws_per_message_deflate=False,
            loop="asyncio",
            lifespan="on",
            log_config=None,
            log_level="critical",
            access_log=False,
            server_header=False,
            proxy_headers=False,
            limit_concurrency=MOST_CONNECTIONS,
            timeout_graceful_shutdown=1,
        )
        config.load()
        config.ssl = address.tls
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._serve, name="page", daemon=True)

    def _serve(self) -> None:
        asyncio.run(self._server.serve(sockets=[self._socket]))

    def __enter__(self) -> Server:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._server.should_exit = True
        self._thread.join(LAST_WORDS_S)
        self._socket.close()


def beside(work: Callable[[], Awaitable[None]]) -> Callable[[object], object]:
    """A lifespan: ``work`` runs as long as the server does."""

    @contextlib.asynccontextmanager
    async def lifespan(_: object) -> AsyncIterator[None]:
        task = asyncio.ensure_future(work())
        try:
            yield
        finally:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task

    return lifespan
