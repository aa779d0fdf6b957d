"""The estimate as JSON, by the published schema ``motorid/schemas/estimate.schema.json``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from motorid import json_text, schemas
from motorid.estimate.results.estimate import (
    Alternative,
    ChannelFit,
    Curve,
    Estimate,
    Parameter,
    Rise,
    SegmentRow,
    SteadyRow,
    TermTrial,
)
from motorid.json_seal import sealed
from motorid.json_text import plain as plain
from motorid.report import suspects

SCHEMA = "motorid-estimate-2"


def schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of what ``to_dict`` returns."""
    return schemas.schema("estimate")


def dumps(estimate: Estimate) -> str:
    """Strict JSON text of the estimate, ending in a newline."""
    return json_text.dumps(to_dict(estimate), indent=2) + "\n"


def to_dict(estimate: Estimate) -> dict[str, Any]:
    """Plain data of the estimate, with its digest. What is unknown or not finite is null."""
    return sealed(_said(estimate))


def _said(estimate: Estimate) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "model": estimate.model,
        "method": estimate.method,
        "parameters": _parameters(estimate.parameters),
        "at_25": _parameters(estimate.at_25),
        "self_heating": _self_heating(estimate.rise),
        "budget": plain(estimate.budget),
        "not_stated": plain(estimate.not_stated),
        "combinations": _parameters(estimate.combinations),
        "derived": _parameters(estimate.derived),
        "nominal_v": plain(estimate.nominal_v),
        "nuisance": _parameters(estimate.nuisance),
        "correlation": {
            "names": list(estimate.free),
            "matrix": plain(np.asarray(estimate.correlation)),
        },
        "models": _models(estimate),
        "alternative": _alternative(estimate.alternative),
        "residuals": [_residual(curve) for curve in estimate.curves],
        "steady_state": [_row(row) for row in estimate.steady],
        "segments": [_row(row) for row in estimate.segments],
        "diagnostics": [
            {"code": d.code, "severity": d.severity, "message": d.message} | suspects.moves(d)
            for d in estimate.diagnostics
        ],
        "suspects": suspects.as_data(estimate),
        "inputs": [plain(dict(i)) for i in estimate.inputs],
        "options": plain(dict(estimate.options)),
        "versions": plain(dict(estimate.versions)),
    }


def _parameters(parameters: Mapping[str, Parameter]) -> dict[str, Any]:
    return {name: _parameter(p) for name, p in parameters.items()}


def _parameter(p: Parameter) -> dict[str, Any]:
    out = {
        "value": plain(p.value),
        "uncertainty": {
            "statistical": plain(p.statistical),
            "instrument": plain(p.instrument),
            "total": plain(p.total),
        },
        "interval_95": plain(p.interval_95),
        "unit": p.unit,
        "status": str(p.status),
    }
    return out | ({"note": p.note} if p.note else {})


def _models(estimate: Estimate) -> list[dict[str, Any]]:
    """The model of ``parameters``, which is the chosen one, and the better one where there is."""
    models: list[tuple[str, Estimate | Alternative, bool]] = [(estimate.model, estimate, True)]
    if estimate.alternative:
        models.append((estimate.alternative.name, estimate.alternative, False))
    return [
        {
            "name": name,
            "chi_square": plain(fit.chi_square),
            "degrees_of_freedom": fit.degrees_of_freedom,
            "evaluations": fit.evaluations,
            "chosen": chosen,
        }
        for name, fit, chosen in models
    ]


def _alternative(better: Alternative | None) -> dict[str, Any] | None:
    if better is None:
        return None
    return {
        "name": better.name,
        "asked": better.asked,
        "terms": [
            {"name": n, "title": t, "equation": e}
            for n, t, e in zip(better.terms, better.titles, better.equations, strict=True)
        ],
        "parameters": _parameters(better.parameters),
        "at_25": _parameters(better.at_25),
        "nuisance": _parameters(better.nuisance),
        "lack_of_fit": [_row(fit) for fit in better.lack_of_fit],
        "trials": [_row(trial) for trial in better.trials],
    }


def _self_heating(rise: Rise | None) -> dict[str, Any] | None:
    if rise is None:
        return None
    return {
        "rise_k": plain(rise.kelvin),
        "uncertainty_k": plain(rise.uncertainty_k),
        "heat_j": plain(rise.heat_j),
        "basis": rise.basis,
    }


def _residual(curve: Curve) -> dict[str, Any]:
    residual = np.asarray(curve.measured, dtype=np.float64) - curve.fitted
    finite = residual[np.isfinite(residual)]
    return {
        "capture": curve.capture,
        "channel": curve.channel,
        "unit": curve.unit,
        "samples": len(residual),
        "rms": plain(float(np.sqrt(np.mean(finite**2))) if len(finite) else None),
        "sigma": plain(curve.sigma),
    }


def _row(row: SteadyRow | SegmentRow | ChannelFit | TermTrial) -> dict[str, Any]:
    return {name: plain(getattr(row, name)) for name in row.__dataclass_fields__}
