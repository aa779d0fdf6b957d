"""motorid: identifies R, L, K, B, J and T0 of a brushed permanent-magnet DC motor on a bench.

>>> import motorid                                                    # doctest: +SKIP
>>> path = motorid.record(motorid.load_rig("sim"), "run.h5")          # doctest: +SKIP
>>> estimate = motorid.fit(path)                                      # doctest: +SKIP
>>> estimate.parameters["R"].value, estimate.parameters["R"].total    # doctest: +SKIP
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from motorid.version import __version__

# Public name -> the module that holds it, imported when the name is first used.
_HOMES = {
    "connect": "motorid.api",
    "fit": "motorid.api",
    "judge": "motorid.api",
    "load": "motorid.capture.store",
    "load_product": "motorid.api",
    "load_rig": "motorid.rig",
    "record": "motorid.api",
    "save": "motorid.capture.store",
    "MotoridError": "motorid.errors",
}
__all__ = [*_HOMES, "__version__"]

if TYPE_CHECKING:
    from motorid.api import connect as connect
    from motorid.api import fit as fit
    from motorid.api import judge as judge
    from motorid.api import load_product as load_product
    from motorid.api import record as record
    from motorid.capture.store import load as load
    from motorid.capture.store import save as save
    from motorid.errors import MotoridError as MotoridError
    from motorid.rig import load_rig as load_rig


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'motorid' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
