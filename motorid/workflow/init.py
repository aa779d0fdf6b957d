"""A bench from its parts: files, facts in the board, and what a first weak pulse shows."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from motorid.acquire import front_end as board_facts
from motorid.acquire.board import Fields
from motorid.acquire.check import check_signs, check_supply
from motorid.acquire.interrupt import interruptible
from motorid.acquire.port import open_port
from motorid.acquire.ports import identity_of, only_port
from motorid.acquire.session import Session
from motorid.acquire.signs import Sign, SignError
from motorid.capture.model import CURRENT, SUPPLY
from motorid.errors import RigError, UsageError
from motorid.rig import Rig, load_rig
from motorid.rig_front_end import FAMILY
from motorid.workflow.kit import FAMILIES, Able, Answers, Kit, kit
from motorid.workflow.pulse_verdict import verdicts

AUTO, VIRTUAL = "auto", ("sim://", "emu://")  # boards that forget when they are closed
NAMES = {board: f"{FAMILY}{family}" for board, family in FAMILIES.items()}


@dataclass(frozen=True)
class Bench:
    """Where the files are, what they say, and what the board can."""

    path: Path
    said: Answers
    kit: Kit
    able: Able

    @property
    def front_end_path(self) -> Path:
        """Beside the rig file."""
        return self.path.with_name(f"{self.path.stem}-front-end.toml")


def found_port(said: Answers) -> Answers:
    """``said`` with the port of the one board that is plugged in. Raises LinkError."""
    return said if said.port != AUTO else replace(said, port=only_port())


def prepare(said: Answers, path: Path, *, force: bool, ask_board: bool) -> Bench:
    """The bench of these answers; nothing is written yet, and nothing moves.

    Raises UsageError where files are there already, or board and answers contradict each other;
    LinkError where nobody answers.
    """
    if path.suffix != ".toml":
        raise UsageError(f"{path}: a rig file ends in .toml: name it so")
    able = said.able
    if ask_board:
        who = identity_of(said.port)
        wanted, able = NAMES.get(said.board), _told(said, who)
        if wanted is not None and not said.port.startswith("sim://") and who["board"] != wanted:
            raise UsageError(
                f"{said.port}: {who['board']} answers, and not a {said.board}: name the right board"
            )
    bench = Bench(path, said, kit(said, path.stem, "", able), able)
    named = "" if said.port.startswith(VIRTUAL) else bench.front_end_path.name
    bench = replace(bench, kit=kit(said, path.stem, named, able))
    there = [one for one in (path, bench.front_end_path) if one.exists()]
    if there and not force:
        raise UsageError(f"{there[0]} is there already: name another with -o, or use --force")
    return bench


def _told(said: Answers, who: Fields) -> Able:
    """By the board's own word; over a slow link its rate is lower."""
    fastest = float(who["clock_hz"]) / float(who["min_sample_period_ticks"])
    return Able(int(who["encoder_edge_ceiling_hz"]), min(said.able.rate_hz, fastest))


def write(bench: Bench) -> None:
    """Both files, whole or not at all. Raises UsageError where they cannot be written."""
    texts = {bench.front_end_path: bench.kit.front_end.text, bench.path: bench.kit.rig.text}
    drafts = {path: path.with_name(f".{path.name}.draft") for path in texts}
    try:
        for path, text in texts.items():
            drafts[path].write_text(text, encoding="utf-8")
        for path in texts:
            os.replace(drafts[path], path)
    except OSError as error:
        raise UsageError(f"{bench.path}: cannot be written ({error.strerror})") from None
    finally:
        for draft in drafts.values():
            with contextlib.suppress(OSError):
                draft.unlink(missing_ok=True)


def store(bench: Bench) -> list[str]:
    """The facts into the board; a line each of what it holds then. Raises LinkError, RigError."""
    return board_facts.store(bench.said.port, bench.kit.front_end)


def turned_round(bench: Bench) -> Bench:
    """With the encoder counted the other way."""
    said = replace(bench.said, encoder_reversed=not bench.said.encoder_reversed)
    named = bench.kit.rig.front_end
    return replace(bench, said=said, kit=kit(said, bench.path.stem, named, bench.able))


def verdict(bench: Bench, turn_round: Callable[[str], bool]) -> Iterator[str]:
    """Drives weak pulses, and says of signs, scales and counts whether they are right.

    ``turn_round`` is asked, with what was seen, whether to count the encoder the other way.
    Raises RigError with what to mend, after the last line; LinkError where the board is lost.
    """
    try:
        rig, figures = _pulsed(bench.path)
    except SignError as error:
        if error.sign is not Sign.BACKWARDS or not turn_round(str(error)):
            raise
        write(turned_round(bench))
        yield "the encoder is now counted the other way (wiring.encoder_reversed)"
        rig, figures = _pulsed(bench.path)
    found = list(verdicts(rig, figures, bench.said.constant))
    yield from (one.line() for one in found)
    if wrong := [one.of for one in found if one.word == "wrong"]:
        raise RigError(
            f"{bench.path}: the pulse shows something wrong ({', '.join(wrong)}): mend it as its "
            "line says, and run init again with --force"
        )


def _pulsed(path: Path) -> tuple[Rig, Fields]:
    rig = load_rig(str(path))
    port = open_port(rig.port)
    try:
        session = Session(port, rig)
        zero, _ = session.zero()
        supply_v = check_supply(session.board, session.rig)
        with interruptible() as stop:
            found = check_signs(session.board, session.rig, session.config, zero, supply_v, stop)
        if not found:
            raise KeyboardInterrupt("interrupted; the bridge is open")
        known = session.board.descriptors
        amperes = known[CURRENT]["scale"] * (zero["current_offset"] - known[CURRENT]["offset"])
        return rig, found | {
            "zero_a": amperes,
            "zero_uncertainty_a": abs(known[CURRENT]["scale"])
            * known[CURRENT]["offset_uncertainty"],
            "supply_v": supply_v if SUPPLY in known else None,
        }
    finally:
        port.close()
