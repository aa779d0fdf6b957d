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
from motorid.errors import UsageError
from motorid.rig import Rig, load_rig
from motorid.rig_front_end import FAMILY
from motorid.workflow.kit import FAMILIES, Able, Answers, Kit, kit

AUTO, VIRTUAL = "auto", ("sim://", "emu://")  # boards that forget when they are closed
NAMES = {board: f"{FAMILY}{family}" for board, family in FAMILIES.items()}
FAR = 0.25  # of the applied voltage, by which the terminals' reading is worth a word
SUPPLY_FAR = 0.1  # of the supply as stated


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
    """Drives weak pulses, and says what they show of signs, scales and counts.

    ``turn_round`` is asked, with what was seen, whether to count the encoder the other way.
    Raises RigError with what to mend, LinkError where the board is lost.
    """
    try:
        rig, figures = _pulsed(bench.path)
    except SignError as error:
        if error.sign is not Sign.BACKWARDS or not turn_round(str(error)):
            raise
        write(turned_round(bench))
        yield "the encoder is now counted the other way (wiring.encoder_reversed)"
        rig, figures = _pulsed(bench.path)
    yield from _sentences(rig, figures)


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


def _sentences(rig: Rig, seen: Fields) -> Iterator[str]:
    turns = seen["counts"] / rig.wiring.counts_per_turn * rig.wiring.gear_ratio
    yield (
        f"signs    right: +{seen['volts']:.3g} V brings current, voltage and counts forward "
        f"({seen['duty']:.0%} duty)"
    )
    yield (
        f"counts   {seen['counts']} in the pulse: {turns:.3g} turns of the motor; look whether "
        "its shaft turned so far"
    )
    if seen["current_a"] is not None:
        yield f"current  {seen['current_a']:.3g} A while driving, {seen['peak_a']:.3g} A at most"
        wide = abs(seen["zero_a"]) > 3 * seen["zero_uncertainty_a"]
        more = ": more than its facts allow; is it the right sensor?" if wide else ""
        yield f"zero     the sensor reads {seen['zero_a']:.3g} A without current{more}"
    if seen["voltage_v"] is not None:
        yield _scale_of_volts(rig, seen["volts"], seen["voltage_v"])
    if seen["supply_v"] is not None:
        stated = rig.supply_voltage_v or seen["supply_v"]
        off = abs(seen["supply_v"] / stated - 1.0) > SUPPLY_FAR
        more = f", not {stated:g} V as stated: check the divider" if off else ""
        yield f"supply   {seen['supply_v']:.3g} V{more}"


def _scale_of_volts(rig: Rig, applied: float, read: float) -> str:
    share, drop = read / applied, rig.wiring.bridge_drop_v
    said = f"voltage  the terminals read {read:.3g} V of {applied:.3g} V applied"
    if abs(share - 1.0) <= FAR:
        return said
    if drop and share < 1.0:
        return f"{said}; the bridge keeps the rest"
    return f"{said}: check the divider, and the front end's facts"
