"""Writes the tables of docs/faults.md: ``python -m tests.faults.table [--check]``.

Every row is a capture that is run here and now. ``--check`` writes nothing, and exits with 1 when
the page says otherwise; counts of samples may differ between computers.
"""

from __future__ import annotations

import argparse
import difflib
import os
import re
import sys
import tempfile
from pathlib import Path
from unittest import mock

from motorid.acquire import record, run_header
from motorid.wire.enums import EndReason, Fault
from tests.faults.laws import LOSS_S, Outcome, Trial
from tests.faults.scenarios import SCENARIOS, Scenario
from tests.faults.witness import BoardWitness

PAGE = Path(__file__).resolve().parents[2] / "docs" / "faults.md"
BEGIN, END = "<!-- tables: python -m tests.faults.table -->", "<!-- end of tables -->"
HEAD = """\
| fault | what the user sees | motor | samples kept of sent | exit code |
|---|---|---|---|---|"""


def row(scenario: Scenario) -> str:
    """One capture, as a row. Raises AssertionError where it breaks a law."""
    with tempfile.TemporaryDirectory() as outer:
        folder, home = Path(outer, "bench"), Path(outer, "home")
        folder.mkdir()
        home.mkdir()
        with (
            mock.patch.object(run_header.random, "randrange", return_value=77),
            mock.patch.dict(os.environ, HOME=str(home)),
        ):
            trial = Trial(
                scenario.schedule,
                folder,
                change=scenario.change,
                other=scenario.other,
                lie=scenario.lie,
                act=scenario.act,
                prepare=scenario.prepare,
            )
            outcome = trial.run()
        says = outcome.says.replace(str(home), "HOME")
        says = says.replace(f"{folder}/", "").replace(str(folder), "FOLDER")
    assert not outcome.broken, f"{scenario.what}: {outcome.broken}"
    cells = (
        scenario.what,
        seen(outcome, says),
        motor(trial),
        samples(trial, outcome),
        code(outcome),
    )
    return f"| {' | '.join(cells)} |"


def seen(outcome: Outcome, says: str) -> str:
    """The sentence on stderr; where there is none, what the file says."""
    says = re.sub(r"(sim|relay)://\S*?: ", "PORT: ", says).replace("|", "\\|")
    if says:
        return says
    capture = outcome.capture
    lacks = "; ".join(record.remarks(capture)) if capture is not None else ""
    if outcome.exit_code:
        return f"then `motorid recover`: {lacks.partition(';')[0]}"
    return f"written; {lacks}" if lacks else "written"


def motor(trial: Trial) -> str:
    """How the bridge came to be open."""
    boards = [board for board in trial.boards if board.runs]
    if not boards:
        return "never driven"
    return ended(boards[0])


def ended(witness: BoardWitness) -> str:
    """How a board's last run ended."""
    if witness.board.boots > 1:
        return "coasts: open by reset"
    if witness.ended is None:  # which a board that lies did not say
        return "driven" if witness.board.run is not None else "coasts: program over"
    reason = EndReason(witness.ended.fields["reason"])
    if reason is EndReason.FAULT:
        fault = Fault(witness.board.fault)
        since = f" after {witness.unheard_s:.2f} s" if fault is Fault.HOST_SILENCE else ""
        return f"coasts: tripped, {fault.name.lower()}{since}"
    which = "weak pulse over" if witness.runs == 1 else "program over"
    return f"coasts: {which}" if reason is EndReason.COMPLETED else "coasts: stopped by the host"


def samples(trial: Trial, outcome: Outcome) -> str:
    """How many of those sent are in the file."""
    host = trial.schedule.host
    if host in LOSS_S:
        return f"all read {LOSS_S[host]:g} s before, or earlier"
    if not outcome.sent:
        return "none sent"
    return f"{outcome.kept} of {outcome.sent}"


def code(outcome: Outcome) -> str:
    """The exit code; a killed process has none of ours."""
    return "–" if outcome.exit_code < 0 else str(outcome.exit_code)


def tables() -> str:
    """All of them, in markdown."""
    parts = []
    for title, scenarios in SCENARIOS.items():
        rows = "\n".join(row(scenario) for scenario in scenarios)
        parts.append(f"### {title}\n\n{HEAD}\n{rows}\n")
    return "\n".join(parts)


def comparable(text: str) -> list[str]:
    """Lines without counts of samples, which depend on the computer's arithmetic too."""
    return [re.sub(r"\d+ (samples|of|gaps?)\b", "…", line) for line in text.splitlines()]


def main() -> int:
    """Writes or checks the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    page = PAGE.read_text(encoding="utf-8")
    head, _, rest = page.partition(BEGIN)
    new = f"{head}{BEGIN}\n\n{tables()}\n{END}{rest.partition(END)[2]}"
    if not check:
        PAGE.write_text(new, encoding="utf-8")
        return 0
    diff = list(
        difflib.unified_diff(comparable(page), comparable(new), "docs/faults.md", "now", n=0)
    )
    print("\n".join(diff))
    return 1 if diff else 0


if __name__ == "__main__":
    sys.exit(main())
