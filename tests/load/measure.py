"""What a process takes of its computer. Linux tells; elsewhere the figures are None."""

from __future__ import annotations

from pathlib import Path


def resident_mb() -> float | None:
    """Resident memory now."""
    return _status("VmRSS")


def peak_mb() -> float | None:
    """The most resident memory so far."""
    return _status("VmHWM")


def _status(key: str) -> float | None:
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    found = [line.split()[1] for line in lines if line.startswith(key + ":")]
    return int(found[0]) / 1024 if found else None
