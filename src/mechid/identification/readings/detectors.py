"""Detectors of wrong declarations, run in turn by `mechid check` and by the first step of `identify`.

To add a misreading, write a module with a detector and add the detector to `DETECTORS`.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace

from mechid.campaign import Campaign
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.output_error.declaration import Reading, reinterpret_problem
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.readings.file_values import find_wrong_counts
from mechid.identification.readings.finding import DeclaredRecords, Detector, Finding
from mechid.identification.readings.hum import find_hum
from mechid.identification.readings.misreading import confirm_rates, find_misreadings
from mechid.identification.readings.timing import find_timing
from mechid.identification.result.search_state import SearchState

DETECTORS: tuple[Detector, ...] = (find_misreadings, find_timing, find_wrong_counts, find_hum)
"""Detectors in the order of their lines; each receives the findings of those before it."""


def find_all(records: DeclaredRecords) -> tuple[Finding, ...]:
    """Return the findings of all detectors."""
    found: tuple[Finding, ...] = ()
    for detector in DETECTORS:
        found += tuple(detector(records, found))
    return found


def declaration_warnings(campaign: Campaign) -> tuple[str, ...]:
    """Return a line for each finding about a campaign, for `mechid check`."""
    targets = tuple(target_of(record) for record in campaign.estimated if record.data is not None)
    if not campaign.mechanism.free or not targets:
        return ()
    problem = Problem(SearchSpace(campaign.mechanism), targets, workers=os.cpu_count() or 1)
    with one_core_algebra():
        return tuple(finding.line() for finding in find_all(DeclaredRecords(campaign, problem)))


def apply_findings(campaign: Campaign, state: SearchState, seed: int) -> tuple[Campaign, SearchState]:
    """Add the findings to the campaign's warnings, and apply the confirmed readings to the state's records.

    With stages of the user's own, the records are read as declared.
    """
    records = DeclaredRecords(campaign, state.problem, seed, before_search=True)
    found = find_all(records)
    if not found:
        return campaign, state
    # The comparison takes further searches: it runs only where a confirmed rate would be applied.
    found = found if campaign.stages else confirm_rates(records, found)
    used = [] if campaign.stages else [one for one in found if one.is_confirmed and one.reading]
    readings = _merge_readings(used)
    problem = reinterpret_problem(state.problem, readings)
    state = replace(state, problem=problem, q=problem.start, windows=problem.whole_windows(), readings=readings)
    lines = (finding.line(used=finding in used) for finding in found)
    return replace(campaign, warnings=(*lines, *campaign.warnings)), state


def _merge_readings(findings: Iterable[Finding]) -> dict[str, Reading]:
    return {name: reading for one in findings for name, reading in one.reading.items()}
