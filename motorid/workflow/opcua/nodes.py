"""The address space of a station: its variables, measurements, method and event type."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

from asyncua import Server, ua

from motorid import json_text
from motorid.quality.records import to_dict
from motorid.workflow.opcua.units import eu_information

if TYPE_CHECKING:
    from asyncua import Node

    from motorid.quality.product import Product
    from motorid.quality.verdict import Measurement, Verdict
    from motorid.report.screen import Screen
    from motorid.workflow.check import Inspection

SPACE = "urn:motorid:station"
SEVERITY = {"PASS": 100, "FAIL": 500, "INVALID": 800}  # of 1 to 1000
PARTS = {"Uncertainty": math.nan, "Low": math.nan, "High": math.nan, "Outcome": "", "Reason": ""}
TEXTS = ("State", "Message", "Serial", "Outcome", "Verdict", "Folder")
FIELDS = ("Serial", "Outcome", "Key", "Reasons")
Inspect = Callable[[str, str], Awaitable[tuple[bool, str]]]


class StationNodes:
    """``inspect`` carries out the method's call: serial number and reason; accepted, and why not.

    ``fill`` makes the nodes; the others keep them as the station is.
    """

    def __init__(self, server: Server, station: str, product: Product, inspect: Inspect) -> None:
        self.server, self.product, self.inspect = server, product, inspect
        self.station = station
        self._texts: dict[str, Node] = {}
        self._measured: dict[str, dict[str, Node]] = {}

    async def fill(self) -> None:
        """All nodes, below Objects/Station."""
        self.space = await self.server.register_namespace(SPACE)
        root = await self.server.nodes.objects.add_object(
            self._id("Station"), self._name("Station")
        )
        for name in TEXTS:
            self._texts[name] = await self._text(root, name, "")
        await self._text(root, "Name", self.station)
        await self._text(root, "Product", self.product.name)
        await self._text(root, "ProductSha256", self.product.digest)
        await self._method(root)
        folder = await root.add_folder(self._id("Measurements"), self._name("Measurements"))
        for name, limit in self.product.limits.items():
            self._measured[name] = await self._measurement(folder, name, limit.unit)
        kind = await self.server.create_custom_event_type(
            self.space, "VerdictEventType", ua.ObjectIds.BaseEventType,
            [(name, ua.VariantType.String) for name in FIELDS],
        )  # fmt: skip
        self._events = await self.server.get_event_generator(kind, root)

    def _id(self, path: str) -> ua.NodeId:
        return ua.NodeId(path, self.space)

    def _name(self, name: str) -> ua.QualifiedName:
        return ua.QualifiedName(name, self.space)

    async def _text(self, parent: Node, name: str, value: str) -> Node:
        where = self._id(f"Station.{name}")
        return await parent.add_variable(where, self._name(name), value, ua.VariantType.String)

    async def _method(self, root: Node) -> None:
        taken = [
            ("Serial", "of the motor in the rig"),
            ("Reason", "why it is tested again; or empty"),
        ]
        given = [("Accepted", ua.ObjectIds.Boolean), ("Message", ua.ObjectIds.String)]
        await root.add_method(
            self._id("Station.Inspect"), self._name("Inspect"), self._called,
            [_argument(name, ua.ObjectIds.String, said) for name, said in taken],
            [_argument(name, kind, "") for name, kind in given],
        )  # fmt: skip

    async def _called(self, parent: ua.NodeId, *said: ua.Variant) -> Any:
        texts = [one.Value for one in said]
        if len(texts) != 2 or not all(isinstance(one, str | None) for one in texts):
            return ua.StatusCode(ua.StatusCodes.BadInvalidArgument)
        accepted, message = await self.inspect(texts[0] or "", texts[1] or "")
        return [
            ua.Variant(accepted, ua.VariantType.Boolean),
            ua.Variant(message, ua.VariantType.String),
        ]

    async def _measurement(self, folder: Node, name: str, unit: str) -> dict[str, Node]:
        where, kind = f"Station.{name}", ua.VariantType.Double
        one = await folder.add_variable(self._id(where), self._name(name), math.nan, kind)
        await one.delete_reference(
            ua.ObjectIds.BaseDataVariableType, ua.ObjectIds.HasTypeDefinition
        )
        await one.add_reference(ua.ObjectIds.AnalogUnitType, ua.ObjectIds.HasTypeDefinition)
        await one.add_property(
            self._id(f"{where}.EngineeringUnits"), ua.QualifiedName("EngineeringUnits", 0),
            eu_information(unit),
        )  # fmt: skip
        found = {"Value": one}
        for part, empty in PARTS.items():
            made = await one.add_property(self._id(f"{where}.{part}"), self._name(part), empty)
            found[part] = made
        return found

    async def shown(self, screen: Screen) -> None:
        """What the operator sees."""
        await self._texts["State"].write_value(screen.word)
        await self._texts["Message"].write_value("\n".join((*screen.lines, screen.next_step)))
        await self._texts["Serial"].write_value(screen.serial)

    async def judged(self, done: Inspection) -> None:
        """A verdict: each measurement, the whole as JSON, and then the event."""
        verdict = done.verdict
        for measurement in verdict.measurements:
            if measurement.quantity in self._measured:
                await self._write(self._measured[measurement.quantity], measurement)
        for name in self._measured.keys() - {one.quantity for one in verdict.measurements}:
            await self._clear(self._measured[name])
        stored = _stored(done)
        await self._texts["Outcome"].write_value(str(verdict.outcome))
        await self._texts["Verdict"].write_value(json_text.dumps(stored))
        await self._texts["Folder"].write_value(done.folder.name if done.folder else "")
        await self._tell(verdict, str(stored.get("content_sha256", "")))

    async def _write(self, nodes: dict[str, Node], measured: Measurement) -> None:
        reading, limit = measured.reading, measured.limit
        await _number(nodes["Value"], reading.value)
        for part, value in (
            ("Uncertainty", reading.uncertainty),
            ("Low", limit.low),
            ("High", limit.high),
        ):
            await nodes[part].write_value(math.nan if value is None else float(value))
        await nodes["Outcome"].write_value(str(measured.outcome))
        await nodes["Reason"].write_value(measured.reason)

    async def _clear(self, nodes: dict[str, Node]) -> None:
        await _number(nodes["Value"], None)
        for part, empty in PARTS.items():
            await nodes[part].write_value(empty)

    async def _tell(self, verdict: Verdict, key: str) -> None:
        event = self._events.event
        event.Serial, event.Outcome, event.Key = verdict.serial, str(verdict.outcome), key
        event.Reasons = "\n".join(verdict.reasons)
        event.Severity = SEVERITY[str(verdict.outcome)]
        said = f"{verdict.serial} {verdict.outcome}"
        await self._events.trigger(message="; ".join((said, *verdict.reasons[:1])))


def _stored(done: Inspection) -> dict[str, Any]:
    """The verdict as it is on disk; anew where it is not."""
    from motorid import json_seal
    from motorid.errors import DataError
    from motorid.workflow.check import VERDICT

    if done.folder is not None:
        try:
            return json_seal.read(done.folder / VERDICT, "a verdict")
        except DataError:
            pass  # it was there a moment ago: what was judged is said all the same
    return to_dict(done.verdict)


async def _number(node: Node, value: float | None) -> None:
    """A value that is not known has a bad status."""
    good = value is not None and math.isfinite(value)
    code = ua.StatusCodes.Good if good else ua.StatusCodes.BadNoData
    variant = ua.Variant(float(value) if value is not None else math.nan, ua.VariantType.Double)
    await node.write_value(ua.DataValue(variant, StatusCode=ua.StatusCode(code)))


def _argument(name: str, kind: int, said: str) -> ua.Argument:
    return ua.Argument(
        Name=name, DataType=ua.NodeId(kind), ValueRank=-1, Description=ua.LocalizedText(said)
    )
