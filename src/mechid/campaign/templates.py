"""Templates of new files: a mechanism with catalogue values, and a campaign with one record per measured file."""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mechid.campaign.campaign import INSTANTS, USES
from mechid.campaign.campaign_file import FILE_NAME
from mechid.campaign.catalogue import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUES
from mechid.campaign.channel_entry import MODELLED
from mechid.campaign.mechanism_structure import ASSEMBLY
from mechid.campaign.mechanism_text import mechanism_text
from mechid.campaign.place import in_unit
from mechid.campaign.toml_file import toml_text
from mechid.campaign.unfinished_template import EXAMPLE_COMMAND, TEMPLATE
from mechid.command.entry import quote_words
from mechid.command.stepping import STARTS, STEPPINGS
from mechid.command.waveform import WAVEFORMS
from mechid.errors import MechidError, UsageError, did_you_mean
from mechid.locks import hold_folder
from mechid.parameter import Declaration
from mechid.plant.drive import measured_quantities
from mechid.plant.layout import STEPPER_GEAR_MASS
from mechid.plant.mechanism import Mechanism
from mechid.records import COMPONENTS, open_table
from mechid.records.columns import other_torque_column
from mechid.writing import creating_folder, write_atomically

MECHANISM_NAME = "mechanism.toml"
NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_-]+")
EMPTY = f"{{}}  # write how this record was driven, as {EXAMPLE_COMMAND}"
TEMPLATE_LINE = f"{TEMPLATE} = true  # delete this line when the numbers below are those of your mechanism\n\n"

PAPER = """the catalogue of the mechanism in
Kornienko, Wuseni, Specht (IFAC ACA 2013): write your supplier's in their place. Until the line
"template = true" is deleted the file is refused, and what is still the example's is named."""
MADE_UP = """made up,
of the size of a small mechanism: write your supplier's in their place. Until the line
"template = true" is deleted the file is refused, and what is still the example's is named."""
MECHANISM_GUIDE = """\
What is believed of the mechanism. The numbers are an example, WHOSE

A bare number is known. A table { value, min, max } is to be estimated, starting at value; a start on
a bound is legal. sigma = ... in the table is the standard deviation of a prior on the value.
Units are SI; a key that is not SI says so (_deg). Behind each number: symbol, unit, meaning."""

STAGE_GUIDE = """\
Without stages mechid plans its own. To steer it:

[[stage]]
records = ["full_46"]
window_s = [0.0, 0.3]                                 # s of record time; without it all of it
free = ["stepper.torque_constant", "gear.stiffness"]  # the others are held"""


@dataclass(frozen=True, kw_only=True)
class RecordDraft:
    """Draft of a ``[[record]]``.

    Parameters
    ----------
    name : str
    file : str
        Path in the campaign file.
    command : str
        The command in TOML notation; the default is empty and refused until it is filled in.
    use : str
        One of `USES`.
    channels : str
        Channels in TOML notation, which replace the command if measured channels drive the record.
    torque : str
        Column of the torque, if its position differs from the default.
    """

    name: str
    file: str
    command: str = EMPTY
    use: str = "estimate"
    channels: str = ""
    torque: str = ""


def new_campaign(folder: Path | str, files: Sequence[Path | str] = (), assembly: str = STEPPER_GEAR_MASS) -> list[Path]:
    """Write commented templates of a mechanism file and a campaign file.

    Parameters
    ----------
    folder : Path
        Created with its parents if missing.
    files : sequence of Path
        Measured files; each becomes a record. Without any, an example is written as a comment.
    assembly : str
        Assembly of the mechanism; one of the names in docs/blocks/assemblies.md.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    UsageError
        The assembly is unknown, one of the files exists already, or the folder is not writable.

    Examples
    --------
    >>> import mechid
    >>> [path.name for path in mechid.new_campaign("bench", ["full_46.csv"])]  # doctest: +SKIP
    ['mechanism.toml', 'campaign.toml']
    """
    if assembly not in CATALOGUES:
        hint = did_you_mean(assembly, CATALOGUES) or f"; known: {', '.join(CATALOGUES)}"
        raise UsageError(f'assembly: unknown "{assembly}"{hint}')
    folder, mechanism = Path(folder), catalogue_mechanism(assembly)
    texts = {
        folder / MECHANISM_NAME: new_mechanism_text(mechanism),
        folder / FILE_NAME: _new_text(folder, files, mechanism),
    }
    for path in texts:
        if path.exists():
            raise UsageError(f"{path}: already exists; give another folder, or move it away")
    with hold_folder(folder), creating_folder(folder):
        for path, content in texts.items():
            write_atomically(path, content)
    return list(texts)


