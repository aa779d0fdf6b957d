"""A station at its broker, in threads of its own: a broker that is away or hangs costs no motor.

The station's thread only leaves notes. One thread here sends and keeps the outbox; one of the
client's reads, and leaves notes as well.
"""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from motorid.errors import DataError, UsageError
from motorid.workflow.mqtt import messages
from motorid.workflow.mqtt.outbox import Outbox
from motorid.workflow.mqtt.settings import Broker, station_level
from motorid.workflow.witness import Witness

if TYPE_CHECKING:
    from paho.mqtt.client import Client, MQTTMessage

    from motorid.report.screen import Screen
    from motorid.workflow.check import Inspection

KEEPALIVE_S = 15  # a broker that says nothing for so long is left, and tried again
CONNECT_S = 5.0
TURN_S = 0.2
LAST_WORDS_S = 3.0
NOT_YET = "not connected yet"
NEEDED = "--mqtt needs paho-mqtt: pip install 'motorid[plant]'"
UNCONFIRMED = (
    "mqtt: no consumer acknowledges verdicts (acknowledged = true), so one counts as sent when the "
    "broker has it; a broker that is full or restarts may lose it"
)
Tell = Callable[[str], None]
T = TypeVar("T")


class MqttWitness(Witness):
    """Publishes what a station does, below the broker's topic and the station's name.

    Raises UsageError where the name is no level of a topic, or paho-mqtt is not installed.
    """

    def __init__(self, broker: Broker, station: str, product: str, folder: Path) -> None:
        try:
            import paho.mqtt.client  # noqa: F401
        except ImportError:
            raise UsageError(NEEDED) from None
        self.broker, self.station, self.product = broker, station_level(station), product
        self.topics = messages.Topics(f"{broker.topic}/{self.station}")
        self.trouble = NOT_YET
        self.tell: Tell = _nobody
        self._outbox = Outbox(folder, broker.repeat_s)
        self._client = self._made()
        self._added: queue.SimpleQueue[Path] = queue.SimpleQueue()
        self._confirmed: queue.SimpleQueue[str | int] = queue.SimpleQueue()  # key or message id
        self._under_way: dict[str, int] = {}  # by key: the message that the broker has not got
        self._screen: Screen | None = None
        self._stated: tuple[Any, ...] = ()  # what the retained state says
        self._fresh = threading.Event()  # a connection has begun
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._work, name="mqtt", daemon=True)

    @contextlib.contextmanager
    def running(self, tell: Tell) -> Iterator[None]:
        """While it lasts, the station is at its broker. ``tell`` hears what a person should."""
        self.tell = tell
        if not self.broker.acknowledged:
            tell(UNCONFIRMED)
        self._thread.start()
        try:
            yield
        finally:
            self._ending.set()
            self._thread.join(2.0 * LAST_WORDS_S)

    # ---- the station's thread

    def shown(self, screen: Screen) -> None:
        """See ``Witness``."""
        self._screen = screen

    def judged(self, done: Inspection) -> None:
        """See ``Witness``."""
        if done.folder is not None:
            self._added.put(done.folder)

    def status(self) -> dict[str, Any]:
        """See ``Witness``."""
        return {"mqtt": {"unacknowledged": len(self._outbox), "trouble": self.trouble}}

    # ---- the client's thread

    def _made(self) -> Client:
        from paho.mqtt.client import Client
        from paho.mqtt.enums import CallbackAPIVersion

        name = f"motorid-{self.topics.root}".replace("/", "-")
        client = Client(CallbackAPIVersion.VERSION2, client_id=name)
        client.connect_timeout = CONNECT_S
        client.reconnect_delay_set(1, 30)
        if self.broker.user:
            client.username_pw_set(self.broker.user, self.broker.password)
        if (context := self.broker.context()) is not None:
            client.tls_set_context(context)
        client.will_set(self.topics.state, self._offline(), qos=1, retain=True)
        client.on_connect = self._on_connect
        client.on_connect_fail = lambda client, data: self._troubled("no connection can be made")
        client.on_disconnect = lambda client, data, flags, code, properties: self._lost()
        client.on_message = self._on_message
        client.on_publish = lambda client, data, mid, code, properties: self._confirmed.put(mid)
        return client

    def _on_connect(
        self, client: Client, data: object, flags: object, code: Any, more: object
    ) -> None:
        if code.is_failure:
            self._troubled(str(code))
            return
        if self.broker.acknowledged:
            client.subscribe(self.topics.acknowledged, qos=1)
        self.trouble = ""
        self._fresh.set()

    def _on_message(self, client: Client, data: object, message: MQTTMessage) -> None:
        if key := messages.acknowledged_key(bytes(message.payload)):
            self._confirmed.put(key)

    def _lost(self) -> None:
        if not self.trouble and not self._ending.is_set():
            self._troubled("the connection is lost")

    def _troubled(self, why: str) -> None:
        """Said once, until it is over."""
        if self.trouble in ("", NOT_YET):
            self.tell(
                f"mqtt: {self.broker.host}:{self.broker.port}: {why}. Verdicts wait on disk for it."
            )
        self.trouble = why

    # ---- its own thread

    def _work(self) -> None:
        try:
            self._outbox.find()
        except OSError as error:
            self.tell(f"mqtt: earlier verdicts cannot be looked for ({error})")
        self._client.connect_async(self.broker.host, self.broker.port, KEEPALIVE_S)
        self._client.loop_start()
        while not self._ending.wait(TURN_S):
            self._turn()
        self._turn()
        self._leave()

    def _turn(self) -> None:
        """Notes first, then whatever is to be sent."""
        for folder in _taken(self._added):
            self._outbox.add(folder)
        for sign in _taken(self._confirmed):
            self._confirm(sign)
        if not self._client.is_connected():
            return
        now_s = time.monotonic()
        if self._fresh.is_set():
            self._fresh.clear()
            self._stated = ()
            self._outbox.all_due(now_s)
        for key, folder in self._outbox.due(now_s).items():
            if key not in self._under_way:  # else the client itself sends it again
                self._send(folder)
        while (waiting := self._outbox.next()) is not None:
            self._send(waiting)
        self._state()

    def _send(self, folder: Path) -> None:
        try:
            key, payload = messages.verdict(folder, self.station)
        except DataError as error:
            self._outbox.drop(folder)
            self.tell(f"mqtt: a verdict cannot be sent: {error}")
            return
        self._outbox.sent(key, folder, time.monotonic())
        self._under_way[key] = self._client.publish(self.topics.verdict, payload, qos=1).mid

    def _confirm(self, sign: str | int) -> None:
        """A consumer has the verdict of that key; or the broker the message of that number."""
        if isinstance(sign, int):
            sign = next((key for key, mid in self._under_way.items() if mid == sign), "")
            self._under_way.pop(sign, None)
            if self.broker.acknowledged:
                return
        try:
            self._outbox.acknowledged(sign)
        except OSError as error:
            self.tell(f"mqtt: an acknowledgement cannot be kept ({error.strerror or error})")

    def _state(self) -> None:
        if (screen := self._screen) is None:
            return
        now = (screen.word, screen.serial, len(self._outbox))
        if now == self._stated:
            return
        self._stated = now
        more = {"serial": now[1], "product": self.product, "unacknowledged": now[2]}
        said = messages.state(screen.word, self.station, more)
        self._client.publish(self.topics.state, said, qos=1, retain=True)

    def _offline(self) -> bytes:
        return messages.state(messages.OFFLINE, self.station)

    def _leave(self) -> None:
        """The last will, said by ourselves; the broker drops its own when we go in peace."""
        if self._client.is_connected():
            last = self._client.publish(self.topics.state, self._offline(), qos=1, retain=True)
            with contextlib.suppress(RuntimeError, ValueError):  # the connection is lost meanwhile
                last.wait_for_publish(LAST_WORDS_S)
        self._client.disconnect()
        self._client.loop_stop()


def _nobody(said: str) -> None:
    """Nobody hears it."""


def _taken(notes: queue.SimpleQueue[T]) -> Iterator[T]:
    with contextlib.suppress(queue.Empty):
        while True:
            yield notes.get_nowait()
