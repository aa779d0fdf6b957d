"""motorid's own commands in this process, and what they said."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from typing import Any

from motorid.cli.main import run

ACCUSING = ("warning", "error")
ROUTINE = ("budget", "few_runs", "identifiability", "run_to_add")  # they name no mistake


@dataclass(frozen=True)
class Said:
    """One command: its exit code, its answer and what it said beside it."""

    code: int
    out: str
    err: str


@dataclass(frozen=True)
class Answer:
    """What a user is left with: exit code, estimate (None: refused) and remarks on the way."""

    code: int
    estimate: Mapping[str, Any] | None
    remarks: str

    @property
    def parameters(self) -> Mapping[str, Mapping[str, Any]]:
        """Of the estimate: the six, then R and K at 25 °C."""
        found = self.estimate or {}
        return {**found.get("parameters", {}), **found.get("at_25", {})}

    @property
    def accusations(self) -> tuple[str, ...]:
        """What a reader must see: warnings, errors, named suspects and a refusal, "code: words"."""
        if self.estimate is None:
            return (f"refused: {self.remarks}",)
        said = self.estimate["diagnostics"]
        found = [f"{d['code']}: {d['message']}" for d in said if d["severity"] in ACCUSING]
        found += [
            f"{s['code']}: {s['where']}: {s['evidence']}"
            for s in self.estimate["suspects"]
            if s["strength"] == "named"
        ]
        return tuple(found)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Everything that it said, but the faults that it merely does not exclude."""
        diagnostics = (self.estimate or {}).get("diagnostics", ())
        said = [f"{d['code']}: {d['message']}" for d in diagnostics if d["code"] not in ROUTINE]
        six = (self.estimate or {}).get("parameters", {})
        notes = [p.get("note", "") for p in six.values()]
        unstated = [f"not stated: {one}" for one in (self.estimate or {}).get("not_stated", ())]
        return (*self.accusations, *said, *filter(None, notes), *unstated, self.remarks)

    @property
    def traceless(self) -> tuple[str, ...]:
        """Faults that it says no residual would show."""
        suspects = (self.estimate or {}).get("suspects", ())
        return tuple(s["code"] for s in suspects if s["strength"] == "not excluded")


def say(*arguments: object) -> Said:
    """Runs one command line."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = run([str(one) for one in arguments])
    return Said(code, out.getvalue(), err.getvalue())


def fitted(paths: Sequence[object], *options: object, before: str = "") -> Answer:
    """``motorid fit --json`` of those captures; ``before``: what earlier commands said."""
    done = say("fit", *paths, *options, "--json")
    begins = done.out.find("{")
    estimate = json.loads(done.out[begins:]) if begins >= 0 else None
    return Answer(done.code, estimate, before + done.err)


@cache
def offers(command: str, option: str) -> bool:
    """Whether a command has that option; ``--help`` alone leaves the rarer ones out."""
    return option in say(command, "--help-all").out
