from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from s3fs import S3FileSystem

from tests.storage.stores import ENVIRONMENT, Store


@pytest.fixture(scope="session")
def store() -> Iterator[Store]:
    found = Store()
    yield found
    found.kill()


@pytest.fixture
def here(store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Store:
    """The store, as the environment names it, with spool and cache of this test alone."""
    for name, value in ENVIRONMENT.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("AWS_ENDPOINT_URL", store.address)
    monkeypatch.setattr(S3FileSystem, "retries", 1)
    S3FileSystem.clear_instance_cache()  # another test may have had another environment
    monkeypatch.setenv("MOTORID_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("MOTORID_SPOOL", str(tmp_path / "spool"))
    return store


@pytest.fixture(scope="session")
def motors(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three captures of exact motors, and one that is torn."""
    from motorid.capture import store
    from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy

    folder = tmp_path_factory.mktemp("motors")
    for seed in range(3):
        made = noisy(clean_capture(FAULHABER, Plan(volts=(6.0, 3.0))), seed, 1e-3, 1e-4)
        about = {"created": f"2026-11-25T06:0{seed}:00+00:00", "serial": f"D{seed}"}
        made = replace(made, provenance={**made.provenance, **about})
        store.save(made, folder / f"m{seed}.h5")
    (folder / "torn.h5").write_bytes((folder / "m0.h5").read_bytes()[:3000])
    return folder
