"""Where a page is served: loopback, or beyond it with TLS. And who may ask there."""

from __future__ import annotations

import ipaddress
import secrets
import socket
import ssl
from dataclasses import dataclass, field
from pathlib import Path

from motorid.errors import DataError, UsageError
from motorid.workflow.access import Caller, Tokens

DEFAULT_LISTEN = "127.0.0.1:7411"
LOOPBACK_NAMES = ("localhost",)


@dataclass(frozen=True)
class Address:
    """A place to listen, its token, and its certificate where it is reached through TLS.

    ``token`` is new for each start; ``tokens`` are those of persons, if any.
    """

    host: str
    port: int
    tls: ssl.SSLContext | None = None
    token: str = field(default_factory=lambda: secrets.token_hex(24))
    option: str = "--listen"  # which names it, for what is said
    tokens: Tokens | None = None

    @property
    def scheme(self) -> str:
        """Of the page's address."""
        return "https" if self.tls else "http"

    @property
    def loopback(self) -> bool:
        """Whether only this computer reaches it."""
        return ipaddress.ip_address(self.host).is_loopback

    def caller(self, token: str) -> Caller | None:
        """Whose token that is; None: nobody's."""
        if secrets.compare_digest(token.encode("utf-8", "replace"), self.token.encode()):
            return Caller()
        try:
            return self.tokens.caller(token) if self.tokens is not None else None
        except DataError:
            return None  # whoever has broken the file is not let in by it

    def bind(self) -> socket.socket:
        """A socket that holds the place. Raises UsageError where another program has it."""
        family = socket.AF_INET6 if ":" in self.host else socket.AF_INET
        taken = socket.socket(family, socket.SOCK_STREAM)
        try:
            if hasattr(socket, "SO_EXCLUSIVEADDRUSE"):  # Windows would let two share it
                taken.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
            else:
                taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            taken.bind((self.host, self.port))
            taken.listen()  # so that who comes before the server runs waits
        except OSError as error:
            taken.close()
            raise UsageError(
                f"{self.host}:{self.port} cannot be listened on ({error.strerror or error}): "
                f"{self.option} takes another port, and {self.option} 0 any that is free"
            ) from None
        return taken

    def url(self, port: int) -> str:
        """What a person opens, token included; ``port`` is the one that was bound."""
        name = self.host
        if ipaddress.ip_address(name).is_unspecified:
            name = socket.gethostname()
        name = f"[{name}]" if ":" in name else name
        return f"{self.scheme}://{name}:{port}/{self.token}/"

    def admits_host(self, name: str) -> bool:
        """Whether a request for that name is meant for this place.

        A name that somebody else's name server points here is not: only an address or this
        computer's own name is. So no page of a foreign name can reach it through a browser.
        """
        try:
            one = ipaddress.ip_address(name)
        except ValueError:
            own = socket.gethostname().lower()  # no question to a name server, which may wait
            return name in LOOPBACK_NAMES or (not self.loopback and name in (own, f"{own}.local"))
        return one.is_loopback or not self.loopback


def parse_listen(
    text: str,
    *,
    remote: bool = False,
    certificate: Path | None = None,
    key: Path | None = None,
    option: str = "--listen",
    tokens: Tokens | None = None,
) -> Address:
    """The address of ``[HOST:]PORT``, which ``option`` named. Raises UsageError.

    Beyond this computer it needs ``remote``, and a certificate with its key.
    """
    host, _, port = text.rpartition(":")
    host = host.strip("[]") or "127.0.0.1"
    if not (port.isascii() and port.isdecimal() and len(port) <= 5 and int(port) <= 65_535):
        raise UsageError(f"{option} {text}: write PORT or HOST:PORT, such as {DEFAULT_LISTEN}")
    try:
        address = ipaddress.ip_address("127.0.0.1" if host == "localhost" else host)
    except ValueError:
        raise UsageError(f"{option} {text}: the host must be an IP address") from None
    if not address.is_loopback and not remote:
        raise UsageError(
            f"{option} {text} can be reached from other computers: stay on 127.0.0.1 (ssh -L "
            "brings it to yours), or add --allow-remote with --certificate and --key"
        )
    if not address.is_loopback and certificate is None:
        raise UsageError(
            f"{option} {text} goes over a network, so it needs TLS: add --certificate and --key, "
            "two PEM files (`openssl req -x509 -newkey rsa:2048 -nodes -days 365 -keyout key.pem "
            "-out cert.pem` makes a pair)"
        )
    return Address(
        str(address), int(port), _context(certificate, key), option=option, tokens=tokens
    )


def _context(certificate: Path | None, key: Path | None) -> ssl.SSLContext | None:
    if certificate is None and key is None:
        return None
    if certificate is None or key is None:
        raise UsageError("--certificate and --key belong together: name both, two PEM files")
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key, password=_no_password)
    except (OSError, ValueError) as error:  # SSLError is an OSError
        said = getattr(error, "strerror", None) or error
        raise UsageError(
            f"{certificate} and {key} are no certificate and its key in PEM, without a password "
            f"({said})"
        ) from None
    return context


def _no_password() -> str:
    raise ValueError("the key asks for a password")
