"""A front-end file made for one bench: the inputs of its driver, and its measured reference."""

from __future__ import annotations

import re

from motorid.rig_front_end import FrontEnd, load_front_end, parse

SUPPLY_LIKE = 0.01  # standard, relative: a reference that is no better known than a supply
METER = 0.003  # standard, relative, of a usual meter at a few volts
FARTHEST = 0.12  # of the nominal reference: beyond it another pin was measured


def is_a_supply(front_end: FrontEnd) -> bool:
    """Whether its reference is a supply, which a meter knows better."""
    return float(parsed(front_end, "reference_uncertainty")) > SUPPLY_LIKE


def made(sensor: str, bridge: str, reference_v: float | None, where: str) -> FrontEnd:
    """That of a preset or file with this driver, and the reference as it was measured."""
    text = _with(load_front_end(sensor).text, "bridge", f'"{bridge}"')
    return parse(text if reference_v is None else _measured(text, reference_v), where)


def parsed(front_end: FrontEnd, key: str) -> str:
    """What its file says of a key that stands once in it."""
    return _found(front_end.text, key)


def _found(text: str, key: str) -> str:
    found = re.search(rf"(?m)^{key}\s*=\s*([^#\n]*)", text)
    return found.group(1).strip() if found else ""


def _with(text: str, key: str, value: str) -> str:
    """The text with that value, in the line of the key or after the sensor's."""
    line = f"{key} = {value}"
    changed, count = re.subn(rf"(?m)^{key}\s*=[^#\n]*", f"{line:<33}", text, count=1)
    changed = re.sub(r"(?m)[ \t]+$", "", changed)
    return changed if count else re.sub(r"(?m)^(sensor\s*=.*)$", rf"\1\n{line}", text, count=1)


def _measured(text: str, volts: float) -> str:
    """Its zero and what lifts the dividers follow, and a ratiometric sensor's gain does."""
    share = volts / float(_found(text, "reference_v"))
    follows = ["zero_v", "lift_v"]
    if _found(text, "ratiometric") == "true":
        follows.append("volts_per_ampere")
    for key in follows:
        text = _with(text, key, f"{float(_found(text, key)) * share:.6g}")
    text = _with(text, "reference_v", f"{volts:g}")
    return _with(text, "reference_uncertainty", f"{METER:g}")
