"""[program] of a rig file: climbs, or steps, which may be signals of many levels; a held rotor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from motorid.errors import MotoridError, RigError
from motorid.excitation import Levels, multisine, prbs, slow_turn
from motorid.program import Decay, Program, Rotor, Step, StepKind, climbs
from motorid.rig_keys import (
    HELD,
    MULTISINE,
    PRBS,
    SECTIONS,
    SIGNALS,
    SLOW_TURN,
    STEP,
    read_table,
    show,
)
from motorid.rig_model import Nameplate
from motorid.rig_program import coasting_s, default_program, settling_s, turning_s

SIGNAL_S = 0.05  # of a PRBS or a multisine
BITS, TONES, POINTS = 4, 4, 16  # that a board of few steps holds
TURNS = 1.5  # each way, of a slow turn
DRIVES = {StepKind.DRIVE_VOLTS: "volts", StepKind.DRIVE_DUTY: "duty"}
MOST = 200  # steps in a file
SHAPES = {PRBS: ("bits",), MULTISINE: ("tones", "points"), SLOW_TURN: ("turns",)}


def read_program(document: Mapping[str, Any], nameplate: Nameplate, where: str) -> Program:
    """The program of a rig file's tables. Raises RigError naming ``where`` and the key."""
    try:
        return _Reader(document.get("program", {}), nameplate, where).program()
    except RigError as error:
        text = str(error)
        raise error if text.startswith(where) else RigError(f"{where}: {text}") from None
    except MotoridError as error:
        raise RigError(f"{where}: [program]: {error}") from None


