"""docs/simulator.md names every option, fault and motor, with its range."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from motorid.sim.faults import KINDS
from motorid.sim.motor import motors
from motorid.sim.options import Options


def default_text(value: Any) -> str:
    if isinstance(value, bool):
        return str(int(value))
    if value is None or value == "":
        return ""
    return f"{value:g}" if isinstance(value, float) else str(value)


def option_rows() -> list[str]:
    return [
        f"| `{f.name}` | {default_text(f.default)} | {f.metadata['doc']} |" for f in fields(Options)
    ]


def fault_rows() -> list[str]:
    return [f"| `{name}` | {default_text(k.default)} | {k.doc} |" for name, k in KINDS.items()]


def motor_rows() -> list[str]:
    return [f"| `{name}` | {m.title} | {m.source} |" for name, m in motors().items()]


@pytest.mark.parametrize("row", option_rows() + fault_rows() + motor_rows())
def test_the_page_has_the_row(repo_root: Path, row: str) -> None:
    assert row in (repo_root / "docs" / "simulator.md").read_text(encoding="utf-8").splitlines()
