"""modelDescription.xml. Truth: the mechanism file's names and values, and the rules of the standards."""

from xml.etree import ElementTree as ET

import pytest

from mechid.exports.fmu.description import build_description
from mechid.exports.fmu.variables import variables_of


@pytest.fixture(params="23")
def described(request, of_paper):
    """Return the version, the root of its description, and its variables by name."""
    root = ET.fromstring(of_paper.description(request.param))
    return request.param, root, {entry.get("name"): entry for entry in root.find("ModelVariables")}


def test_it_names_every_parameter(described, of_paper):
    """Truth: the mechanism file's names, values, units, and the standard errors of the estimate."""
    version, root, found = described
    own = of_paper.handover
    assert root.get("fmiVersion") == f"{version}.0"
    numbers = [entry.get("valueReference") for entry in found.values()]
    assert len(set(numbers)) == len(numbers) >= len(own.mechanism.plant.declarations)
    units = {entry.get("name") for entry in root.find("UnitDefinitions")}
    for variable in variables_of(own):
        if variable.causality == "independent" and version == "2":
            continue
        assert not variable.unit or variable.unit in units
        assert found[variable.name].get("causality") == variable.causality
    name = "gear.stiffness"
    value = found[name][0] if version == "2" else found[name]
    assert float(value.get("start")) == own.mechanism.value(name)
    assert f"standard error {own.std_error(name):.6g}" in found[name].get("description")


def test_its_structure_lists_the_outputs(described):
    """Truth: FMI 2.0 counts variables from 1 in their order, FMI 3.0 names value references."""
    version, root, found = described
    outputs = [
        (str(k), entry.get("valueReference"))
        for k, entry in enumerate(found.values(), start=1)
        if entry.get("causality") == "output"
    ]
    structure = root.find("ModelStructure")
    if version == "2":
        assert [entry.get("index") for entry in structure.find("Outputs")] == [index for index, _ in outputs]
    else:
        assert [entry.get("valueReference") for entry in structure.findall("Output")] == [n for _, n in outputs]
    assert outputs


def test_only_what_is_set_has_a_start(described):
    """Truth: the standards; an output that is calculated has none, a parameter and an input have one."""
    version, _, found = described
    for entry in found.values():
        start = (entry[0] if version == "2" else entry).get("start")
        assert (start is None) == (entry.get("causality") in ("output", "independent")), entry.get("name")


def test_the_sources_of_a_unit_are_named():
    """Truth: the files that a unit for FMI 3.0 has."""
    root = ET.fromstring(build_description("paper"))
    assert root.find("BuildConfiguration").get("modelIdentifier") == "paper"
    assert {file.get("name") for file in root.iter("SourceFile")} == {"mechanism.c", "fmi3.c"}
