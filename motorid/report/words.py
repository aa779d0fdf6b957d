"""Sentences that every form of the report shares."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from motorid.estimate.results.estimate import (
    PARAMETERS,
    Diagnostic,
    Estimate,
    Parameter,
    Suspect,
)
from motorid.estimate.results.status import DOUBT, Status
from motorid.report.numbers import shown

NBSP = "\N{NO-BREAK SPACE}"
NAMES = {
    "R": "resistance",
    "L": "inductance",
    "K": "torque constant",
    "B": "viscous friction",
    "J": "inertia",
    "T0": "Coulomb torque",
    "R_25": "resistance at 25 °C",
    "K_25": "torque constant at 25 °C",
    "no_load_speed": "no-load speed",
    "no_load_current": "no-load current",
    "Kv": "speed constant Kv",
}
STATUS_WORDS = {
    Status.ESTIMATED: "estimated",
    Status.FIXED: "fixed",
    Status.AT_BOUND: "at its bound",
    Status.NOT_IDENTIFIABLE: "not identifiable",
    Status.DOUBTFUL: "doubtful",
    Status.NOT_SUPPORTED: "not supported",
}
ONE_RUN = (
    "This run only: one capture shows its own noise and the instruments' limits, "
    "not how results differ from run to run. Three runs or more would show that."
)
COVERAGE = (
    "± is the expanded uncertainty at a coverage probability of 95 %. It is k times the combined "
    "standard uncertainty; statistical and instrument are its two parts. The coverage factor k is "
    "1.96, or Student's t where few degrees of freedom remain."
)


def name_of(parameter: Parameter) -> str:
    """What the parameter is, in words; its name where there are none."""
    return NAMES.get(parameter.name, parameter.name).replace("_", " ")


def file_name(path: object) -> str:
    """Of a path as it was written on any system."""
    return str(path or "").replace("\\", "/").rpartition("/")[2]


def sentence(text: str) -> str:
    """``text`` with a capital and a full stop, where it has none."""
    text = _stopped(text.strip())
    return f"{text[:1].upper()}{text[1:]}"


def _stopped(text: str) -> str:
    return text if not text or text.endswith((".", "!", "?")) else f"{text}."


def six(estimate: Estimate) -> list[Parameter]:
    """R, L, K, B, J, T0 in that order."""
    return [estimate.parameters[name] for name in PARAMETERS if name in estimate.parameters]


def others(estimate: Estimate) -> list[Parameter]:
    """What the model has beside the six."""
    return [p for name, p in estimate.parameters.items() if name not in PARAMETERS]


def reference(estimate: Estimate) -> list[Parameter]:
    """R, and K where it is known, at 25 °C."""
    return list(estimate.at_25.values())


def summary(estimate: Estimate) -> str:
    """One sentence: what was found, and what was not."""
    found = [p for p in six(estimate) if p.status.measured]
    missing = [p.name for p in six(estimate) if p.status is Status.NOT_IDENTIFIABLE]
    refused = [p.name for p in six(estimate) if p.status is Status.NOT_SUPPORTED]
    doubted = [p.name for p in six(estimate) if p.status is Status.DOUBTFUL]
    fixed = [p.name for p in six(estimate) if p.status is Status.FIXED]
    bound = [p.name for p in six(estimate) if p.status is Status.AT_BOUND]
    runs = len(estimate.inputs)
    source = f"From {runs} runs" if runs != 1 else "From one run"
    told = found or [p for p in estimate.combinations.values() if p.status.measured]
    parts = [", ".join(f"{p.name} = {shown(p).text}".replace(" ", NBSP) for p in told)]
    if missing:
        alone = "" if found or not told else " alone"
        parts.append(f"these data do not determine {_list(missing)}{alone}")
    if refused:
        parts.append(f"these data support no value of {_list(refused)}")
    if doubted:
        parts.append(f"{_list(doubted)} {'is' if len(doubted) == 1 else 'are'} doubtful")
    if bound:
        parts.append(f"{_list(bound)} went to the edge of what is possible")
    if fixed:
        parts.append(f"{_list(fixed)} {'was' if len(fixed) == 1 else 'were'} given")
    return f"{source}: {'; '.join(part for part in parts if part)}."


def remarks(estimate: Estimate) -> list[str]:
    """Notes of parameters that were not simply estimated: why, and which run would help.

    Without those of ``doubts``.
    """
    others = (p for p in estimate.parameters.values() if p.status is not Status.DOUBTFUL)
    return _noted((*others, *reference(estimate)))


def doubts(estimate: Estimate, *, labelled: bool = False) -> list[str]:
    """Why parameters are doubtful, for the lines below the table.

    ``labelled``: the lines stand below the word itself, and do not repeat it.
    """
    found = [p for p in estimate.parameters.values() if p.status is Status.DOUBTFUL]
    if labelled:
        found = [replace(p, note=p.note.removeprefix(DOUBT)) for p in found]
    return _noted(found)


def _noted(parameters: Iterable[Parameter]) -> list[str]:
    notes: dict[str, list[str]] = {}
    for p in parameters:
        if p.note:
            notes.setdefault(p.note, []).append(p.name)
    return [f"{', '.join(names)}: {_stopped(note)}" for note, names in notes.items()]


def decisive(estimate: Estimate, finding: Suspect | Diagnostic) -> bool:
    """It stands above the table: it made a value doubtful, or there is none because of it."""
    if isinstance(finding, Diagnostic) and finding.severity == "error":
        return True
    said = finding.code.replace("_", " ")
    every = (*estimate.parameters.values(), *estimate.combinations.values())
    return any(p.status is Status.DOUBTFUL and said in p.note for p in every)


def one_run(estimate: Estimate) -> str:
    """ "This run only", unless there are more runs or a diagnostic says it already."""
    said = any("this run only" in d.message.lower() for d in estimate.diagnostics)
    return "" if said or len(estimate.inputs) != 1 else ONE_RUN


def fit_quality(estimate: Estimate) -> str:
    """How the residuals compare with the noise, in a sentence."""
    freedom = estimate.degrees_of_freedom
    if freedom <= 0:
        return "There are no more readings than unknowns, so the fit cannot be judged."
    ratio = estimate.chi_square / freedom
    return (
        f"Chi-square is {estimate.chi_square:.6g} for {freedom} degrees of freedom "
        f"({ratio:.3g} for each), after {estimate.evaluations} evaluations of the model."
    )


def _list(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def instruments(one: Mapping[str, Any]) -> str:
    """Which rig and calibration gave a capture's readings their meaning; "" where none is known.

    ``one`` is an entry of ``Estimate.inputs``.
    """
    own = [_calibration(one), f"rig file {_short(one.get('rig_sha256'))}"]
    taken = ", ".join(part for part in own if part and one.get("rig_sha256"))
    again = one.get("reanalysed")
    if not again:
        return f"taken with {taken}" if taken else ""
    new = ", ".join(
        part
        for part in (
            _calibration(again),
            f"rig file {_short(again.get('rig_sha256'))} ({again.get('rig_name')})",
        )
        if part
    )
    return f"re-analysed with {new}" + (f"; taken with {taken}" if taken else "")


def traceability(estimate: Estimate) -> str:
    """What the scales of the readings rest on, as ISO/IEC 17025 asks a report to state."""
    valid = [one.get("reanalysed") or one for one in estimate.inputs]
    calibrated = sum(bool(one.get("calibration")) for one in valid)
    if not valid:
        return ""
    if calibrated == len(valid):
        return (
            "Traceability: the calibrated channels are traceable as far as the reference "
            "instruments are that the calibration file names; other scales rest on declarations."
        )
    some = "" if not calibrated else f" of {len(valid) - calibrated} of {len(valid)} captures"
    return (
        f"Traceability{some}: none is established; the scales of the readings rest on what board, "
        "rig file or import declares, and on no cited calibration."
    )


def _calibration(cites: Mapping[str, Any]) -> str:
    cited = cites.get("calibration")
    if not cited:
        return ""
    return f"calibration {cited['name']} of {str(cited['date'])[:10]} {_short(cited['sha256'])}"


def _short(sha256: Any) -> str:
    return f"(sha256 {str(sha256)[:12]})" if sha256 else ""
