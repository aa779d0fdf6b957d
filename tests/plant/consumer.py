"""A consumer of a plant: takes verdicts, and says which it has."""

from __future__ import annotations

import contextlib
import functools
import json
import time
from collections.abc import Callable, Iterator
from typing import Any

import jsonschema
import paho.mqtt.client as mqtt
from paho.mqtt.enums import CallbackAPIVersion
from referencing import Registry, Resource

from motorid import schemas

REGISTRY: Registry[Any] = Registry().with_resources(
    [(one["$id"], Resource.from_contents(one)) for one in map(schemas.schema, schemas.names())]
)
PATIENCE_S = 120.0


@functools.cache
def validator(name: str) -> jsonschema.Draft202012Validator:
    """Of a published schema; made once, for it is asked of every message."""
    return jsonschema.Draft202012Validator(schemas.schema(name), registry=REGISTRY)


def valid(document: Any, name: str) -> None:
    """Raises ValidationError where it is not by the published schema."""
    validator(name).validate(document)


class Consumer:
    """``verdicts`` by key, how often each came, and the latest state. All are validated."""

    def __init__(self, acknowledges: bool = True) -> None:
        self.acknowledges = acknowledges
        self.verdicts: dict[str, dict[str, Any]] = {}
        self.came: list[str] = []  # keys
        self.states: list[dict[str, Any]] = []
        self.wrong: list[Exception] = []
        self.ready = False
        self.client = mqtt.Client(CallbackAPIVersion.VERSION2, client_id="mes", clean_session=False)
        self.client.reconnect_delay_set(1, 1)
        self.client.on_connect = self._on_connect
        self.client.on_subscribe = lambda *_: setattr(self, "ready", True)
        self.client.on_message = self._on_message

    def _on_connect(self, client: Any, *_: Any) -> None:
        client.subscribe([("motorid/+/verdict", 1), ("motorid/+/state", 1)])

    def _on_message(self, client: Any, _: Any, message: Any) -> None:
        said = json.loads(message.payload)
        try:
            if message.topic.endswith("/state"):
                valid(said, "mqtt-state")
                self.states.append(said)
                return
            valid(said, "mqtt-verdict")
        except jsonschema.ValidationError as error:
            self.wrong.append(error)
            return
        self.came.append(said["key"])
        self.verdicts[said["key"]] = said["verdict"]
        if self.acknowledges:
            self.acknowledge(message.topic, said["key"])

    def acknowledge(self, topic: str, key: str) -> None:
        self.client.publish(f"{topic}/acknowledged", json.dumps({"key": key}), qos=1)


@contextlib.contextmanager
def consuming(port: int, **options: Any) -> Iterator[Consumer]:
    """A consumer at that broker."""
    one = Consumer(**options)
    one.client.connect("127.0.0.1", port)
    one.client.loop_start()
    try:
        wait_for(lambda: one.ready)
        yield one
        assert one.wrong == []
    finally:
        one.client.disconnect()
        one.client.loop_stop()


def wait_for(done: Callable[[], object], patience_s: float = PATIENCE_S) -> None:
    """Until then."""
    until = time.monotonic() + patience_s
    while not done():
        assert time.monotonic() < until, "it did not happen in time"
        time.sleep(0.02)
