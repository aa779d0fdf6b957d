"""What a line controller may order over the station's local interface: JSON, one object a line."""

from __future__ import annotations

import ipaddress
import socket
import socketserver
import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any

from motorid import json_text
from motorid.errors import UsageError

LONGEST_LINE = 65_536
MOST_CLIENTS = 16
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

    Raises UsageError where the address is taken.
    """

    daemon_threads = True
    allow_reuse_address = sys.platform != "win32"  # there it would let two stations share a port

    def __init__(self, address: tuple[str, int], take: Take) -> None:
        self.take = take
        self.clients = threading.BoundedSemaphore(MOST_CLIENTS)
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


class _Client(socketserver.StreamRequestHandler):
    """One connection. Its first line that is no order ends it: whoever is there speaks no JSON."""

    server: Orders

    def setup(self) -> None:
        super().setup()
        self.lock = threading.Lock()

    def handle(self) -> None:
        if not self.server.clients.acquire(blocking=False):
            self.answer({"event": "error", "message": f"more than {MOST_CLIENTS} connections"})
            return
        try:
            self.serve()
        except OSError:
            return  # it has gone; its orders are carried out, their results are on disk
        finally:
            self.server.clients.release()

    def serve(self) -> None:
        while line := self.rfile.readline(LONGEST_LINE):
            try:
                order = read_order(line)
            except ValueError as error:
                self.answer({"event": "error", "message": str(error)})
                return
            self.server.take(order, self.answer)

    def answer(self, message: Mapping[str, Any]) -> None:
        """One line back; quietly nowhere when the client has gone."""
        data = json_text.dumps(message).encode() + b"\n"
        with self.lock:
            try:
                self.connection.sendall(data)
            except OSError:
                return


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
    return order
