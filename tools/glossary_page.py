"""Writes docs/glossary.md: each quantity with its name in the rig file, code, JSON and report.

    python tools/glossary_page.py           # writes the page
    python tools/glossary_page.py --check   # ends with 1 where the page lags behind

The text around the table stands in the page itself. Names, units and words come from the code.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from motorid import rig_keys
from motorid.capture.model import QUANTITIES
from motorid.estimate.diagnosis.faults.scale_errors import KEYS
from motorid.estimate.results.estimate import PARAMETERS, UNITS
from motorid.quality.quantities import QUANTITIES as JUDGED
from motorid.report.words import NAMES

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "glossary.md"
TABLE = re.compile(r"(<!-- (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def parameters() -> str:
    """A row for each parameter, and for each one at 25 °C."""
    rows = [("symbol, code and JSON", "report and verdict", "unit in JSON", "key of `[nameplate]`")]
    for name in (*PARAMETERS, "R_25", "K_25"):
        key = KEYS.get(name, "")
        if key and key not in rig_keys.SECTIONS["nameplate"]:
            raise ValueError(f"the rig file has no key {key}")
        unit = UNITS.get(name) or JUDGED[name].unit
        rows.append((f"`{name}`", NAMES[name], unit, f"`{key}`" if key else "—"))
    return _table(rows)


def channels() -> str:
    """A row for each quantity that a capture may hold."""
    rows = [("channel, in rig, capture, code and JSON", "unit")]
    return _table([*rows, *((f"`{name}`", unit) for name, unit in QUANTITIES.items())])


def _table(rows: list[tuple[str, ...]]) -> str:
    head, *body = ("| " + " | ".join(row) + " |" for row in rows)
    return "\n".join([head, "|" + "---|" * len(rows[0]), *body, ""])


def page(text: str) -> str:
    """The page with its tables as the code has them now."""
    made = {"parameters": parameters, "channels": channels}
    return TABLE.sub(lambda found: found[1] + made[found[2]]() + found[3], text)


def main(arguments: list[str]) -> int:
    """Exit code 1 where ``--check`` finds the page behind the code."""
    stands = PAGE.read_text(encoding="utf-8")
    written = page(stands)
    if "--check" not in arguments:
        PAGE.write_text(written, encoding="utf-8", newline="\n")
        return 0
    if stands == written:
        return 0
    print(f"{PAGE.name} is behind the code: make docs", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
