"""asyncua's own client, in a process of its own, as a PLC's supervisor would ask.

    python opcua_client.py URL < CLIENTS

Each line of CLIENTS is one client, as a JSON list of words: SERIAL [--token T]
[--security CERT KEY SERVER_CERT]. It subscribes, orders an inspection, waits for its event, and
prints what it saw as a line of JSON. One follows the other.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import logging
import sys
from pathlib import Path
from typing import Any

from asyncua import Client, ua
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256

PATIENCE_S = 20.0


class Seen:
    """What subscriptions brought."""

    def __init__(self) -> None:
        self.states: list[str] = []
        self.events: asyncio.Queue[Any] = asyncio.Queue()

    def datachange_notification(self, node: Any, value: Any, data: Any) -> None:
        self.states.append(value)

    def event_notification(self, event: Any) -> None:
        self.events.put_nowait(event)


async def asked(url: str, options: argparse.Namespace) -> dict[str, Any]:
    client = Client(url, timeout=60)
    if options.security:
        pem, key, server = map(Path, options.security)
        client.application_uri = "urn:motorid:client"
        await client.set_security(SecurityPolicyBasic256Sha256, pem, key, server_certificate=server)
    if options.token:
        client.set_user("somebody")
        client.set_password(options.token)
    async with client:
        space = await client.get_namespace_index("urn:motorid:station")
        root = await client.nodes.objects.get_child([f"{space}:Station"])

        async def read(*path: str) -> Any:
            return await (await root.get_child([f"{space}:{one}" for one in path])).read_value()

        seen = Seen()
        subscription = await client.create_subscription(50, seen)
        await subscription.subscribe_data_change(await root.get_child([f"{space}:State"]))
        kind = await client.nodes.base_event_type.get_child([f"{space}:VerdictEventType"])
        await subscription.subscribe_events(root, kind)
        method = f"{space}:Inspect"
        accepted, message = await root.call_method(method, options.serial, "")
        found: dict[str, Any] = {"accepted": accepted, "message": message}
        if not accepted:
            return found
        refused = await root.call_method(method, "no serial number", "")
        event = await asyncio.wait_for(seen.events.get(), PATIENCE_S)
        r_25 = await root.get_child([f"{space}:Measurements", f"{space}:R_25"])
        unit = await (await r_25.get_child(["0:EngineeringUnits"])).read_value()
        try:
            await r_25.write_value(1.0)
            written = True
        except ua.UaError:
            written = False
        return {
            **found,
            "refused": refused,
            "event": [event.Serial, event.Outcome, event.Key, event.Severity],
            "outcome": await read("Outcome"),
            "verdict": json.loads(await read("Verdict")),
            "R_25": await r_25.read_value(),
            "u": await read("Measurements", "R_25", "Uncertainty"),
            "low": await read("Measurements", "R_25", "Low"),
            "unit": [unit.DisplayName.Text, unit.UnitId],
            "kind": (await r_25.read_type_definition()).Identifier,
            "states": seen.states,
            "written": written,
        }


def main() -> None:
    logging.disable()
    parser = argparse.ArgumentParser()
    parser.add_argument("serial")
    parser.add_argument("--token")
    parser.add_argument("--security", nargs=3)
    for line in sys.stdin:
        try:
            found = asyncio.run(asked(sys.argv[1], parser.parse_args(json.loads(line))))
        except (ua.UaError, ConnectionError, TimeoutError) as error:
            found = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(found))


if __name__ == "__main__":
    main()
