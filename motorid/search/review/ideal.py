"""What nobody beats for long: maximum likelihood that knows the noise, near the truth.

To first order about the truth its error on a record is a linear map of that record's noise, so it
is known without a search. On the same records it tells an estimator's loss from their luck.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.search.review.experiment import Experiment

DERIVATIVE_STEP = 1e-5  # relative, on either side of the truth


@dataclass(frozen=True)
class Ideal:
    """An experiment at one noise, to first order about the truth; channels, then samples.

    ``slopes`` (parameters, channels, samples): of the outputs by relative changes. ``noise`` and
    ``scale`` (channels, 1): standard deviations, and what the searches divide residuals by.
    """

    experiment: Experiment
    relative_noise: float
    clean: Floats
    slopes: Floats
    noise: Floats
    scale: Floats

    @classmethod
    def of(cls, experiment: Experiment, noise: float) -> Ideal:
        """By differences on either side of the truth."""
        model, record = experiment.truth_model or experiment.model, experiment.clean()
        truth = np.array(list(experiment.truth.values()))
        steps = DERIVATIVE_STEP * np.eye(len(truth))
        high, low = (model.outputs(truth * (1.0 + s), record) for s in (steps, -steps))
        clean = np.array([record.measured[name] for name in experiment.channels])
        peaks = np.abs(clean).max(axis=1)
        shares = [experiment.noise_share.get(name, 1.0) for name in experiment.channels]
        own = experiment.scale
        scale = peaks if own is None else np.array([own[name] for name in experiment.channels])
        deviations = noise * np.array(shares) * peaks
        slopes = (high - low) / (2.0 * DERIVATIVE_STEP)
        return cls(experiment, noise, clean, slopes, deviations[:, None], scale[:, None])

    def errors(self, seeds: int) -> Floats:
        """Signed, (parameters, seeds), in percent: each residual weighed by its noise, known."""
        inverse = 100.0 * np.linalg.inv(self._squares(1.0 / self.noise))
        errors = np.empty((len(self.slopes), seeds))
        for seed in range(seeds):
            measured = self.experiment.problem(self.relative_noise, seed).step.measured
            noise = np.array([measured[n] for n in self.experiment.channels]) - self.clean
            # seed by seed: a product of all at once rounds by how many there are
            errors[:, seed] = inverse @ (
                self._flat(1.0 / self.noise) @ (noise / self.noise).ravel()
            )
        return errors

    def bounds(self) -> Floats:
        """Cramer-Rao bounds of the parameters (parameters,), percent."""
        return np.asarray(100.0 * np.sqrt(np.diag(np.linalg.inv(self._squares(1.0 / self.noise)))))

    def searches(self) -> Floats:
        """Deviations of least squares with the searches' weights, in units of the ideal's."""
        ideal = np.linalg.inv(self._squares(1.0 / self.noise))
        inverse = np.linalg.inv(self._squares(1.0 / self.scale))
        theirs = inverse @ self._squares(self.noise / self.scale**2) @ inverse
        return np.asarray(np.sqrt(np.diag(theirs) / np.diag(ideal)))

    def _flat(self, weight: Floats) -> Floats:
        return np.asarray((self.slopes * weight).reshape(len(self.slopes), -1))

    def _squares(self, weight: Floats) -> Floats:
        return np.asarray(self._flat(weight) @ self._flat(weight).T)
