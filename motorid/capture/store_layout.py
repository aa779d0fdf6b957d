"""Names and numbers of the capture format, which its writer and its reader share."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from motorid.capture.model import Channel, Wiring

FORMAT = "motorid capture"
MAJOR, MINOR = 1, 6
SEALED_MINOR = 1  # from this minor on a file carries the digest of its content
DECLARED_MINOR = 2  # from this minor on a file says which facts of a channel nobody stated
CHUNK = 1 << 16  # rows of a column that share a checksum
REASON = "S120"
PHASES = np.dtype([("index", "<i4"), ("tick", "<i8")])
GAPS = np.dtype([("index", "<i8"), ("samples", "<i8"), ("reason", REASON)])
CHANNEL_FIELDS = tuple(f.name for f in fields(Channel) if f.name not in ("name", "raw"))
WIRING_FIELDS = tuple(f.name for f in fields(Wiring))
