"""linear.mat, a MATLAB file of version 5 with the models, and a function that makes uncertain models from it."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from mechid.exports.linear.forcing import OrderForcing
from mechid.exports.linear.fraction import fraction
from mechid.exports.linear.linear import FORMAT, Linear
from mechid.exports.linear.state_space import LinearModel, Matrices

UNCERTAIN_SS = """\
function sys = mechid_uss(model, sigmas)
% MECHID_USS  Uncertain state space of a model in linear.mat (Robust Control Toolbox).
%   load linear.mat
%   sys = mechid_uss(free)       each delta within +-2 standard deviations
%   sys = mechid_uss(free, 3)    within +-3
% The deltas are independent directions of the parameters' covariance, one standard deviation each:
% a column of model.fraction.directions is what one of them moves of uncertain.names, in uncertain.units.
if nargin < 2
    sigmas = 2;
end
sizes = model.fraction.sizes;
blocks = cell(1, numel(sizes));
for k = 1:numel(sizes)
    blocks{k} = ureal(sprintf('delta_%d', k), 0, 'Range', [-sigmas, sigmas]) * eye(sizes(k));
end
sys = ss(model.fraction.A, model.fraction.B, model.fraction.C, model.fraction.D);
if ~isempty(sizes)
    sys = lft(blkdiag(blocks{:}), sys);
end
sys.InputName = model.inputs;
sys.OutputName = model.outputs;
end
"""
"""MATLAB function for uncertain models; repeated deltas need more than one call of the Robust Control Toolbox."""


def write_mat(linear: Linear, path: Path) -> None:
    """Write linear.mat: a struct for each model, `uncertain`, `forcing` and `about`."""
    about = {
        "format": FORMAT,
        "name": linear.name,
        "words": _cell(linear.words),
        "start_angle_deg": linear.held.command.start_angle_deg,
        "provenance": json.dumps(dict(linear.provenance)),
    }
    own = linear.uncertain
    uncertain = {
        "names": _cell(own.names),
        "units": _cell(own.units),
        "values": own.values,
        "std_errors": own.std_errors,
        "covariance": own.covariance,
    }
    models = {name: _model(model) for name, model in linear.models.items()}
    # Field names of a MATLAB struct contain letters, digits and underscores only.
    forcing = {re.sub(r"\W", "_", one.name, flags=re.ASCII): _forcing(one) for one in linear.forcing}
    loops = {"loops": _struct(linear.loops.to_dict())} if linear.loops else {}
    content = {**models, "uncertain": uncertain, **({"forcing": forcing} if forcing else {}), **loops, "about": about}
    with path.open("wb") as file:
        savemat(file, content, format="5", long_field_names=True, oned_as="column", do_compression=True)


def _model(model: LinearModel) -> dict[str, Any]:
    parts = fraction(model)
    limits = np.array([model.limits.get(name, (-np.inf, np.inf)) for name in model.inputs.names])
    return {
        **_matrices(model.matrices),
        "names": _names(model),
        "states": _cell(model.states.names),
        "inputs": _cell(model.inputs.names),
        "outputs": _cell(model.outputs.names),
        "state_units": _cell(model.states.units),
        "input_units": _cell(model.inputs.units),
        "output_units": _cell(model.outputs.units),
        "input_limits": limits,
        "x": model.x,
        "y": model.y,
        "parameters": _cell(model.names),
        "by_parameter": _matrices(model.by_parameter),
        "samples": {**_matrices(model.samples), "draws": model.draws},
        "fraction": {**_matrices(parts.matrices), "sizes": parts.sizes.astype(float), "directions": parts.directions},
    }


def _names(model: LinearModel) -> Any:
    """Return the names of signals as further arguments of `ss`, in one row of cells."""
    out = np.empty((1, 6), dtype=object)
    out[0, ::2] = ("StateName", "InputName", "OutputName")
    for k, signals in enumerate((model.states, model.inputs, model.outputs)):
        out[0, 2 * k + 1] = _cell(signals.names)
    return out


def _forcing(one: OrderForcing) -> dict[str, Any]:
    return {
        "name": one.name,
        "stepping": one.stepping,
        "microsteps": float(one.microsteps),
        "waveform": one.waveform,
        "rates": one.rates,
        "orders": one.orders.reshape(1, -1),
        "lines": one.lines,
        "sigma": one.sigma,
        "phase_sigma": one.phase_sigma,
        "bound": one.bound,
        "by_uncertain": one.by_uncertain,
        "rms": one.rms,
        "repeats": one.repeats.astype(float),
    }


def _matrices(of: Matrices) -> dict[str, Any]:
    """Return the matrices with leading axes moved to the end, as MATLAB expects."""
    return {name: np.moveaxis(m, 0, -1) if m.ndim > 2 else m for name, m in zip("ABCD", of.all, strict=True)}


def _struct(value: Any) -> Any:
    """Return nested dicts as structs, texts in lists as cells, numbers as arrays; NaN where JSON has null."""
    if isinstance(value, Mapping):
        return {name: _struct(one) for name, one in value.items()}
    if isinstance(value, list) and value and all(isinstance(one, str) for one in value):
        return _cell(value)
    return value if isinstance(value, str) else np.array(value, dtype=np.float64)


def _cell(texts: Sequence[str]) -> Any:
    """Return strings as a column of cells."""
    # An object array becomes a cell array; an array of strings would become a padded char matrix.
    out = np.empty((len(texts), 1), dtype=object)
    out[:, 0] = list(texts)
    return out
