"""The bill of materials and the third-party notices, from the lock and this environment.

    python -m tools.supply.bill [FOLDER]    writes motorid.cdx.json and NOTICES.txt (into dist/)

The bill is CycloneDX 1.6. It names what every installation needs (required), what an extra adds
(optional) and what tests and tools use (excluded), with the hashes of the lock.
"""

from __future__ import annotations

import json
import sys
import uuid
from collections.abc import Iterable, Iterator
from importlib.metadata import Distribution
from pathlib import Path
from typing import Any

from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packaging.utils import canonicalize_name

from motorid.version import __version__
from tools.supply.licences import licence, table, uses
from tools.supply.packages import (
    LOCKS,
    ROOT,
    Pin,
    SupplyError,
    closure,
    installed,
    needs,
    pins,
    wanted,
    wanted_by_users,
)

Json = dict[str, Any]
TEXTS = ("licen", "copying", "notice", "authors")  # how files with a licence's text begin


def bill() -> Json:
    """The bill of materials. The same inputs give the same bytes: it has no date."""
    locked, scopes = pins(LOCKS["test"]), scope()
    listed = [name for name in sorted(locked) if name in scopes]
    packages = [_component(locked[name], scopes[name]) for name in listed]
    body: Json = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": _motorid()},
        "components": [*packages, *map(_inside, (*table()["vendored"], *table()["firmware"]))],
        "dependencies": [
            _edges("motorid", (one.name for one in wanted("run"))),
            *(_edges(name, (one.name for one in needs(installed(name)))) for name in listed),
        ],
    }
    digest = uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(body, sort_keys=True))
    return {**body, "serialNumber": f"urn:uuid:{digest}"}


def scope() -> dict[str, str]:
    """Of each package of this environment: required, optional or excluded, as CycloneDX has it."""
    extras = closure(wanted_by_users())
    return {
        name: "required" if where == "run" else "optional" if name in extras else "excluded"
        for name, where in uses().items()
    }


def _motorid() -> Json:
    return {
        "type": "application",
        "bom-ref": "motorid",
        "name": "motorid",
        "version": __version__,
        "licenses": [{"expression": "MIT"}],
    }


def _component(pin: Pin, scope: str) -> Json:
    hashes = [{"alg": "SHA-256", "content": one} for one in sorted(pin.sha256)]
    page = f"https://pypi.org/project/{pin.name}/{pin.version}/"
    return {
        "type": "library",
        "bom-ref": pin.name,
        "name": pin.name,
        "version": pin.version,
        "scope": scope,
        "licenses": [{"expression": licence(pin.name)}],
        "purl": f"pkg:pypi/{pin.name}@{pin.version}",
        # a release has a file for each platform; the lock admits all of them
        "externalReferences": [{"type": "distribution", "url": page, "hashes": hashes}],
    }


def _inside(one: Json) -> Json:
    """What is no package: files of others, and what is linked into the boards' images."""
    version = {"version": one["version"]} if "version" in one else {}
    return {
        "type": "library",
        "bom-ref": one["name"],
        "name": one["name"],
        **version,
        "description": one["why"],
        "scope": "required",
        "licenses": [{"expression": one["licence"]}],
        "externalReferences": [{"type": "website", "url": one["url"]}],
    }


def _edges(name: str, others: Iterable[str]) -> Json:
    return {"ref": name, "dependsOn": sorted({str(canonicalize_name(one)) for one in others})}


def written(document: Json) -> str:
    """The text of a bill.

    Raises:
        SupplyError: The schema of CycloneDX 1.6 does not admit it.
    """
    text = json.dumps(document, indent=1, ensure_ascii=False) + "\n"
    fault = JsonStrictValidator(SchemaVersion.V1_6).validate_str(text)
    if fault:
        raise SupplyError(f"the bill of materials breaks its schema: {fault}")
    return text


def notices() -> Iterator[str]:
    """The notice of each package that a user may install, with its licence's text."""
    scopes = scope()
    yield "motorid uses what follows. Each part is under the licence of its authors.\n"
    for name in (name for name in scopes if scopes[name] != "excluded"):
        package = installed(name)
        yield f"\n{'=' * 78}\n{package.name} {package.version}: {licence(name)} ({scopes[name]})\n"
        texts = list(_texts(package))
        yield from texts or [f"No licence file is packaged; see https://pypi.org/project/{name}/\n"]
    for one in (*table()["vendored"], *table()["firmware"]):
        yield f"\n{'=' * 78}\n{one['name']}: {one['licence']}; {one['why']}\n{one['url']}\n"
        if "text" in one:
            yield f"\n{(ROOT / one['text']).read_text(encoding='utf-8').strip()}\n"


def _texts(package: Distribution) -> Iterator[str]:
    """Those of its metadata's folder, which hold those of libraries inside its wheel too."""
    for file in package.files or ():
        inside = ".dist-info" in file.parts[0]
        if inside and Path(file).name.lower().startswith(TEXTS):
            text = Path(str(package.locate_file(file))).read_text(
                encoding="utf-8", errors="replace"
            )
            yield f"\n--- {file.name}\n\n{text.strip()}\n"


def main(arguments: list[str]) -> int:
    """Exit code 1 where something is not installed or has no licence."""
    folder = Path(arguments[0]) if arguments else ROOT / "dist"
    try:
        made = {"motorid.cdx.json": written(bill()), "NOTICES.txt": "".join(notices())}
    except SupplyError as error:
        print(error, file=sys.stderr)
        return 1
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in made.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
        print(f"wrote {folder / name}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
