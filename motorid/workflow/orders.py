"""What a line controller may order over the station's local interface: JSON, one object a line."""

from __future__ import annotations

import contextlib
import ipaddress
import itertools
import queue
import socket
import socketserver
import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any

from motorid import json_text
from motorid.errors import UsageError

LONGEST_LINE = 65_536
LONGEST_VALUE = 200  # characters of JSON: it is kept, and it is sent back
MOST_CLIENTS = 16
MOST_ANSWERS = 64  # that a client may leave unread, beside what its connection holds
LAST_WORDS_S = 1.0  # for a client to take its last answers
Message = dict[str, Any]
Answer = Callable[[Message], None]
Take = Callable[[Message, Answer], None]  # an order, and where its answers go


def parse_listen(text: str, *, remote: bool) -> tuple[str, int]:
    """Address of ``[HOST:]PORT``. Raises UsageError; beyond this computer unless ``remote``."""
    host, _, port = text.rpartition(":")
    host = host.strip("[]") or "127.0.0.1"
    if not port.isdecimal() or len(port) > 5 or int(port) > 65_535:
        raise UsageError(f"--listen {text}: write PORT or HOST:PORT")
    try:
        address = ipaddress.ip_address("127.0.0.1" if host == "localhost" else host)
    except ValueError:
        raise UsageError(f"--listen {text}: the host must be an IP address") from None
    if not address.is_loopback and not remote:
        raise UsageError(
            f"--listen {text} can be reached from other computers, and orders are not "
            "authenticated: stay on 127.0.0.1, or add --allow-remote on a closed network"
        )
    return str(address), int(port)


class Orders(socketserver.ThreadingTCPServer):
    """Takes orders from line controllers; each connection has a thread. ``port`` is the one bound.

    Where all places are taken, the connection that has said nothing for longest makes way, unless
    it waits for a verdict. Raises UsageError where the address is taken.
    """

    daemon_threads = True
    allow_reuse_address = sys.platform != "win32"  # there it would let two stations share a port

    def __init__(self, address: tuple[str, int], take: Take) -> None:
        self.take = take
        self._lock = threading.Lock()
        self._clients: dict[_Client, int] = {}  # and when each was last heard, by count
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
        threading.Thread(target=self.serve_forever, name="orders", daemon=True).start()

    def stop(self) -> None:
        """Takes no more."""
        self.shutdown()
        self.server_close()

    def admit(self, client: _Client) -> bool:
        """A place for a connection; False: every other one waits for a verdict."""
        with self._lock:
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


class _Client(socketserver.StreamRequestHandler):
    """One connection. Its first line that is no order ends it: whoever is there speaks no JSON.

    Answers go through a bounded queue and a thread of their own, so that a client that never reads
    costs the station nothing: when its queue is full, the connection ends.
    """

    server: Orders
    waits = 0  # orders whose verdict is still to come

    def setup(self) -> None:
        super().setup()
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        self.answers: queue.Queue[bytes | None] = queue.Queue(MOST_ANSWERS)
        self.writer = threading.Thread(target=self._write, name="answers", daemon=True)
        self.writer.start()

    def handle(self) -> None:
        if not self.server.admit(self):
            self.answer({"event": "error", "message": f"{MOST_CLIENTS} connections wait already"})
            return
        try:
            self.serve()
        except (OSError, ValueError):
            return  # it has gone; its orders are carried out, their results are on disk
        finally:
            self.server.leave(self)

    def finish(self) -> None:
        with contextlib.suppress(queue.Full):
            self.answers.put_nowait(None)
            self.writer.join(LAST_WORDS_S)  # what is queued, as far as the client takes it
        with contextlib.suppress(OSError):
            super().finish()

    def serve(self) -> None:
        while line := self.rfile.readline(LONGEST_LINE):
            self.server.hear(self)
            try:
                order = read_order(line)
            except ValueError as error:
                self.answer({"event": "error", "message": str(error)})
                return
            self.server.take(order, self.answer)

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
            self.connection.shutdown(socket.SHUT_RDWR)

    def _write(self) -> None:
        while (data := self.answers.get()) is not None:
            try:
                self.connection.sendall(data)
            except OSError:
                return  # quietly: it has gone


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
