"""Rig files of simulated benches whose gains are hidden."""

from __future__ import annotations

from pathlib import Path

WIDE = "gain_uncertainty=0.02&voltage_gain_uncertainty=0.01"


def rig_file(folder: Path, seed: int = 7, *, more: str = "", name: str = "bench") -> Path:
    """A copy of the packaged simulated rig; gains are drawn from 2 and 1 %."""
    text = Path("rigs/sim.toml").read_text(encoding="utf-8")
    url = f"sim://?motor=faulhaber-2338s006s&speed=max&seed={seed}&{WIDE}"
    lines = [f'port = "{url}"' if line.startswith("port") else line for line in text.splitlines()]
    path = folder / f"{name}.toml"
    path.write_text("\n".join(lines) + "\n" + more, encoding="utf-8")
    return path
