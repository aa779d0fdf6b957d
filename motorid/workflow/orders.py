"""What a line controller may order over the station's local interface: JSON, one object a line."""

from __future__ import annotations

import contextlib
import io
import itertools
import queue
import socket
import socketserver
import ssl
import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any

from motorid import json_text
from motorid.errors import DataError, UsageError
from motorid.workflow.access import Caller, Tokens
from motorid.workflow.tls_link import TlsLink

LONGEST_LINE = 65_536
LONGEST_VALUE = 200  # characters of JSON: it is kept, and it is sent back
MOST_CLIENTS = 16
MOST_ANSWERS = 64  # that a client may leave unread, beside what its connection holds
POLL_S = 0.1  # until it hears that it is to end
HELLO = "hello"
IDLE_S, TRY_S, TRIES = 60, 15, 4  # a peer whose machine is gone is noticed after two minutes
LAST_WORDS_S = 1.0  # for a client to take its last answers
Message = dict[str, Any]
Answer = Callable[[Message], None]
Take = Callable[[Message, Answer, Caller], None]  # an order, where its answers go, who gives it


class Orders(socketserver.ThreadingTCPServer):
    """Takes orders from line controllers; each connection has a thread. ``port`` is the one bound.

    With ``tokens`` a connection begins with ``{"order": "hello", "token": ...}``. Where all places
    are taken, the connection that has said nothing for longest makes way, unless it waits for a
    verdict. Who has not shown the token yet is a stranger and takes no place from a client.
    Raises UsageError where the address is taken.
    """

    daemon_threads = True
    allow_reuse_address = sys.platform != "win32"  # there it would let two stations share a port

    def __init__(
        self,
        address: tuple[str, int],
        take: Take,
        tokens: Tokens | None = None,
        tls: ssl.SSLContext | None = None,
    ) -> None:
        self.take, self.tokens, self.tls = take, tokens, tls
        self._lock = threading.Lock()
        self._clients: dict[_Client, int] = {}  # and when each was last heard, by count
        self._strangers: dict[_Client, None] = {}  # oldest first; as many as clients at most
        self._heard = itertools.count()
        self.address_family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        try:
            super().__init__(address, _Client)
        except OSError as error:
            raise UsageError(
                f"{address[0]}:{address[1]} cannot be listened on ({error.strerror or error}): "
                "is another station running? --listen takes another port"
            ) from None
        self.port = int(self.server_address[1])
        threading.Thread(
            target=self.serve_forever, args=(POLL_S,), name="orders", daemon=True
        ).start()

    def stop(self) -> None:
        """Takes no more."""
        self.shutdown()
        self.server_close()

    def meet(self, client: _Client) -> None:
        """A place for a stranger; where all are taken, the oldest stranger makes way."""
        with self._lock:
            if len(self._strangers) >= MOST_CLIENTS:
                oldest = next(iter(self._strangers))
                del self._strangers[oldest]
                oldest.drop()
            self._strangers[client] = None

    def admit(self, client: _Client) -> bool:
        """A place for who may order; False: every other one waits for a verdict."""
        with self._lock:
            self._strangers.pop(client, None)
            if len(self._clients) >= MOST_CLIENTS:
                idle = [one for one in self._clients if not one.waits]
                if not idle:
                    return False
                oldest = min(idle, key=self._clients.__getitem__)
                del self._clients[oldest]
                oldest.drop()
            self._clients[client] = next(self._heard)
            return True

    def hear(self, client: _Client) -> None:
        """It has said something."""
        with self._lock:
            if client in self._clients:
                self._clients[client] = next(self._heard)

    def leave(self, client: _Client) -> None:
        """Its place is free."""
        with self._lock:
            self._clients.pop(client, None)
            self._strangers.pop(client, None)