class _Reader:
    def __init__(self, table: Any, nameplate: Nameplate, where: str) -> None:
        self.table, self.nameplate, self.where = table, nameplate, where

    def program(self) -> Program:
        if isinstance(self.table, dict) and "steps" in self.table:
            return self._of_steps(self.table)
        keys = {**SECTIONS["program"], **HELD}
        compact = read_table(self.table, keys, "program", self.where)
        if not compact:
            return default_program(self.nameplate)
        return self._held(self._climbs(compact), compact)

    def _of_steps(self, table: dict[str, Any]) -> Program:
        others = [key for key in table if key != "steps" and key not in HELD]
        if others:
            raise RigError(f"program.{others[0]} does not go with [[program.steps]]: keep one")
        steps = table["steps"]
        if not isinstance(steps, list) or not 0 < len(steps) <= MOST:
            raise RigError(f"program.steps must be a list of 1 to {MOST} steps")
        said = {key: value for key, value in table.items() if key in HELD}
        said = read_table(said, HELD, "program", self.where)
        read = [self._step(index, step) for index, step in enumerate(steps)]
        kinds = {kind for kind, _ in read}
        if kinds & set(SIGNALS):
            said = {"rotor": Rotor.ASK.value, **said}
        if "rotor" in said and SLOW_TURN in kinds:
            raise RigError("a slow_turn step turns the rotor: leave program.rotor out")
        return self._held(Program(tuple(step for _, some in read for step in some)), said)

    def _held(self, program: Program, said: Mapping[str, Any]) -> Program:
        if "rotor" not in said:
            if "energy_j" in said:
                raise RigError("program.energy_j goes with program.rotor: say how it is held")
            return program
        if "energy_j" not in said:
            raise RigError(
                "program.energy_j is missing: state the most I²R heat (J) that a run may give the "
                "winding of a rotor that is held"
            )
        return Program(program.steps, Rotor(said["rotor"]), said["energy_j"])

    def _climbs(self, compact: dict[str, Any]) -> Program:
        given = [key for key in ("levels_v", "levels_duty") if key in compact]
        if len(given) != 1:
            raise RigError("[program] takes exactly one of levels_v and levels_duty")
        levels = compact[given[0]]
        return climbs(
            levels,
            kind=StepKind.DRIVE_VOLTS if given == ["levels_v"] else StepKind.DRIVE_DUTY,
            drive_s=compact.get("drive_s", settling_s(self.nameplate)),
            coast_s=[compact.get("coast_s", coasting_s(self.nameplate))] * len(levels),
            rest_s=compact.get("rest_s", 0.05),
            decay=_decay(compact),
        )

    def _step(self, index: int, table: Any) -> tuple[str, tuple[Step, ...]]:
        name = f"program.steps[{index}]"
        step = read_table(table, STEP, name, self.where)
        if "kind" not in step:
            raise RigError(f"{name}.kind is missing")
        kind = step["kind"]
        shaped = SHAPES.get(kind, ())
        for keys in SHAPES.values():
            for key in keys:
                if key in step and key not in shaped:
                    raise RigError(f"{name}: a {kind} step takes no {key}")
        if kind in SIGNALS:
            return kind, self._signal(name, step)
        for key in ("amplitude_v", "amplitude_duty"):
            if key in step:
                raise RigError(f"{name}: a {kind} step takes no {key}")
        return kind, self._slow_turn(name, step) if kind == SLOW_TURN else self._plain(name, step)

    def _plain(self, name: str, step: Mapping[str, Any]) -> tuple[Step, ...]:
        if "duration_s" not in step:
            raise RigError(f"{name}.duration_s is missing")
        kind = StepKind[step["kind"].upper()]
        level_key = DRIVES.get(kind)
        for key in DRIVES.values():
            if (key in step) != (key == level_key):
                verb = "needs" if key == level_key else "takes no"
                raise RigError(f"{name}: a {step['kind']} step {verb} {key}")
        if level_key is None:
            if "decay" in step:
                raise RigError(f"{name}: a {step['kind']} step takes no decay")
            return (Step(kind, step["duration_s"]),)
        return (Step(kind, step["duration_s"], step[level_key], _decay(step)),)

    def _signal(self, name: str, step: Mapping[str, Any]) -> tuple[Step, ...]:
        """A PRBS or a multisine about a level, 0 unless it is named."""
        in_volts, in_duty = "amplitude_v" in step, "amplitude_duty" in step
        if in_volts == in_duty:
            raise RigError(f"{name}: give exactly one of amplitude_v and amplitude_duty")
        centre, other = ("volts", "duty") if in_volts else ("duty", "volts")
        unit = "v" if in_volts else "duty"
        if other in step:
            raise RigError(f"{name}: amplitude_{unit} goes with {centre}, not with {other}")
        level, amplitude = step.get(centre, 0.0), step[f"amplitude_{unit}"]
        if in_duty and abs(level) + amplitude > 1.0:
            raise RigError(
                f"{name}: {show(level)} ± {show(amplitude)} passes a duty of 1: lower one of them"
            )
        kind = StepKind.DRIVE_VOLTS if in_volts else StepKind.DRIVE_DUTY
        levels = Levels(kind, level, amplitude, _decay(step))
        seconds = step.get("duration_s", SIGNAL_S)
        if step["kind"] == PRBS:
            return prbs(levels, step.get("bits", BITS), seconds)
        return multisine(levels, step.get("tones", TONES), step.get("points", POINTS), seconds)

    def _slow_turn(self, name: str, step: Mapping[str, Any]) -> tuple[Step, ...]:
        given = [key for key in DRIVES.values() if key in step]
        if len(given) != 1:
            raise RigError(f"{name}: give exactly one of volts and duty")
        level = step[given[0]]
        if not level > 0.0:
            raise RigError(f"{name}.{given[0]} must be above 0: the step turns both ways")
        kind = StepKind.DRIVE_VOLTS if given == ["volts"] else StepKind.DRIVE_DUTY
        seconds = step.get("duration_s")
        if seconds is not None and "turns" in step:
            raise RigError(f"{name}: give turns or duration_s, not both")
        if seconds is None:
            if kind is StepKind.DRIVE_DUTY:
                raise RigError(f"{name}: a duty needs duration_s; with volts the nameplate may do")
            seconds = turning_s(self.nameplate, level, step.get("turns", TURNS), name)
        return slow_turn(Levels(kind, 0.0, level, _decay(step)), seconds)


def _decay(table: Mapping[str, Any]) -> Decay:
    return Decay[table.get("decay", "synchronous_slow").upper()]
