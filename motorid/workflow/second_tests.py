"""What was judged of a motor before, in a station's folder and in its history, and what follows.

INVALID is no judgement: it calls for a second test, and releases no rejected motor.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid import json_seal
from motorid.errors import DataError
from motorid.workflow import shift_folder
from motorid.workflow.check import VERDICT

if TYPE_CHECKING:
    from motorid.quality.product import Product

KEYS = ("serial", "outcome", "marginal", "reasons", "time")
Judged = Mapping[str, Any]  # an outcome and its time, at least


def newest_first(folder: Path, serial: str) -> Iterator[dict[str, Any]]:
    """The verdicts on a motor in a folder. Raises DataError for a damaged one."""
    paths = (one / VERDICT for one in shift_folder.newest_first(folder, serial))
    for path in (one for one in paths if one.exists()):
        stored = json_seal.read(path, "a verdict")
        if not set(KEYS) <= set(stored) or not _is_instant(stored["time"]):
            raise DataError(f"{path} is no verdict of this motorid: it is damaged")
        yield {key: stored[key] for key in KEYS} | {"folder": str(path.parent)}


def _is_instant(said: Any) -> bool:
    try:
        datetime.fromisoformat(str(said))
    except ValueError:
        return False
    return True


def together(here: Iterable[Judged], elsewhere: Iterable[Judged]) -> list[Judged]:
    """Both, the newest first, and each verdict once: the history holds those of the folder too."""
    by_time = {datetime.fromisoformat(str(one["time"])): one for one in (*elsewhere, *here)}
    return [by_time[time] for time in sorted(by_time, reverse=True)]


def refuse_repeat(product: Product, serial: str, reason: str, before: Iterable[Judged]) -> None:
    """Raises DataError for a second test that the product does not allow as it is ordered.

    ``before``: what was judged of the motor, the newest first.
    """
    rule = product.serial
    if rule is None or rule.repeat == "count" or serial in product.self_test.golden:
        return
    last = next((one for one in before if one["outcome"] != "INVALID"), None)
    if last is None:
        return
    where = f" at {last['station']}" if last.get("station") else ""
    said = f"{serial} was judged before ({last['outcome']}, {last['time']}{where})"
    if rule.repeat == "refuse":
        raise DataError(f"{said}, and the product allows no second test: is it the right label?")
    if not reason and (rule.repeat == "reason" or last["outcome"] == "FAIL"):
        raise DataError(
            f"{said}: a second test needs a reason. Type it behind the number and a space, as "
            f'in `{serial} new connector`; an order has "reason"'
        )
