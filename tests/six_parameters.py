"""The fit of the six parameters alone: most tests of the estimator need no more."""

from __future__ import annotations

from functools import partial

from motorid import identify
from motorid.estimate.results.estimate import SIX

fit = partial(identify.fit, model=SIX)
