"""Estimates as files have them, made by hand."""

from __future__ import annotations

from typing import Any

from motorid.estimate.results.estimate import PARAMETERS, UNITS

TRUE = {"R": 2.5, "L": 2e-4, "K": 0.0077, "B": 3e-7, "J": 4e-7, "T0": 4e-4}
HOSTILE = "M1 --> */ ]]> \"'<&> \n.end\n* \x1b[31m é"


def document(**changed: dict[str, Any]) -> dict[str, Any]:
    """An estimate as the schema has it, with members of some parameters changed."""
    parameters = {
        name: {
            "value": value,
            "uncertainty": {"statistical": 0.0, "instrument": 0.0, "total": 0.01 * value},
            "interval_95": [0.98 * value, 1.02 * value],
            "unit": UNITS[name],
            "status": "estimated",
        }
        | changed.get(name, {})
        for name, value in TRUE.items()
    }
    matrix = [[1.0 if a == b else 0.25 for a in PARAMETERS] for b in PARAMETERS]
    return {
        "schema": "motorid-estimate-2",
        "parameters": parameters,
        "correlation": {"names": list(PARAMETERS), "matrix": matrix},
        "inputs": [{"serial": HOSTILE}],
        "alternative": {"name": HOSTILE},
    }
