"""Units as OPC UA names them: the codes of UNECE Recommendation 20, as far as there is one."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from asyncua import ua

SPACE = "http://www.opcfoundation.org/UA/units/un/cefact"
NO_CODE = -1
CODES = {
    "1": "C62", "A": "AMP", "H": "81", "N·m": "NU", "kg·m²": "B32", "ohm": "OHM", "rad": "C81",
    "rad/s": "2A", "s": "SEC", "°C": "CEL",
}  # fmt: skip


def unit_id(unit: str) -> int:
    """The characters of its code, as a number; NO_CODE where there is none."""
    code = CODES.get(unit)
    return NO_CODE if code is None else int.from_bytes(code.encode("ascii"), "big")


def eu_information(unit: str) -> ua.EUInformation:
    """What a client shows beside a value; the unit's own sign is there in any case."""
    from asyncua import ua

    text = ua.LocalizedText(unit)
    return ua.EUInformation(SPACE, unit_id(unit), text, text)
