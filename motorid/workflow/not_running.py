"""A motor that did not run: its own defect where the rig was shown to be sound, else INVALID.

The first drive names what it saw (``Sign``). A sound rig is one on which a motor has passed within
the product's interval; the verdicts on disk say so, so that a restart forgets nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid import json_seal
from motorid.acquire.signs import Sign, SignError
from motorid.errors import DataError, MotoridError
from motorid.quality.judge import RUNS, not_measured, not_running
from motorid.workflow.shift_folder import newest_first

if TYPE_CHECKING:
    from motorid.quality.product import Product
    from motorid.quality.verdict import Verdict

RECORD = "verdict.json"
DEFECTS = {
    Sign.SHORTED: "shorted winding",
    Sign.OPEN: "open winding",
    Sign.SEIZED: "seized rotor, or cogging that holds it",
    Sign.SWINGS: "strong cogging, or a jammed rotor",
    Sign.BACKWARDS: "reversed leads",
    Sign.TOO_FAST: "another type of motor",
    Sign.OVER_CURRENT: "shorted winding, or another type of motor",
    Sign.OVER_SPEED: "another type of motor",
}
CONTACT = "motor or contact: put the motor in anew, and scan it again"


@dataclass(frozen=True)
class _Past:
    """One earlier verdict of this product."""

    serial: str
    outcome: str
    reason: str  # that it did not run; "": it did

    @property
    def dead(self) -> bool:
        return bool(self.reason)


def verdict_of(error: MotoridError, product: Product, serial: str, folder: Path) -> Verdict:
    """The verdict on the motor whose run ended in ``error``; earlier ones are under ``folder``."""
    sign = error.sign if isinstance(error, SignError) else None
    if sign is None:
        return not_measured(product, serial, str(error))
    past = islice(_past(newest_first(folder), product), product.self_test.inspections)
    unsound = _unsound(past, product)
    if not unsound and sign is Sign.OPEN and not _seen_open(folder, product, serial):
        unsound = CONTACT
    return not_running(product, serial, DEFECTS[sign], str(error), unsound)


def _unsound(past: Iterable[_Past], product: Product) -> str:
    """Why the rig cannot be taken for sound, and what to do; "": it can."""
    test = product.self_test
    which = f"the golden motor ({', '.join(test.golden)})" if test.golden else "a good motor"
    dead: set[str] = set()
    for one in past:
        counts = one.outcome == "PASS" and (not test.golden or one.serial in test.golden)
        if counts:
            return ""
        if one.dead and one.outcome == "FAIL":
            dead.add(one.serial)
        if len(dead) >= test.dead_in_a_row:
            return (
                f"{len(dead)} motors in a row did not run, so that the rig is in doubt: "
                f"measure {which}"
            )
    return (
        f"no motor has passed on this rig within {test.inspections} inspections: measure {which} "
        "first, and this one again"
    )


def _seen_open(folder: Path, product: Product, serial: str) -> bool:
    """The last verdict on this motor said the same: this is its second contact."""
    last = next(_past(newest_first(folder, serial), product), None)
    return last is not None and DEFECTS[Sign.OPEN] in last.reason


def _past(inspections: Iterable[Path], product: Product) -> Iterator[_Past]:
    """The verdicts among these by this very product."""
    for one in inspections:
        try:
            stored = json_seal.read(one / RECORD, "a verdict")
        except DataError:
            continue  # not judged, or damaged: it proves nothing
        versions = stored.get("versions")
        if isinstance(versions, dict) and versions.get("product") == product.digest:
            yield _Past(str(stored.get("serial")), str(stored.get("outcome")), _reason(stored))


def _reason(stored: dict[str, Any]) -> str:
    rows = stored.get("measurements")
    for row in rows if isinstance(rows, list) else ():
        if isinstance(row, dict) and row.get("quantity") == RUNS:
            return str(row.get("reason"))
    return ""
