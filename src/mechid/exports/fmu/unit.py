"""Functional mock-up unit: mechanism with ports, sources, and the archive of each version."""

from __future__ import annotations

import hashlib
import platform
import sys
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import resources
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory

from mechid.errors import InputFileError
from mechid.exports.c.compiler import CompilerError, compile_sources
from mechid.exports.c.source import STEPS, Source
from mechid.exports.fmu.description import build_description, description_2, description_3
from mechid.exports.fmu.variables import POINTS, variables_of
from mechid.exports.handover import Handover
from mechid.exports.reference_outputs import sample_rate_hz, substeps
from mechid.exports.stand import select_mechanism, with_outputs
from mechid.parameter import Role
from mechid.plant.assembly import plant_of
from mechid.plant.flight import moving_base_objection, with_base
from mechid.plant.layout import Base, Flying
from mechid.plant.mechanism import Mechanism
from mechid.plant.mechanisms import exported_quantities
from mechid.plant.ports import Port

VERSIONS = ("2", "3")
# A fixed date gives the same bytes for the same fit.
FIXED_DATE = (1980, 1, 1, 0, 0, 0)
"""Date of all archive entries."""
PLATFORMS = {
    ("2", "linux"): "linux64",
    ("2", "darwin"): "darwin64",
    ("2", "win32"): "win64",
    ("3", "linux"): "linux",
    ("3", "darwin"): "darwin",
    ("3", "win32"): "windows",
}
ENDINGS = {"linux": ".so", "darwin": ".dylib", "win32": ".dll"}


def without_ports(handover: Handover, values: Mapping[str, float], *, stand: bool) -> Mechanism:
    """Return the mechanism of a unit on a base at rest, without external loads; it outputs all that it offers.

    Raises
    ------
    InputFileError
        No step command drives the mechanism, or a changed value is impossible.
    UsageError
        A parameter is unknown, or its value is impossible.
    """
    bench = handover.mechanism
    if bench.plant.layout is None or not set(STEPS) <= {s.name for s in bench.plant.inputs}:
        raise InputFileError(
            "a unit is commanded by steps, and this mechanism follows measured channels; write it with --to c, "
            "whose inputs are these channels"
        )
    mechanism = select_mechanism(bench, values, stand=stand)
    return with_outputs(mechanism, exported_quantities(mechanism.plant.offered))


def with_ports(mechanism: Mechanism, *, stand: bool) -> Mechanism:
    """Add external inputs to a mechanism: a torque on the output, and in flight the motion of the base."""
    on = mechanism
    if not stand and not moving_base_objection(mechanism):
        on = with_base(mechanism, Flying(base=Base.DRIVEN))
    assert on.plant.layout is not None
    plant = plant_of(replace(on.plant.layout, ports=frozenset({Port.OUTPUT})))
    whole = Mechanism(plant, {name: on.parameters[name] for name in plant.declarations}, on.options)
    return with_outputs(whole, list(mechanism.plant.outputs))


@dataclass(frozen=True, eq=False)
class Unit:
    """Sources and archives of a handover whose mechanism has its ports.

    Attributes
    ----------
    handover : Handover
    stop_s : float
        Duration of the default experiment.
    """

    handover: Handover
    stop_s: float

    @cached_property
    def source(self) -> Source:
        """The C source of the mechanism."""
        return Source(self.handover, 1.0 / sample_rate_hz(self.handover), substeps(self.handover))

    @cached_property
    def guid(self) -> str:
        """Identifier derived from the C source; importers refuse a description with another one."""
        digest = hashlib.sha256("".join(self.source.files.values()).encode()).hexdigest()
        return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"

    def sources(self, version: str) -> dict[str, str]:
        """Return the C sources of a version, by file name."""
        own = {name: self.source.files[name] for name in ("mechanism.h", "mechanism.c")}
        return own | {name: self._fill_template(name) for name in ("instance.c", f"fmi{version}.c")}

    def description(self, version: str) -> str:
        """Return modelDescription.xml of a version."""
        own = self.handover
        words = f"{own.mechanism.plant.name}, identified: {own.stands} {own.trust}"
        make = description_2 if version == "2" else description_3
        tool = f"mechid {own.provenance['mechid']}"
        return make(own.name, self.guid, words, tool, variables_of(own), self.stop_s)

    def _fill_template(self, name: str) -> str:
        plant = self.handover.mechanism.plant
        inputs, outputs = [s.name for s in plant.inputs], list(plant.outputs)
        peak = plant.names_with_role(Role.SUPPLY)
        text = resources.files("mechid.exports.fmu").joinpath(f"text/{name}.in").read_text(encoding="utf-8")
        return Template(text).substitute(
            {
                "title": f"{self.handover.name}: {plant.name}",
                "guid": self.guid,
                "points": POINTS,
                "inputs_held": max(len(inputs), 1),
                "e_A": inputs.index("e_A"),
                "e_B": inputs.index("e_B"),
                "peak": list(plant.declarations).index(peak[0]),
                "inertial": _inertial(outputs),
            }
        )

    def library(self, version: str, folder: Path) -> Path:
        """Compile the binary of a version for this platform into a folder.

        Raises
        ------
        CompilerError
            There is no compiler, or the compilation failed.
        """
        for name, text in self.sources(version).items():
            (folder / name).write_text(text, encoding="utf-8")
        sources = [folder / "mechanism.c", folder / f"fmi{version}.c"]
        flags = ("-shared", "-fPIC", "-fvisibility=hidden")
        return compile_sources(sources, folder / f"{self.handover.name}{ENDINGS.get(sys.platform, '.so')}", flags=flags)

    def write(self, version: str, path: Path) -> CompilerError | None:
        """Write the archive of a version; return the reason if it has no binary, else None."""
        entries = {"modelDescription.xml": self.description(version).encode()}
        entries |= {f"sources/{name}": text.encode() for name, text in self.sources(version).items()}
        if version == "3":
            entries["sources/buildDescription.xml"] = build_description(self.handover.name).encode()
        missing = None
        with TemporaryDirectory() as aside:
            try:
                library = self.library(version, Path(aside))
                entries[f"binaries/{_platform(version)}/{library.name}"] = library.read_bytes()
            except CompilerError as error:
                missing = error
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in entries.items():
                info = zipfile.ZipInfo(name, FIXED_DATE)
                # ZIP keeps Unix permissions in the upper 16 bits; without them extracted files may be unreadable.
                info.compress_type, info.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
                archive.writestr(info, content)
        return missing


def _platform(version: str) -> str:
    """Return the name of the binary folder for this machine."""
    system = PLATFORMS.get((version, sys.platform), sys.platform)
    if version == "2":
        return system
    # FMI 3.0 prescribes x86_64 and aarch64; Windows and macOS report other names.
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    return f"{machine}-{system}"


def _inertial(outputs: list[str]) -> str:
    """Return the C lines for angle and rate of the output in inertial space."""
    if not {"output_angle", "output_rate"} <= set(outputs):
        return ""
    pairs = (("V_ANGLE_INERTIAL", "output_angle", 0), ("V_RATE_INERTIAL", "output_rate", 1))
    return "\n".join(
        f"    }} else if (number == {name}) {{\n"
        f"        *value = of->s.m.output[{outputs.index(quantity)}] + of->s.base[{k}];"
        for name, quantity, k in pairs
    )
