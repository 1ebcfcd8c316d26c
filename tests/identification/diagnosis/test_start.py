"""Where a diagnosis begins. Truth: the mechanism file, and what the fit has held."""

from mechid.identification.diagnosis.start import begun


def test_a_fit_on_a_wrong_branch_holds_no_parameter(fitted):
    """Truth: the mechanism file, which says what is free; the fit has held one of these."""
    bench, fit = fitted
    estimate = fit.to_dict()
    held = {**estimate["parameters"]["gear.damping"], "status": "frozen"}
    estimate = {**estimate, "parameters": {**estimate["parameters"], "gear.damping": held}, "grade_reasons": []}

    def free(grade):
        return {p.name for p in begun(bench, {**estimate, "grade": grade})[0].base.free}

    assert free("C") == {p.name for p in bench.mechanism.free}
    assert free("C") - free("B") == {"gear.damping"}