def new_mechanism_text(mechanism: Mechanism) -> str:
    """Return the template of a mechanism file, refused until its mark is deleted."""
    whose = PAPER if mechanism.options[ASSEMBLY] == STEPPER_GEAR_MASS else MADE_UP
    guide, *rest = mechanism_text(mechanism, MECHANISM_GUIDE.replace("WHOSE", whose)).partition("\n\n")
    return "".join([guide, rest[0], TEMPLATE_LINE, *rest[1:]])


def campaign_text(
    records: Iterable[RecordDraft],
    header_comment: str = "",
    *,
    mechanism: str = MECHANISM_NAME,
    synthetic: bool = False,
) -> str:
    """Return the text of a campaign file with these records."""
    header = [*_comment(header_comment), ""] if header_comment else []
    lines = [*header, f"mechanism = {toml_text(mechanism)}", *(["synthetic = true"] if synthetic else [])]
    for record in records:
        lines += ["", *_record(record)]
    return "\n".join(lines) + "\n"


def drafts(folder: Path, files: Iterable[Path | str]) -> list[RecordDraft]:
    """Return a draft for each file, with a unique name derived from the file name."""
    used: set[str] = set()
    return [
        RecordDraft(name=_name(file, used), file=_relative(file, folder), torque=_torque(file))
        for file in map(Path, files)
    ]


def _torque(file: Path) -> str:
    """Return the torque column of a file if it is not in the default position; empty if it is, or for no file."""
    try:
        return other_torque_column(open_table(file, file.name)) or ""
    except (MechidError, OSError):
        # The file may be recorded later; if it is unreadable, mechid check reports the reason.
        return ""


def _new_text(folder: Path, files: Sequence[Path | str], mechanism: Mechanism) -> str:
    inputs, given = measured_quantities(mechanism.plant.inputs), [*mechanism.plant.offered]
    records, first = drafts(folder, files), RecordDraft(name="full_46", file="full_46.csv", command=EXAMPLE_COMMAND)
    if inputs:
        named = f"[{', '.join([_channel(given[0]), *(_channel(q, role='input') for q in inputs)])}]"
        records = [replace(record, channels=f"[]  # write which column is what, as {named}") for record in records]
        first = RecordDraft(name="run_1", file="run_1.csv", channels=named)
    example = [] if files else [first]
    commented = [line for record in example for line in ("", *_comment("\n".join(_record(record))))]
    ending = "\n".join([*commented, "", *_comment(STAGE_GUIDE)])
    return campaign_text(records, _campaign_guide()) + ending + "\n"


def _channel(quantity: str, **more: str) -> str:
    """Return a channel in TOML notation, with a placeholder for a missing column."""
    pairs = {"quantity": quantity, "column": "...", **more}
    return f"{{ {', '.join(f'{key} = {toml_text(value)}' for key, value in pairs.items())} }}"


