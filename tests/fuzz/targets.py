"""What is fuzzed. A module of checks has ``check(data)``, which raises, and ``seeds()``."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Parser:
    """A parser in Python: its checks, the modules whose coverage leads, its longest input."""

    checks: str
    instrumented: tuple[str, ...]
    longest: int


PARSERS = {
    "wire": Parser("tests.fuzz.wire_checks", ("motorid.wire",), 300),
    "rig": Parser(
        "tests.fuzz.rig_checks",
        (
            "motorid.rig_file",
            "motorid.rig_keys",
            "motorid.rig_model",
            "motorid.rig_program",
            "motorid.program",
            "motorid.toml_file",
            "tomllib",
        ),
        2000,
    ),
    "csv": Parser("tests.fuzz.csv_checks", ("motorid.capture",), 1000),
    "look": Parser(
        "tests.fuzz.look_checks", ("motorid.capture", "motorid.workflow.proposal"), 1000
    ),
    "journal": Parser("tests.fuzz.journal_checks", ("motorid.acquire", "motorid.wire"), 1000),
}
FILES = ("hdf5", "mat")
FIT = "fit"
BOARDS = ("board",)
