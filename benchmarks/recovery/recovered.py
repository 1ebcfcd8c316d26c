"""One mechanism identified from its catalogue: a task of its own, of a module that other processes find."""

import time

from mechid.identification.identify import identify
from mechid.identification.result.fit import Fit
from recovery.campaigns import campaign
from recovery.judgement import judged, truth_of
from recovery.mechanisms import FAMILIES


def recovered(workers: int | None, key: tuple[int, int, str]) -> dict:
    """Return the line of one mechanism, by family, seed and variant; its kernel is compiled before the clock starts."""
    family, seed, variant = key
    mechanism = FAMILIES[family].truth(seed)
    records = campaign(FAMILIES[family].catalogue(), mechanism, seed, variant, FAMILIES[family].stepped)
    truth = truth_of(records, mechanism)
    wall, cpu = time.perf_counter(), time.process_time()
    fit = identify(records, workers=workers)
    seconds = {"wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}
    return {
        "family": family,
        "seed": seed,
        "variant": variant,
        **judged(truth, fit),
        **seconds,
        **_way(fit),
        "truth": dict(truth.values),
        "estimate": {name: fit.parameters[name].value for name in truth.values},
        "std_error": {name: fit.parameters[name].std_error for name in truth.values},
        "bound": dict(truth.bounds),
    }


def _way(fit: Fit) -> dict:
    """Return how the fit came about."""
    return {
        "outcome": fit.outcome.code,
        "evaluations": sum(stage.evaluations for stage in fit.stages),
        "stages": [[s.name, s.evaluations, s.seconds, s.cost, s.note] for s in fit.stages],
        "horizons_s": {name: r.horizon_s for name, r in fit.records.items()},
        "warnings": list(fit.warnings),
        "substeps": fit.provenance["substeps"],
    }
