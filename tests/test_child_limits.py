"""What a child that reads a user's file may take, beyond what it took to start."""

from __future__ import annotations

import mmap
import sys
from types import SimpleNamespace

import pytest

from motorid.capture import child

if sys.platform != "linux":
    pytest.skip("only Linux limits a process's memory", allow_module_level=True)

import resource


def given(monkeypatch: pytest.MonkeyPatch, hard: int) -> dict[int, tuple[int, int]]:
    """The limits that are set where the system allows ``hard``, and so much is spent already."""
    found: dict[int, tuple[int, int]] = {}
    spent = SimpleNamespace(ru_utime=3.2, ru_stime=1.5)
    monkeypatch.setattr(resource, "getrusage", lambda _: spent)
    monkeypatch.setattr(resource, "getrlimit", lambda _: (hard, hard))
    monkeypatch.setattr(resource, "setrlimit", found.__setitem__)
    monkeypatch.setattr(child, "_address_space", lambda: 1000)
    child._limit(child.Bounds(memory=500, cpu_s=7))
    return found


def test_work_and_memory_count_from_here_on(monkeypatch: pytest.MonkeyPatch) -> None:
    no_limit = resource.RLIM_INFINITY
    assert given(monkeypatch, no_limit) == {
        resource.RLIMIT_AS: (1500, no_limit),
        resource.RLIMIT_CORE: (0, no_limit),
        resource.RLIMIT_CPU: (5 + 7, no_limit),  # 3.2 and 1.5 s are spent, in whole seconds
    }


def test_a_limit_of_the_system_is_not_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    found = given(monkeypatch, 10)
    assert found[resource.RLIMIT_AS] == (10, 10)
    assert found[resource.RLIMIT_CPU] == (10, 10)
    assert found[resource.RLIMIT_CORE] == (0, 10)


def test_the_address_space_is_that_of_this_process() -> None:
    """By a mapping of its own: what an allocator gives may lie where something lay before."""
    before = child._address_space()
    with mmap.mmap(-1, 64 << 20) as held:
        assert child._address_space() - before >= len(held) // 2
    assert before > 1 << 20
