"""The server of OPC UA in a thread of its own; its method gives the same orders as a controller.

On this computer it may be open. Beyond it a channel is signed and encrypted (Basic256Sha256), and a
user shows a token as the password.
"""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
import logging
import threading
from collections.abc import Awaitable, Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import DataError, UsageError
from motorid.workflow.access import Caller, Tokens
from motorid.workflow.witness import Witness

if TYPE_CHECKING:
    from asyncua import Server

    from motorid.quality.product import Product
    from motorid.report.screen import Screen
    from motorid.workflow.check import Inspection
    from motorid.workflow.opcua.nodes import StationNodes
    from motorid.workflow.orders import Message
    from motorid.workflow.station import Station

    News = Callable[[StationNodes], Awaitable[None]]

NEEDED = "--opcua needs asyncua: pip install 'motorid[plant]'"
BEGINS_S = 120.0  # for the address space; two seconds as a rule
ENDS_S = 10.0
LONGEST = 200  # characters of a serial number or a reason
NOBODY = Caller("opcua")
_calling: contextvars.ContextVar[Caller | None] = contextvars.ContextVar("calling", default=None)


@dataclass(frozen=True)
class Place:
    """Where it listens; with a certificate, the channel is encrypted. ``tokens``: else anybody."""

    host: str
    port: int
    certificate: Path | None = None
    key: Path | None = None
    tokens: Tokens | None = None

    @property
    def url(self) -> str:
        """What a client opens."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"opc.tcp://{host}:{self.port}/motorid"


class OpcUaWitness(Witness):
    """Serves a station while ``running``."""

    def __init__(self, place: Place, name: str, product: Product) -> None:
        try:
            import asyncua  # noqa: F401
        except ImportError:
            raise UsageError(NEEDED) from None
        self.place, self.name, self.product = place, name, product
        self.station: Station | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._news: asyncio.Queue[News | None] = asyncio.Queue()
        self._begun: Future[None] = Future()
        self._thread = threading.Thread(target=self._run, name="opcua", daemon=True)

    @contextlib.contextmanager
    def running(self, station: Station) -> Iterator[None]:
        """While it lasts, clients find the station. Raises UsageError where it cannot listen."""
        logger = logging.getLogger("asyncua")
        logger.setLevel(logging.CRITICAL)  # what clients do wrong is no matter of the screen
        self.station = station
        self._thread.start()
        self._begun.result(BEGINS_S)
        try:
            yield
        finally:
            self._post(None)
            self._thread.join(ENDS_S)

    # ---- the station's thread

    def shown(self, screen: Screen) -> None:
        """See ``Witness``."""
        self._post(lambda nodes: nodes.shown(screen))

    def judged(self, done: Inspection) -> None:
        """See ``Witness``."""
        self._post(lambda nodes: nodes.judged(done))

    def _post(self, news: News | None) -> None:
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):  # it has ended
                self._loop.call_soon_threadsafe(self._news.put_nowait, news)

    # ---- its own thread

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as error:
            if self._begun.done():
                raise
            self._begun.set_exception(self._said(error))

    def _said(self, error: BaseException) -> BaseException:
        if isinstance(error, OSError | ValueError):
            return UsageError(
                f"--opcua {self.place.host}:{self.place.port} cannot be served ({error}): is "
                "another program there, and is the certificate's key an RSA key in PEM?"
            )
        return error

    async def _serve(self) -> None:
        from motorid.workflow.opcua.nodes import StationNodes

        server = await self._made()
        nodes = StationNodes(server, self.name, self.product, self._inspect)
        await nodes.fill()
        async with server:
            self._loop = asyncio.get_running_loop()
            self._begun.set_result(None)
            while (news := await self._news.get()) is not None:
                await news(nodes)

    async def _made(self) -> Server:
        """The server with its security, before it listens."""
        from asyncua import Server, ua

        place = self.place
        server = Server(user_manager=Users(place.tokens))
        await server.init()
        server.set_endpoint(place.url)
        server.set_server_name(f"motorid {self.name}".strip())
        policy = ua.SecurityPolicyType.NoSecurity
        if place.certificate is not None and place.key is not None:
            policy = ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt
            await server.load_certificate(place.certificate.read_bytes(), "pem")
            await server.load_private_key(place.key.read_bytes(), format="pem")
            if uri := _uri_of(place.certificate.read_bytes()):
                await server.set_application_uri(uri)
        server.set_security_policy([policy], permission_ruleset=Rules())
        identity = ua.UserNameIdentityToken if place.tokens else ua.AnonymousIdentityToken
        server.set_identity_tokens([identity])
        return server

    async def _inspect(self, serial: str, reason: str) -> tuple[bool, str]:
        """The method: an order by the rules of all orders. It waits for disk and history."""
        if len(serial) > LONGEST or len(reason) > LONGEST:
            return False, f"a serial number and a reason have at most {LONGEST} characters"
        caller = _calling.get() or NOBODY
        if self.place.tokens is not None and not caller.role:
            return False, "this station wants a token first"  # never a right by default
        answers: list[Message] = []
        order = {"order": "inspect", "serial": serial, "reason": reason}
        assert self.station is not None
        await asyncio.to_thread(self.station.take, order, answers.append, caller)
        first = answers[0]
        return first["event"] == "accepted", str(first.get("message", ""))


class Users:
    """Who opens a session: by the token in place of a password, whatever the user's name."""

    def __init__(self, tokens: Tokens | None) -> None:
        self.tokens = tokens

    def get_user(
        self, _: Any, username: Any = None, password: Any = None, certificate: Any = None
    ) -> Any:
        """None: it is refused. See asyncua's UserManager."""
        from asyncua.crypto.permission_rules import User, UserRole

        if self.tokens is None:
            return _user(User(UserRole.User, NOBODY.who), NOBODY)
        if isinstance(password, bytes):
            password = password.decode("utf-8", "replace")
        try:
            caller = self.tokens.caller(password) if isinstance(password, str) else None
        except DataError:
            return None
        return None if caller is None else _user(User(UserRole.User, caller.who), caller)


def _user(user: Any, caller: Caller) -> Any:
    user.caller = Caller(f"{caller.who} by opcua", caller.role) if caller.role else caller
    return user


class Rules:
    """asyncua's own rules of what a session may ask; they note for the method who calls."""

    def __init__(self) -> None:
        from asyncua.crypto.permission_rules import SimpleRoleRuleset

        self.usual = SimpleRoleRuleset()

    def check_validity(self, user: Any, action: Any, body: Any) -> bool:
        """See asyncua's PermissionRuleset."""
        _calling.set(getattr(user, "caller", None))
        return bool(self.usual.check_validity(user, action, body))


def _uri_of(pem: bytes) -> str:
    """The application that a certificate names; "": none."""
    from cryptography import x509

    extensions = x509.load_pem_x509_certificate(pem).extensions
    try:
        names = extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return ""
    return next(iter(names.get_values_for_type(x509.UniformResourceIdentifier)), "")
