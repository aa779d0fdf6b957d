"""One TLS connection that a thread reads while another writes.

OpenSSL's connection is no object for two threads at once. So reads and writes take turns by a lock,
and neither waits while it holds it.
"""

from __future__ import annotations

import io
import select
import socket
import ssl
import threading
from typing import Any

HANDSHAKE_S = 10.0
SEND_S = 60.0  # for a client to make room


class TlsLink(io.RawIOBase):
    """The server's side of a connection. Raises OSError where the handshake fails or it ends."""

    def __init__(self, plain: socket.socket, context: ssl.SSLContext) -> None:
        plain.settimeout(HANDSHAKE_S)
        self._tls = context.wrap_socket(plain, server_side=True)
        self._tls.setblocking(False)
        self._lock = threading.Lock()

    def readable(self) -> bool:
        """Yes."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Waits for bytes; 0: the client has ended the connection."""
        into = memoryview(buffer)
        while True:
            with self._lock:
                try:
                    return self._tls.recv_into(into)
                except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
                    pass
                except ssl.SSLEOFError:
                    return 0
            select.select([self._tls], [], [])

    def sendall(self, data: bytes) -> None:
        """All of it. Raises OSError where the client takes nothing for too long."""
        left = memoryview(data)
        while left:
            with self._lock:
                try:
                    left = left[self._tls.send(left) :]
                    continue
                except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
                    pass
            if not any(select.select([], [self._tls], [], SEND_S)):
                raise TimeoutError("the client takes no answers")

    def shutdown(self, how: int) -> None:
        """Ends the connection from any thread; what is going on in others ends too."""
        socket.socket.shutdown(self._tls, how)  # its own would take the TLS from under them

    def close(self) -> None:
        """Gives the connection back."""
        if not self.closed:
            socket.socket.close(self._tls)
        super().close()