class _Client(socketserver.StreamRequestHandler):
    """One connection. Its first line that is no order ends it: whoever is there speaks no JSON.

    Answers go through a bounded queue and a thread of their own, so that a client that never reads
    costs the station nothing: when its queue is full, the connection ends.
    """

    server: Orders
    waits = 0  # orders whose verdict is still to come
    rfile: io.BufferedIOBase

    def setup(self) -> None:
        super().setup()
        keep_alive(self.connection)
        self.link: socket.socket | TlsLink = self.connection
        self.answers: queue.Queue[bytes | None] = queue.Queue(MOST_ANSWERS)
        self.writer = threading.Thread(target=self._write, name="answers", daemon=True)

    def handle(self) -> None:
        self.server.meet(self)
        try:
            if self.server.tls is not None:
                self.link = TlsLink(self.connection, self.server.tls)
                self.rfile = io.BufferedReader(self.link)
            self.writer.start()
            if (caller := self.greeted()) is None:
                return
            if not self.server.admit(self):
                self.refuse(f"{MOST_CLIENTS} connections wait already")
                return
            if self.server.tokens is not None:
                self.answer({"event": HELLO})
            self.serve(caller.at(self.client_address[0]))
        except (OSError, ValueError):
            return  # it has gone, or speaks no TLS; its orders are carried out and on disk
        finally:
            self.server.leave(self)

    def finish(self) -> None:
        with contextlib.suppress(queue.Full):
            self.answers.put_nowait(None)
            if self.writer.is_alive():
                self.writer.join(LAST_WORDS_S)  # what is queued, as far as the client takes it
        with contextlib.suppress(OSError):
            self.link.close()
            super().finish()

    def serve(self, caller: Caller) -> None:
        while (order := self.next_order()) is not None:
            self.server.take(order, self.answer, caller)

    def next_order(self) -> Message | None:
        """The next line's; None where there is none, or none that is an order: that is answered."""
        line = self.rfile.readline(LONGEST_LINE)
        if not line:
            return None
        self.server.hear(self)
        try:
            return read_order(line)
        except ValueError as error:
            self.refuse(str(error))
            return None

    def greeted(self) -> Caller | None:
        """Who is there, by the first line; who shows no token gets a sentence."""
        if self.server.tokens is None:
            return Caller("controller")
        if (first := self.next_order()) is None:
            return None
        try:
            caller = self.server.tokens.caller(str(first.get("token", "")))
        except DataError as error:
            self.refuse(f"the station cannot read its tokens ({error})")
            return None
        if first["order"] != HELLO or caller is None:
            self.refuse('this station wants a token first: {"order": "hello", "token": "..."}')
            return None
        return caller

    def refuse(self, why: str) -> None:
        self.answer({"event": "error", "message": why})

    def answer(self, message: Mapping[str, Any]) -> None:
        """One line back, without waiting; a client that does not read loses its connection."""
        self.waits += message.get("event") == "accepted"
        self.waits -= bool(message.get("ends"))
        said = {name: value for name, value in message.items() if name != "ends"}
        try:
            self.answers.put_nowait(json_text.dumps(said).encode() + b"\n")
        except queue.Full:
            self.drop()

    def drop(self) -> None:
        """Ends the connection from another thread."""
        with contextlib.suppress(OSError):
            self.link.shutdown(socket.SHUT_RDWR)

    def _write(self) -> None:
        while (data := self.answers.get()) is not None:
            try:
                self.link.sendall(data)
            except OSError:
                return  # quietly: it has gone


def keep_alive(link: socket.socket) -> None:
    """Asks a silent peer for a sign of life, as often as this system lets that be said."""
    link.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in (
        ("TCP_KEEPIDLE", IDLE_S),
        ("TCP_KEEPINTVL", TRY_S),
        ("TCP_KEEPCNT", TRIES),
    ):
        if (option := getattr(socket, name, None)) is not None:
            link.setsockopt(socket.IPPROTO_TCP, option, value)


def read_order(line: bytes) -> Message:
    """The object in a line. Raises ValueError, in a sentence, for anything else."""
    if not line.endswith(b"\n"):
        raise ValueError(
            f"an order is one line of at most {LONGEST_LINE} bytes, ended by a newline"
        )
    try:
        order = json_text.loads(line)
    except json_text.JsonError as error:
        raise ValueError(f"an order is a JSON object on one line: {error}") from None
    if not isinstance(order, dict) or not isinstance(order.get("order"), str):
        raise ValueError('an order is a JSON object with "order"')
    long = [name for name, value in order.items() if len(json_text.dumps(value)) > LONGEST_VALUE]
    if long:
        raise ValueError(f"{long[0][:40]!r} of an order is longer than {LONGEST_VALUE} characters")
    return order
