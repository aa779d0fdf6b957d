"""A rig: wiring facts and safety limits of one bench, and how to load one."""

from __future__ import annotations

from motorid.rig_model import Calibration as Calibration
from motorid.rig_model import Limits as Limits
from motorid.rig_model import Nameplate as Nameplate
from motorid.rig_model import Rig as Rig
from motorid.rig_model import Sampling as Sampling
from motorid.rig_program import coasting_s as coasting_s
from motorid.rig_program import default_program as default_program
from motorid.rig_program import settling_s as settling_s


def load_rig(name_or_path: str) -> Rig:
    """The rig of a preset's name ("sim") or of a TOML file.

    Raises RigError, naming the file and the key, when it is absent, unreadable or absurd.
    """
    from motorid.rig_file import load

    return load(name_or_path)
