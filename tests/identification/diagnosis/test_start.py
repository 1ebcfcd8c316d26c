"""Where a diagnosis begins. Truth: the mechanism file, and what the fit has held."""

from dataclasses import replace

from mechid.identification.diagnosis.start import initial_models
from mechid.identification.result.grade import Grade


def test_a_fit_on_a_wrong_branch_holds_no_parameter(fitted):
    """Truth: the mechanism file, which says what is free; the fit has held one of these."""
    bench, fit = fitted
    held = replace(fit.parameters["gear.damping"], status="frozen")
    fit = replace(fit, parameters={**fit.parameters, "gear.damping": held})

    def free(grade):
        return {p.name for p in initial_models(replace(fit, grade=grade))[0].base.free}

    assert free(Grade.C) == {p.name for p in bench.mechanism.free}
    assert free(Grade.C) - free(Grade.B) == {"gear.damping"}