def _campaign_guide() -> str:
    own = "\n".join(map(_own_line, INSTANTS))
    return f"""\
What was recorded, and how the motor was driven. Paths are relative to this file.

Each [[record]] has
  name           letters, digits, _ and -
  file           csv with one header line, time_s,torque_Nm; another unit in the header is converted
  command        a table of
    stepping         {quote_words(STEPPINGS)}; the last needs microsteps = 16 or the like
    rate             full steps/s, negative steps back; or instead of it
    rate_profile     [[0.0, 0.0], [60.0, 120.0]], times in s and full steps/s, or
    rate_table       "rate.csv", a file with the columns time_s,rate, or
    step_times       [0.1, 0.12], the instants of the steps in s, or "steps.csv" with the column time_s
    start_angle_deg  electrical angle that the coils hold before the first step; without it 0.0
    waveform         {quote_words(WAVEFORMS)}; without it the first
    table            "table.csv", the driver's own values of both phases, microstep,phase_a,phase_b
    start            {quote_words(STARTS)}; without it the first
    clock_tick_s     period of the driver's step clock, at whose ticks the steps come; without it 0.0, none
and may have
  use            {quote_words(USES)}: to be fitted, or only compared; without it the first
  offset         false keeps a constant part of the torque, which is removed otherwise
  drift          false keeps a linear part of the torque, which is removed otherwise
{own}
  sample_rate_hz where the file has no time column
  channels       [{{ quantity = "torque", column = "Mz", unit = "N*m", gain = -1.0 }}]; without it
                 the torque is the second column, or the first where sample_rate_hz is given; quantities:
                 {", ".join(MODELLED[:6])},
                 {", ".join(MODELLED[6:10])},
                 {", ".join(MODELLED[10:])};
                 of an output also use, offset, drift, quantisation = 1 (in the file's numbers), noise_sigma;
                 of a table beside the torque, see docs/six_components.md:
                 {", ".join(COMPONENTS)}
  time           {{ column = "Time", unit = "ms" }} where the time column is not found by its name
  peak_voltage   supply of this record alone; also peak_current; coil_resistance and temperature_rise where warmer
  test_stand     {{ transducer.gain = {{ value = 1.0, min = 0.8, max = 1.2 }} }}: of this record alone
  start_state    {{ rate = {{ value = 0.0, min = -2.0, max = 2.0 }} }}: with start = "estimated" in command, how far
                 off its start may be; without it of a size that the mechanism tells
  burn_in_s      time at its beginning that is simulated and does not count
  stretch_s      length of the stretches in which it is followed, each from a start of its own
  external_files names of other files that an HDF5 file may take its numbers from, as it has them
  conditioning   {{ window_s = [0.5, 20.0], decimate = 5 }}: what is done to the samples first; also
                 time_stamps, limits, max_gap_s, quiet_s; see docs/records.md"""


def _own_line(declaration: Declaration) -> str:
    unit = in_unit(declaration.unit)
    return f"  {declaration.key:<15}{declaration.meaning},{unit}; {{ value, min, max }} to estimate it"


def _record(record: RecordDraft) -> Iterator[str]:
    yield "[[record]]"
    yield f"name = {toml_text(record.name)}"
    yield f"file = {toml_text(record.file)}"
    if record.use != USES[0]:
        yield f"use = {toml_text(record.use)}"
    if record.torque and not record.channels:
        yield f"channels = [{_channel('torque', column=record.torque)}]  # by its name; else the second column counts"
    yield f"channels = {record.channels}" if record.channels else f"command = {record.command}"


def _comment(text: str) -> list[str]:
    return [f"# {line}".rstrip() for line in text.splitlines()]


def _name(file: Path, used: set[str]) -> str:
    """Return an unused record name for a file, and add it to the used ones."""
    letters = unicodedata.normalize("NFKD", file.stem).encode("ascii", "ignore").decode()
    plain = NOT_IN_NAMES.sub("_", letters).strip("_") or "record"
    name, count = plain, 2
    # Record names become file names, and some file systems ignore case.
    while name.casefold() in used:
        name, count = f"{plain}_{count}", count + 1
    used.add(name.casefold())
    return name


def _relative(file: Path, folder: Path) -> str:
    """Return the path relative to the folder; absolute if there is none, as between Windows drives."""
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:
        return file.absolute().as_posix()
