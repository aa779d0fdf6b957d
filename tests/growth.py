"""How the work of a function grows with its input, whatever machine it is and whoever shares it."""

from __future__ import annotations

import time
from collections.abc import Callable

TIMES = 5


def growth(small: Callable[[], object], large: Callable[[], object]) -> float:
    """Processor time of ``large`` over that of ``small``, each at its best of five in turn."""
    pairs = [(_seconds(small), _seconds(large)) for _ in range(TIMES)]
    return min(pair[1] for pair in pairs) / min(pair[0] for pair in pairs)


def _seconds(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began
