"""Files with one flipped bit: the same data, or a sentence that says damage; nothing in between.

``python -m tests.fuzz.bit_flips --flips 10000`` flips bits of a capture, a journal, an estimate and
a verdict in turn. What a bit does is seen in a forked process with a limit on its work, because
HDF5's library hangs or dies on some damaged files; a user's file has such a process as well.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import io
import json
import os
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorid import json_seal
from motorid.acquire.journal import MAGIC, Digest, Kind, encode_record, parse_journal
from motorid.acquire.journal_check import Wholeness, state_of
from motorid.capture import store, store_pack, store_read
from motorid.errors import DataError
from motorid.workflow.verify import verify

WORK_S = 2  # of the processor, for one file
SAME, SAID = 0, 10  # exit codes of the process that reads a changed file
OTHER, SILENT = 11, 12  # other data; a refusal that does not speak of damage
DIED = 13
CORPUS = Path(__file__).resolve().parents[1] / "corpus" / "format_1_0"


@dataclass(frozen=True)
class WholeFile:
    """A whole file of some kind; ``read`` gives what it says, or raises DataError."""

    data: bytes
    read: Callable[[bytes], Any]
    forked: bool = False


@functools.lru_cache(maxsize=1)
def kinds() -> dict[str, WholeFile]:
    """Small files that are whole."""
    old = store_read.read((CORPUS / "run.h5").read_bytes(), "run.h5", "")
    capture = store.to_bytes(old)
    return {
        "capture": WholeFile(capture, _read_capture, forked=True),
        "journal": WholeFile(_journal(), _read_journal),
        "estimate": WholeFile(_document("estimate.json"), _read_document),
        "verdict": WholeFile(_document("verdict.json"), _read_document),
    }


def _journal() -> bytes:
    """The corpus's journal, closed as it is today."""
    digest, old = Digest(), parse_journal((CORPUS / "cut.h5.journal").read_bytes())
    parts = [MAGIC + encode_record(Kind.HEADER, 0, json.dumps(dict(old.header)).encode())]
    parts += [encode_record(one.kind, one.time_s, one.data) for one in old.records]
    for part in parts:
        digest.add(part)
    return b"".join([*parts, digest.closing(b"")])


def _document(name: str) -> bytes:
    """A document of the corpus with its digest, a few of its lines left out."""
    said = json.loads((CORPUS / name).read_text(encoding="utf-8"))
    return json.dumps(json_seal.sealed(said), indent=2, ensure_ascii=False).encode()


def _read_capture(data: bytes) -> Any:
    packed = store_pack.pack(store_read.read(data, "run.h5", "-"))
    return {name: (str(one.dtype), one.tobytes()) for name, one in packed.items()}


def _read_journal(data: bytes) -> Any:
    found = state_of(data)
    if found.whole is not Wholeness.SOUND:
        word = "damaged" if found.whole is Wholeness.DAMAGED else found.whole.value
        raise DataError(f"{word} at {found.at}: {found.why}")
    parsed = parse_journal(data)
    return dict(parsed.header), parsed.records


def _read_document(data: bytes) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "estimate.json")
        path.write_bytes(data)
        return json_seal.read(path, "an estimate")


def outcome(kind: WholeFile, data: bytes, whole: Any) -> int:
    """SAME, SAID, OTHER, SILENT or DIED."""
    if not kind.forked:
        return _outcome(kind, data, whole)
    pid = os.fork()
    if not pid:
        code = DIED
        with contextlib.suppress(BaseException), contextlib.redirect_stderr(io.StringIO()):
            _limit()
            code = _outcome(kind, data, whole)
        os._exit(code)
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    return DIED if code < 0 else code


def _limit() -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_CPU, (WORK_S, WORK_S))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _outcome(kind: WholeFile, data: bytes, whole: Any) -> int:
    try:
        found = kind.read(data)
    except DataError as error:
        return SAID if "damage" in str(error) else SILENT
    return SAME if found == whole else OTHER


def flips(data: bytes, count: int, seed: int) -> Iterator[tuple[int, int, bytes]]:
    """Copies with one bit flipped: its byte, its number, the copy."""
    rng = random.Random(seed)
    for _ in range(count):
        at, bit = rng.randrange(len(data)), rng.randrange(8)
        changed = bytearray(data)
        changed[at] ^= 1 << bit
        yield at, bit, bytes(changed)


def run(count: int, seed: int, only: str = "") -> tuple[dict[str, Counter[int]], list[str]]:
    """What became of ``count`` flips, spread over the kinds, and those that broke the promise."""
    chosen = {name: kind for name, kind in kinds().items() if only in ("", name)}
    counts: dict[str, Counter[int]] = {}
    broken = []
    for name, kind in chosen.items():
        whole, seen = kind.read(kind.data), counts.setdefault(name, Counter())
        for at, bit, data in flips(kind.data, count // len(chosen), seed):
            code = outcome(kind, data, whole)
            seen[code] += 1
            if code not in (SAME, SAID, DIED):
                broken.append(f"{name}, byte {at}, bit {bit}: {code}")
    return counts, broken


def through_the_command(name: str, data: bytes, folder: Path) -> str:
    """The state that ``motorid verify`` gives a file."""
    names = {"capture": "run.h5", "journal": "run.h5.journal"}
    path = folder / names.get(name, f"{name}.json")
    path.write_bytes(data)
    (finding,) = verify([path])
    return finding.state


def main() -> None:
    """Flips bits; prints a row a kind, and ends with 1 where something got through."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flips", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", default="", choices=["", *kinds()])
    options = parser.parse_args()
    counts, broken = run(options.flips, options.seed, options.kind)
    words = {SAME: "same data", SAID: "damage said", DIED: "reader stopped", OTHER: "OTHER DATA",
             SILENT: "NOT SAID"}  # fmt: skip
    for name, seen in counts.items():
        said = ", ".join(f"{words.get(code, code)} {count}" for code, count in sorted(seen.items()))
        print(f"{name}: {sum(seen.values())} flips: {said}")
    print(*broken, sep="\n")
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
