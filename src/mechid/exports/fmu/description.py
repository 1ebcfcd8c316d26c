"""modelDescription.xml for FMI 2.0 and 3.0."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree as ET

from mechid.exports.fmu.variables import Variable

BASE = {
    "s": "s=1",
    "1/s": "s=-1",
    "rad": "rad=1",
    "rad/s": "rad=1 s=-1",
    "rad/s2": "rad=1 s=-2",
    "N.m": "kg=1 m=2 s=-2",
    "N": "kg=1 m=1 s=-2",
    "m": "m=1",
    "m/s": "m=1 s=-1",
    "A": "A=1",
    "V": "kg=1 m=2 s=-3 A=-1",
    "Hz": "s=-1",
    "ohm": "kg=1 m=2 s=-3 A=-2",
    "H": "kg=1 m=2 s=-2 A=-2",
    "kg.m2": "kg=1 m=2",
    "kg": "kg=1",
    "N.m/rad": "kg=1 m=2 s=-2 rad=-1",
    "N.m.s": "kg=1 m=2 s=-1",
    "N.m.s/rad": "kg=1 m=2 s=-1 rad=-1",
    "N.m/A": "kg=1 m=2 s=-2 A=-1",
    "V.s": "kg=1 m=2 s=-2 A=-1",
    "V.s/rad": "kg=1 m=2 s=-2 A=-1 rad=-1",
}
"""SI base units of units; other units are declared by name only."""
ABLE_2 = {
    "canHandleVariableCommunicationStepSize": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "canNotUseMemoryManagementFunctions": "true",
}
ABLE_3 = {
    "canHandleVariableCommunicationStepSize": "true",
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "hasEventMode": "true",
}


def description_2(name: str, guid: str, words: str, tool: str, variables: Sequence[Variable], stop_s: float) -> str:
    """Return modelDescription.xml of FMI 2.0, which has no independent variable and counts outputs from 1."""
    # FMI 2.0 has no independent variable.
    shown = [v for v in variables if v.causality != "independent"]
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": name,
            "guid": guid,
            "description": words,
            "generationTool": tool,
            "variableNamingConvention": "flat",
            "numberOfEventIndicators": "0",
        },
    )
    unit = ET.SubElement(root, "CoSimulation", {"modelIdentifier": name, **ABLE_2})
    files = ET.SubElement(unit, "SourceFiles")
    for file in ("mechanism.c", "fmi2.c"):
        ET.SubElement(files, "File", {"name": file})
    _units(root, shown)
    _categories(root)
    ET.SubElement(root, "DefaultExperiment", {"startTime": "0.0", "stopTime": repr(stop_s)})
    table = ET.SubElement(root, "ModelVariables")
    for v in shown:
        entry = ET.SubElement(table, "ScalarVariable", {**_common(v), "valueReference": str(v.number)})
        ET.SubElement(entry, "Integer" if v.whole else "Real", _value(v))
    structure = ET.SubElement(root, "ModelStructure")
    # FMI 2.0 refers to variables by their position, FMI 3.0 by their value reference.
    outputs = [str(k) for k, v in enumerate(shown, start=1) if v.causality == "output"]
    for part in ("Outputs", "InitialUnknowns"):
        group = ET.SubElement(structure, part)
        for index in outputs:
            ET.SubElement(group, "Unknown", {"index": index})
    return _text(root)


def description_3(name: str, token: str, words: str, tool: str, variables: Sequence[Variable], stop_s: float) -> str:
    """Return modelDescription.xml of FMI 3.0."""
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "3.0",
            "modelName": name,
            "instantiationToken": token,
            "description": words,
            "generationTool": tool,
            "variableNamingConvention": "flat",
        },
    )
    ET.SubElement(root, "CoSimulation", {"modelIdentifier": name, **ABLE_3})
    _units(root, variables)
    _categories(root)
    ET.SubElement(root, "DefaultExperiment", {"startTime": "0.0", "stopTime": repr(stop_s)})
    table = ET.SubElement(root, "ModelVariables")
    for v in variables:
        kind = "Int32" if v.whole else "Float64"
        ET.SubElement(table, kind, {**_common(v), "valueReference": str(v.number), **_value(v)})
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [str(v.number) for v in variables if v.causality == "output"]
    for part in ("Output", "InitialUnknown"):
        for number in outputs:
            ET.SubElement(structure, part, {"valueReference": number})
    return _text(root)


def build_description(name: str) -> str:
    """Return sources/buildDescription.xml of FMI 3.0."""
    root = ET.Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = ET.SubElement(root, "BuildConfiguration", {"modelIdentifier": name})
    files = ET.SubElement(configuration, "SourceFileSet", {"language": "C99"})
    for file in ("mechanism.c", "fmi3.c"):
        ET.SubElement(files, "SourceFile", {"name": file})
    return _text(root)


def _common(v: Variable) -> dict[str, str]:
    own = {"name": v.name, "causality": v.causality, "variability": v.variability, "description": v.description}
    if v.causality == "parameter":
        own["initial"] = "exact"
    return own


def _value(v: Variable) -> dict[str, str]:
    own = {} if v.start is None else {"start": repr(v.start)}
    if v.unit:
        own["unit"] = v.unit
    if v.nominal > 0.0:
        own["nominal"] = repr(v.nominal)
    return own


def _units(root: ET.Element, variables: Iterable[Variable]) -> None:
    units = ET.SubElement(root, "UnitDefinitions")
    for name in sorted({v.unit for v in variables} - {""}):
        unit = ET.SubElement(units, "Unit", {"name": name})
        if name in BASE:
            ET.SubElement(unit, "BaseUnit", dict(re.findall(r"(\w+)=(-?\d+)", BASE[name])))
        elif name == "deg":
            ET.SubElement(unit, "BaseUnit", {"rad": "1", "factor": "0.017453292519943295"})


def _categories(root: ET.Element) -> None:
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", {"name": "error", "description": "what is wrong, and what to do"})


def _text(root: ET.Element) -> str:
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"
