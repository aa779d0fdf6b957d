"""Devices of pyvisa-sim: a bench supply, a meter and a scanning DAQ, as a definition file."""

from __future__ import annotations

from pathlib import Path

SUPPLY, METER = "TCPIP0::supply::INSTR", "TCPIP0::meter::INSTR"
SCANNER = "TCPIP0::scanner::INSTR"
_PROPERTY = """
      {name}:
        default: {default}
        getter: {{q: "{command}?", r: "{shown}"}}
        setter: {{q: "{command} {parsed}"}}
        specs: {{{specs}}}
"""
_NUMBERS = {"VOLT": 30, "CURR": 10, "VOLT:PROT": 32, "CURR:PROT": 11}
_SWITCHES = ("VOLT:PROT:STAT", "CURR:PROT:STAT", "OUTP")
_DEVICES = """
spec: "1.1"
devices:
  supply:
    eom: {{TCPIP INSTR: {{q: "\\n", r: "\\n"}}}}
    error:
      error_queue:
        - {{q: "SYST:ERR?", default: '0,"No error"', command_error: '-222,"Data out of range"'}}
    dialogues:
{dialogues}
    properties:
{properties}
  meter:
    eom: {{TCPIP INSTR: {{q: "\\n", r: "\\n"}}}}
    error:
      error_queue:
        - {{q: "SYST:ERR?", default: '0,"No error"', command_error: '-113,"Undefined header"'}}
    dialogues:
      - {{q: "*IDN?", r: "MOCK,METER,3,1.0"}}
      - {{q: "*CLS"}}
      - {{q: "READ?", r: "{meter}"}}
  scanner:
    eom: {{TCPIP INSTR: {{q: "\\n", r: "\\n"}}}}
    error:
      error_queue:
        - {{q: "SYST:ERR?", default: '+0,"No error"', command_error: '-113,"Undefined header"'}}
    dialogues:
{scanner}
    properties:
{trigger}
resources:
  {supply}: {{device: supply}}
  {scanner_at}: {{device: scanner}}
  {at}: {{device: meter}}
"""
ANSWERS = {
    "*IDN?": "MOCK,SUPPLY,1,1.0",
    "*CLS": None,
    "VOLT:PROT:TRIP?": "0",
    "CURR:PROT:TRIP?": "0",
    "STAT:QUES?": "+0",
    "MEAS:CURR?": "+1.25000E+00",
    "MEAS:VOLT?": "+3.00100E+00",
}


def definition(
    folder: Path,
    most: dict[str, float] | None = None,
    answers: dict[str, str | None] | None = None,
    meter: str = "+1.2500E+02",
    scanner: dict[str, str | None] | None = None,
) -> str:
    """The backend to write as ``visa``. ``most``: largest settings; ``answers``: fixed ones."""
    fixed = {**ANSWERS, **(answers or {})}
    highest = {**_NUMBERS, **(most or {})}
    found = ""
    for command, high in highest.items():
        if f"{command}?" not in fixed:
            found += _PROPERTY.format(
                name=command.replace(":", "_"), command=command, default=0.0, shown="{:+.5E}",
                parsed="{}", specs=f"min: 0, max: {high}, type: float",
            )  # fmt: skip
    for command in _SWITCHES:
        if f"{command}?" not in fixed:
            found += _PROPERTY.format(
                name=command.replace(":", "_"), command=command, default='"OFF"', shown="{:s}",
                parsed="{:s}", specs='valid: ["ON", "OFF"], type: str',
            )  # fmt: skip
    scans = {"*IDN?": "MOCK,SCANNER,4,1.0", "*CLS": None, **(scanner or {})}
    trigger = "".join(
        _PROPERTY.format(name=name, command=f"TRIG:{name}", default=1, shown="{}", parsed="{}",
                         specs="min: 0, max: 50000, type: float")
        for name in ("TIM", "COUN")
    )  # fmt: skip
    text = _DEVICES.format(
        dialogues=_dialogues(fixed), properties=found, meter=meter, supply=SUPPLY, at=METER,
        scanner=_dialogues(scans), trigger=trigger, scanner_at=SCANNER,
    )  # fmt: skip
    (folder / "devices.yaml").write_text(text)
    return 'visa = "devices.yaml@sim"\n'


def _dialogues(fixed: dict[str, str | None]) -> str:
    return "".join(
        f"      - {{q: '{q}'}}\n" if r is None else f"      - {{q: '{q}', r: '{r}'}}\n"
        for q, r in fixed.items()
    )
