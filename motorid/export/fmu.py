"""FMU: the motor as a functional mock-up unit for co-simulation, FMI 2.0.

It is made of C, which is in it too (``sources``). Where this machine has a C compiler, the FMU also
holds what it makes of it, for the platform that it was made on; other tools can compile the rest.
"""

from __future__ import annotations

import hashlib
import io
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from xml.sax.saxutils import quoteattr

from motorid.errors import DataError
from motorid.estimate.results.estimate import MEANING, UNITS
from motorid.export.motor import Motor, described

NAME = "motor"
SIGNALS = (  # beside the parameters, in the order of the C's enum: name, unit, causality
    ("voltage", "V", "input"),
    ("load", "N·m", "input"),
    ("current", "A", "output"),
    ("speed", "rad/s", "output"),
    ("angle", "rad", "output"),
)
COMPILER_S = 60
_EARLIEST = (1980, 1, 1, 0, 0, 0)  # in every entry of the archive: equal motors make equal files


def compiler() -> str | None:
    """The C compiler of this machine, or None."""
    return shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


def write(motor: Motor) -> bytes:
    """The FMU. Raises DataError where a compiler is there and does not take its own C."""
    description = "\n".join(described(motor))
    guid = hashlib.sha256(description.encode()).hexdigest()[:32]
    start = ", ".join([*(motor.text(name) for name in motor.values), *("0.0" for _ in SIGNALS)])
    code = f'#define MOTOR_GUID "{guid}"\n#define MOTOR_START {{ {start} }}\n' + _template()
    entries: dict[str, bytes] = {
        "modelDescription.xml": _model(motor, description, guid).encode(),
        f"sources/{NAME}.c": code.encode(),
    }
    if found := compiler():
        folder, suffix = _platform()
        entries[f"binaries/{folder}/{NAME}{suffix}"] = _compiled(found, code, suffix)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            archive.writestr(zipfile.ZipInfo(name, _EARLIEST), data, zipfile.ZIP_DEFLATED)
    return out.getvalue()


def _template() -> str:
    return resources.files("motorid.export").joinpath("fmu_motor.c").read_text("utf-8")


def _platform() -> tuple[str, str]:
    """The folder that FMI 2.0 gives this machine's binaries, and their suffix."""
    system = {"win32": "win", "darwin": "darwin"}.get(sys.platform, "linux")
    suffix = {"win": ".dll", "darwin": ".dylib"}.get(system, ".so")
    intel = platform.machine().lower() in ("x86_64", "amd64")
    return (f"{system}64" if intel else f"{platform.machine().lower()}-{system}"), suffix


def _compiled(found: str, code: str, suffix: str) -> bytes:
    with tempfile.TemporaryDirectory(prefix="motorid-fmu-") as folder:
        source, made = Path(folder, f"{NAME}.c"), Path(folder, f"{NAME}{suffix}")
        source.write_text(code, encoding="utf-8")
        command = [found, "-O2", "-shared", "-fPIC", "-fvisibility=hidden", "-o", str(made)]
        try:
            done = subprocess.run(  # noqa: S603 - the compiler, with words of our own
                [*command, str(source), "-lm"], capture_output=True, timeout=COMPILER_S, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise DataError(f"the C compiler {found} did not make the FMU: {error}") from None
        if done.returncode or not made.exists():
            said = done.stderr.decode(errors="replace")[:300]
            raise DataError(f"the C compiler {found} did not make the FMU: {said}")
        return made.read_bytes()


def _model(motor: Motor, description: str, guid: str) -> str:
    variables = "\n".join(_variables(motor))
    outputs = [6 + k + 1 for k, (_, _, causality) in enumerate(SIGNALS) if causality == "output"]
    unknown = "".join(f'<Unknown index="{index}"/>' for index in outputs)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{NAME}" guid="{guid}"
  description={quoteattr(description)} generationTool={quoteattr(f"motorid {motor.motorid}")}>
  <CoSimulation modelIdentifier="{NAME}" canHandleVariableCommunicationStepSize="true"
    canBeInstantiatedOnlyOncePerProcess="false">
    <SourceFiles><File name="{NAME}.c"/></SourceFiles>
  </CoSimulation>
  <ModelVariables>
{variables}
  </ModelVariables>
  <ModelStructure>
    <Outputs>{unknown}</Outputs>
    <InitialUnknowns>{unknown}</InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def _variables(motor: Motor) -> Iterator[str]:
    for index, name in enumerate(motor.values):
        said = f"{MEANING[name]}, {UNITS[name]}; standard uncertainty {motor.u(name):.2g}"
        yield (
            f'    <ScalarVariable name="{name}" valueReference="{index}" causality="parameter" '
            f'variability="tunable" initial="exact" description={quoteattr(said)}>'
            f'<Real start="{motor.text(name)}"/></ScalarVariable>'
        )
    for index, (name, unit, causality) in enumerate(SIGNALS, len(motor.values)):
        start = ' start="0.0"' if causality == "input" else ""
        initial = ' initial="calculated"' if causality == "output" else ""
        yield (
            f'    <ScalarVariable name="{name}" valueReference="{index}" causality="{causality}" '
            f'variability="continuous"{initial} description="{unit}">'
            f"<Real{start}/></ScalarVariable>"
        )
