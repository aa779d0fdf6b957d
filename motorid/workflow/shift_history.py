"""A shift's verdicts on their way into the history of results, none lost and none twice.

A verdict is on disk in its own folder before it comes here, so a history that cannot be reached
stops no line: the folder keeps no mark, and the next shift makes up for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid import json_seal, json_text
from motorid.errors import DataError, MotoridError
from motorid.workflow.check import CAPTURE, VERDICT
from motorid.workflow.shift_folder import serial_of, unsettled
from motorid.workflow.trail import hand_over
from motorid.workflow.uploads import place_of

if TYPE_CHECKING:
    from motorid.quality.history import History
    from motorid.quality.history.chain import Head
    from motorid.quality.product import Product
    from motorid.storage.place import Url

PATIENCE_S = 20.0  # for the database to answer; what it does not take is added later
MOST_TOLD = 50  # results, and entries of the trail
SAID_OF_ORDERS = ("station", "action", "outcome", "who", "reason")
MARK = "in-history"  # in an inspection's folder: the history has it


@dataclass(frozen=True)
class ShiftHistory:
    """``where``: a file, or a database's URL; ``rest``: station, operator (see ResultRecord).

    ``store``: the folder of an object store that the inspections go to.
    """

    where: str
    product: Product
    rest: Mapping[str, Any]
    store: Url | None = None

    def take(self, folder: Path) -> str:
        """Adds the inspection in ``folder``. What went wrong, in a sentence, or nothing."""
        from motorid.quality.history import open_history

        try:
            with open_history(self.where, patience_s=PATIENCE_S) as history:
                if not (folder / MARK).exists():
                    self._add(history, folder)
                hand_over(folder.parent, history.note)
        except (MotoridError, OSError) as error:
            return f"{serial_of(folder)} is not in the history yet ({error})"
        return ""

    def catch_up(self, folder: Path) -> str:
        """Adds what an earlier shift could not. What was done and what was not, in a sentence.

        Names that are older than the history keeps them are forgotten.
        """
        from motorid.quality.history import open_history

        asked = unsettled(folder, f"{MARK}-{self.product.digest[:16]}", self._is_settled)
        missing = [one for one in asked if _product_of(one) == self.product.digest]
        left = 0
        with open_history(self.where, patience_s=PATIENCE_S) as history:
            hand_over(folder, history.note)
            history.forget_names()
            for one in missing:
                try:
                    self._add(history, one)
                except (DataError, OSError):
                    left += 1
        if not missing:
            return ""
        said = f"{len(missing) - left} earlier verdicts were added to the history. "
        return said + (f"{left} could not be: see motorid history add. " if left else "")

    def judged(self, serial: str) -> list[Mapping[str, Any]]:
        """Outcome, time and station of each verdict on a motor of this product."""
        from motorid.quality.history import Query, open_history

        asked = Query(serial=serial, product=self.product.name, kind="check")
        with open_history(self.where, patience_s=PATIENCE_S) as history:
            return [
                {"outcome": row.outcome, "time": row.at.isoformat(), "station": row.station}
                for row in history.results(asked)
                if row.serial == serial  # a number may hold what is a wildcard there
            ]

    def story(self, serial: str) -> dict[str, Any]:
        """Results and trail of a motor, the latest of each, oldest first."""
        from motorid.quality.history import Query, open_history

        with open_history(self.where, create=False, patience_s=PATIENCE_S) as history:
            rows = history.results(Query(serial=serial), last=MOST_TOLD)
            trail = history.trail(serial=serial, last=MOST_TOLD)
        return {
            "results": [
                {
                    "time": row.at.isoformat(), "serial": row.serial, "outcome": row.outcome,
                    "kind": row.kind, "product": row.product, "station": row.station,
                }
                for row in rows
            ],
            "trail": [
                {
                    "time": one["at"].isoformat(), "serial": one["subject"],
                    **{name: one[name] for name in SAID_OF_ORDERS},
                }
                for one in trail
            ],
        }  # fmt: skip

    def _add(self, history: History, folder: Path) -> None:
        """The verdict as it was shown, at its time; then the mark, with the head of the chain."""
        from motorid.capture import store
        from motorid.quality.history.records import from_stored

        stored = json_seal.read(folder / VERDICT, "a verdict")
        paths = [folder / CAPTURE] if (folder / CAPTURE).exists() else []
        captures = [store.load(path) for path in paths]
        if self.store is not None:
            there = place_of(folder, self.store)
            captures = [replace(one, path=str(there / CAPTURE)) for one in captures]
        try:
            record = from_stored(stored, captures, limits=self.product.text, **self.rest)
        except (KeyError, TypeError, ValueError) as error:
            raise DataError(f"{folder / VERDICT} lacks a part of a verdict ({error!r})") from None
        history.add(record)
        head = json_text.dumps(asdict(history.head(record.station)))
        (folder / MARK).write_text(f"{self.where}\n{head}\n", encoding="utf-8")

    def _is_settled(self, one: Path) -> bool:
        """In the history, or of no use to it: judged by another product."""
        return (one / MARK).exists() or _product_of(one) not in (None, self.product.digest)


def _product_of(inspection: Path) -> object:
    """The digest of the product that judged it; None where no verdict can be read."""
    try:
        versions = json_seal.read(inspection / VERDICT, "a verdict").get("versions")
    except DataError:
        return None
    return versions.get("product", "") if isinstance(versions, dict) else ""


def anchors(folder: Path) -> Iterator[Head]:
    """The heads of the chain that the inspections under ``folder`` keep. Raises DataError."""
    from motorid.quality.history.chain import Head

    for mark in sorted(folder.rglob(MARK)):
        lines = mark.read_text(encoding="utf-8").splitlines()
        if len(lines) < 2:
            continue  # from before there were seals
        try:
            said = json_text.loads(lines[1])
            yield Head(str(said["station"]), int(said["position"]), str(said["chain"]))
        except (json_text.JsonError, KeyError, TypeError, ValueError):
            raise DataError(f"{mark} is damaged: it holds no head of a chain") from None
