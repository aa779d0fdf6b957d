"""JSON and TOML: the constants with their uncertainty, for programs of one's own."""

from __future__ import annotations

from typing import Any

from motorid import json_text
from motorid.estimate.results.estimate import PARAMETERS, UNITS
from motorid.export.motor import Motor, described

SCHEMA = "motorid-motor-1"


def as_data(motor: Motor) -> dict[str, Any]:
    """Plain data; what is unknown is None."""
    return {
        "schema": SCHEMA,
        "serial": motor.serial,
        "source": motor.source,
        "source_content_sha256": motor.digest,
        "motorid": motor.motorid,
        "gear_ratio": motor.gear_ratio,
        "parameters": {
            name: {
                "value": one.value,
                "standard_uncertainty": one.u,
                "interval_95": one.interval_95 and list(one.interval_95),
                "unit": UNITS[name],
                "status": one.status,
                "note": one.note,
            }
            for name, one in motor.values.items()
        },
        "covariance": {"names": list(PARAMETERS), "matrix": motor.covariance()},
        "beside": list(motor.beside),
    }


def write_json(motor: Motor) -> str:
    """JSON text."""
    return json_text.dumps(as_data(motor), indent=2) + "\n"


def write_toml(motor: Motor) -> str:
    """TOML text. It has no null: what is unknown is left out, and the comment says so."""
    data = as_data(motor)
    lines = [f"# {line}" for line in described(motor)]
    lines += [f"{key} = {_toml(data[key])}" for key in ("schema", "serial", "source", "gear_ratio")]
    lines += [f"{key} = {_toml(data[key])}" for key in ("source_content_sha256", "motorid")]
    for name, one in data["parameters"].items():
        lines += ["", f"[parameters.{name}]"]
        lines += [f"{key} = {_toml(said)}" for key, said in one.items() if said is not None]
    lines += ["", "[covariance]"]
    lines += [f"{key} = {_toml(said)}" for key, said in data["covariance"].items()]
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    """A TOML value: texts, finite numbers and lists are written as JSON writes them."""
    return json_text.dumps(value)
