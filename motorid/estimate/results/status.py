"""What a value's standing is, in one place for fit, report, verdict and history."""

from __future__ import annotations

from enum import StrEnum

DOUBT = "doubtful: "  # begins the part of a parameter's note that tells why it is


class Status(StrEnum):
    """The standing of one quantity; its text is that of the JSON.

    ``DOUBTFUL``: a finding could have moved it by more than half of its interval, which now covers
    that. ``NOT_SUPPORTED``: the data contradict the model so far that no value is given.
    """

    ESTIMATED = "estimated"
    DOUBTFUL = "doubtful"
    FIXED = "fixed"
    AT_BOUND = "at_bound"
    NOT_IDENTIFIABLE = "not_identifiable"
    NOT_SUPPORTED = "not_supported"

    @property
    def measured(self) -> bool:
        """The data gave a value inside its bounds, however sure it is."""
        return self in (Status.ESTIMATED, Status.DOUBTFUL)

    @property
    def unknown(self) -> bool:
        """There is no value."""
        return self in (Status.NOT_IDENTIFIABLE, Status.NOT_SUPPORTED)
