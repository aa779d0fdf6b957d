"""What is asked of every refusal."""

from __future__ import annotations

LONGEST = 2000


def check_sentence(text: str, input_bytes: int, *, begins: str = "") -> None:
    """Raises unless a refusal says something, and not more than the input explains."""
    assert text.startswith(begins)
    assert len(begins) < len(text) < LONGEST + 4 * input_bytes
