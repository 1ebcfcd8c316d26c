"""The variables of a unit. Truth: the mechanism's own parameters and outputs, and the inputs that its ports add."""

from mechid.exports.fmu.variables import INPUT, OUTPUT, PARAMETER, variables_of


def by_name(handover):
    variables = variables_of(handover)
    found = {v.name: v for v in variables}
    assert len(found) == len(variables) == len({v.number for v in variables})
    return found


def test_every_parameter_that_is_not_tied_can_be_set(of_paper):
    """Truth: the mechanism; the back-EMF constant follows the torque constant and is no variable."""
    own = of_paper.handover.mechanism
    found = by_name(of_paper.handover)
    free = [name for name in own.plant.declarations if not own.parameters[name].tied_to]
    assert [v.name for v in found.values() if v.variability == "tunable"] == free
    assert all(found[name].start == own.value(name) for name in free)
    assert "stepper.back_emf_constant" not in found
    places = {name: k for k, name in enumerate(own.plant.declarations)}
    assert all(found[name].number == PARAMETER + places[name] for name in free)


def test_units_are_as_fmi_writes_them(of_paper):
    """Truth: by hand; a full stop between factors, no caret, nothing for a plain number."""
    found = by_name(of_paper.handover)
    units = {name: found[name].unit for name in ("gear.stiffness", "load.inertia", "stepper.poles", "torque")}
    assert units == {"gear.stiffness": "N.m/rad", "load.inertia": "kg.m2", "stepper.poles": "", "torque": "N.m"}


def test_a_mechanism_without_ports_has_no_base(of_paper, at_rest):
    """Truth: the plants' inputs; the base and the outside torque are inputs of the one with ports alone."""
    open_, closed = by_name(of_paper.handover), by_name(at_rest)
    beside = {name for name in open_ if name not in closed}
    assert {"base_angle", "base_rate", "output_angle_inertial", "output_rate_inertial"} <= beside
    inputs = [v for v in open_.values() if v.number >= INPUT and v.causality == "input"]
    assert {v.name for v in inputs} <= {str(symbol) for symbol in of_paper.handover.mechanism.plant.inputs}
    outputs = [v.name for v in closed.values() if OUTPUT <= v.number < OUTPUT + len(at_rest.mechanism.plant.outputs)]
    assert outputs == list(at_rest.mechanism.plant.outputs)
