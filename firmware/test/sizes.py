"""RAM, flash and worst stack of the core on an ATmega328P, held against the stated budget.

Compiles the core with test/stub.c into the folder named, reads the compiler's stack figures
(-fstack-usage) and follows the calls in the disassembly. Library functions are counted by their
pushes. What a port's own functions take on top is the port's business.
"""

from __future__ import annotations

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

MCU = "atmega328p"
RETURN = 2  # bytes of a return address on that chip
FLAGS = ["-std=c11", "-Os", f"-mmcu={MCU}", "-fno-common", "-fno-tree-switch-conversion"]
FLAGS += ["-ffunction-sections", "-Wl,--gc-sections", "-fstack-usage", "-Icore"]
BUDGET = {  # bytes
    "flash": 23_040,  # of 32,256
    "RAM": 1_536,
    "stack of core_sample": 80,
    "stack of core_poll": 210,
}
FUNCTION = re.compile(r"^[0-9a-f]+ <(\S+)>:$")
CALL = re.compile(r"\t(?:r?call|r?jmp)\t.*<([^+>]+)>$")


def run(*command: str) -> str:
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return done.stdout


def build(folder: Path) -> Path:
    """The linked core; stack figures stand beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    objects = []
    for source in [*sorted(Path("core").glob("*.c")), Path("test/stub.c")]:
        objects.append(str(folder / f"{source.stem}.o"))
        run("avr-gcc", *FLAGS, "-c", str(source), "-o", objects[-1])
    elf = folder / "core.elf"
    run("avr-gcc", *FLAGS, *objects, "-lm", "-o", str(elf))
    return elf


def stack_figures(folder: Path) -> dict[str, int]:
    """Bytes of each of our functions; one that is not static would end this with an error."""
    figures = {}
    for path in folder.glob("*.su"):
        for line in path.read_text().splitlines():
            place, size, kind = line.split("\t")
            if kind != "static":
                raise SystemExit(f"{place}: its stack is {kind}")
            figures[place.rsplit(":", 1)[1]] = int(size)
    return figures


def disassembly(elf: Path) -> tuple[dict[str, set[str]], dict[str, int]]:
    """Functions that each function calls or jumps to, and its pushes."""
    calls: dict[str, set[str]] = {}
    pushes: dict[str, int] = {}
    name = ""
    for line in run("avr-objdump", "-d", str(elf)).splitlines():
        if match := FUNCTION.match(line):
            name = match[1]
            calls[name], pushes[name] = set(), 0
        elif match := CALL.search(line):
            calls[name] |= {match[1]} - {name}
        pushes[name] = pushes.get(name, 0) + ("\tpush\t" in line)
    return calls, pushes


def depth(elf: Path, root: str) -> int:
    """Most stack that a call of ``root`` takes, its return address included."""
    figures = stack_figures(elf.parent)
    calls, pushes = disassembly(elf)

    def own(name: str) -> int:
        plain = name.split(".")[0]  # parts that the compiler has split off: core_sample.part.3
        return figures.get(name, figures.get(plain, pushes.get(name, 0)))

    @cache
    def worst(name: str) -> int:
        below = (worst(callee) for callee in calls.get(name, ()))
        return RETURN + own(name) + max(below, default=0)

    return worst(root)


def sizes(elf: Path) -> tuple[int, int]:
    """Flash and RAM."""
    text, data, bss = map(int, run("avr-size", str(elf)).splitlines()[1].split()[:3])
    return text + data, data + bss


def main() -> None:
    elf = build(Path(sys.argv[1]))
    flash, ram = sizes(elf)
    found = {"flash": flash, "RAM": ram}
    found |= {f"stack of {r}": depth(elf, r) for r in ("core_sample", "core_poll")}
    over = False
    for name, value in found.items():
        over |= value > BUDGET[name]
        print(f"{name:22} {value:6} bytes of {BUDGET[name]:6}")
    if over:
        raise SystemExit("over the budget")


if __name__ == "__main__":
    main()
