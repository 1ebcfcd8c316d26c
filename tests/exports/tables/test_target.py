"""The tables of an export: against long simulations, differences, closed forms, other readers of the files."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from flown import FULL, simulated
from layouts import changed, mechanism_of, paper_table
from mechid.analysis.residual_emission import CENTRES_HZ, TRACKED
from mechid.analysis.residual_file import FILE_NAME, FORMAT
from mechid.budgets.steady_state import enough_substeps, steady_state
from mechid.command import Command, RateProfile
from mechid.errors import InputFileError, UsageError
from mechid.exports.document import PAGES
from mechid.exports.export import write_export
from mechid.exports.forcing import estimate_on_base, forcing
from mechid.exports.handover import Trial
from mechid.exports.stepping import choose_rates, steppings
from mechid.exports.tables.check import compare_directly, refuse_difference
from mechid.exports.tables.csv_file import read_csv, write_csv
from mechid.exports.tables.forcing_tables import forcing_tables
from mechid.exports.tables.options import Options
from mechid.exports.tables.table import Table, numbers, texts
from mechid.plant.flight import to_flight, with_line_filter
from mechid.simulation.resonances import resonances
from mechid.simulation.simulator import TimeBase

RIGID = {"housing": None, "stepper": {"back_emf_constant": None}}
SECOND = TimeBase(10_000.0, 10_001)


def rows(folder, name):
    """Return a table's rows as a spreadsheet's user reads them."""
    with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def lines_at(folder, stepping, rate):
    return [r for r in rows(folder, "lines") if r["stepping"] == stepping and float(r["rate_steps_per_s"]) == rate]


def column(found, name):
    return np.array([float(r[name]) for r in found])


def test_lines_are_those_of_a_long_simulation_of_the_bench(tables):
    """Truth: the bench's own plant without its housing, 3 s from rest at 400 and 800 kHz; no shooting, no filter."""
    found = [r for r in lines_at(tables.folder, "full", 46.0) if float(r["amplitude_Nm"]) > 1e-3]
    frequency = column(found, "frequency_Hz")
    bench, period_s, skipped, times = mechanism_of(changed(paper_table(), RIGID)), 2.0 / 46.0, 60, 9
    ways = []
    for rate_hz in (400_000.0, 800_000.0):
        each = 2 * math.ceil(0.5 * period_s * rate_hz)
        late_s = 0.5 * period_s / each
        torque = simulated(bench, FULL, (skipped + times) * period_s, each / period_s, late_s)
        last = torque[skipped * each : (skipped + times) * each]
        bins = np.round(frequency * period_s * times).astype(int)
        ways.append(2.0 / last.size * np.fft.rfft(last)[bins] * np.exp(-2j * np.pi * frequency * late_s))
    expected = 2.0 * ways[1] - ways[0]
    line = column(found, "amplitude_Nm") * np.exp(1j * np.radians(column(found, "phase_deg")))
    assert len(found) >= 10
    np.testing.assert_allclose(line / expected, 1.0, atol=1e-4)


def test_sigmas_are_those_of_the_covariance(paper):
    """Truth: differences of the lines over a fifth of each parameter's standard error, through the covariance."""
    estimate = estimate_on_base(paper)
    one = forcing(estimate, steppings(paper.trials)[0], np.array([46.0]))
    table = forcing_tables((one,), estimate)[0].numeric
    loud = np.flatnonzero(table["amplitude_Nm"] > 0.01)
    substeps = enough_substeps(estimate.mechanism, one.mode, estimate.names)

    def lines(name, by):
        moved = estimate.mechanism.with_values({name: estimate.mechanism.value(name) + by})
        return steady_state(moved, one.mode, 46.0, estimate.names, substeps).lines[loud]

    steps = 0.1 * np.sqrt(np.diag(estimate.covariance))
    pairs = zip(estimate.names, steps, strict=True)
    slopes = np.array([(lines(name, step) - lines(name, -step)) / (2.0 * step) for name, step in pairs])
    own = slopes / np.exp(1j * np.radians(table["phase_deg"][loud]))
    along, across = (
        np.sqrt(np.einsum("in,ij,jn->n", part, estimate.covariance, part)) for part in (own.real, own.imag)
    )
    assert loud.size > 3
    np.testing.assert_allclose(table["sigma_Nm"][loud], along, rtol=0.01)
    np.testing.assert_allclose(
        table["phase_sigma_deg"][loud], np.degrees(across / table["amplitude_Nm"][loud]), rtol=0.01
    )


def left(fit, order, amplitude):
    """Return residual.json of a fit whose records have one line that the model lacks, at six rates near 46."""
    sizes = [amplitude if q == order else 1e-6 for q in TRACKED]
    at = {
        "windows": 1,
        "duration_s": 1.0,
        "amplitude": sizes,
        "sigma": [1e-6] * len(TRACKED),
        "density": [0.0] * CENTRES_HZ.size,
    }
    record = {"stepping": "full", "microsteps": 1, "noise_sigma": 1e-6, "sample_rate_hz": 1e4}
    record["rates"] = [{"rate": rate, **at} for rate in (44.0, 45.0, 46.0, 47.0, 48.0, 49.0)]
    return {
        "format": FORMAT,
        "orders": list(TRACKED),
        "band_centres_hz": CENTRES_HZ.tolist(),
        "records": {"full_46": record},
        "provenance": fit.provenance,
    }


def test_a_line_that_the_model_lacks_is_in_its_bound(paper, tmp_path):
    """Truth: |E|^2 / A^2 of a complex Gaussian whose size n rates tell is F(2, 2 n) distributed; here n = 6."""
    (tmp_path / FILE_NAME).write_text(json.dumps(left(paper.fit, 0.25, 5e-3)), encoding="utf-8")
    estimate = estimate_on_base(replace(paper, fit=replace(paper.fit, folder=tmp_path)))
    one = forcing(estimate, steppings(paper.trials)[0], np.array([46.0]))
    table = forcing_tables((one,), estimate)[0].numeric
    (at,) = np.flatnonzero(table["order"] == 0.25)
    ratio = estimate.residual.bench_to_flight.ratio(np.array([11.5]))[0]
    assert table["residual_Nm"][at] == pytest.approx(5e-3 * ratio, rel=1e-3)
    quantile = math.sqrt(stats.f.ppf(0.95, 2, 12))
    assert table["bound_Nm"][at] == pytest.approx(5e-3 * ratio * quantile, rel=0.15)  # of 200 draws
    assert table["amplitude_Nm"][at] == 0.0
    assert np.isnan(table["phase_deg"][at])


def test_what_is_left_of_another_fit_is_refused(paper, tmp_path):
    """Truth: the digests of another fit's inputs."""
    other = left(paper.fit, 0.25, 5e-3) | {"provenance": {"seed": 99}}
    (tmp_path / FILE_NAME).write_text(json.dumps(other), encoding="utf-8")
    with pytest.raises(InputFileError, match=r"residual\.json: is of another fit"):
        estimate_on_base(replace(paper, fit=replace(paper.fit, folder=tmp_path)))


def test_time_histories_are_simulated_at_the_estimated_values(tables):
    """Truth: the bench's own simulation at 10 kHz, as `mechid simulate` runs it, and momentum without the housing."""
    found = rows(tables.folder, "history_full_46")
    assert list(found[0]) == ["time_s", "torque_Nm", "base_torque_Nm"]
    bench = mechanism_of(changed(paper_table(), {"stepper": {"back_emf_constant": None}}))
    rigid = mechanism_of(changed(paper_table(), RIGID))
    for mechanism, name in ((bench, "torque_Nm"), (rigid, "base_torque_Nm")):
        expected = simulated(mechanism, FULL, 0.2, 10_000.0)
        off = column(found, name) - expected
        assert np.sqrt(np.mean(off**2)) < 2e-3 * np.sqrt(np.mean(expected**2))  # it takes one step a sample
    np.testing.assert_allclose(column(found, "time_s"), np.arange(2001) / 1e4, rtol=1e-12)


def test_the_covariance_is_that_of_the_estimate(tables):
    """Truth: standard errors of half a percent and one correlation of 0.9, as the estimate was made."""
    covariance = {r["parameter"]: r for r in rows(tables.folder, "covariance")}
    correlation = {r["parameter"]: r for r in rows(tables.folder, "correlation")}
    values = {r["parameter"]: float(r["value"]) for r in rows(tables.folder, "parameters")}
    for name, row in covariance.items():
        assert float(row[name]) == pytest.approx((0.005 * values[name]) ** 2)
    pair = "stepper.coil_resistance", "stepper.torque_constant"
    assert float(correlation[pair[0]][pair[1]]) == pytest.approx(0.9)
    assert float(covariance[pair[0]][pair[1]]) == pytest.approx(0.9 * 0.005**2 * values[pair[0]] * values[pair[1]])


def test_the_workbook_holds_the_same_as_the_csv_files(tables):
    """Truth: another library's reader."""
    book = pytest.importorskip("openpyxl").load_workbook(tables.folder / "tables.xlsx", read_only=True)
    assert book.sheetnames == [
        "parameters",
        "covariance",
        "correlation",
        "records",
        "lines",
        "bands",
        "rates",
        "provenance",
        "columns",
    ]
    for sheet in book:
        head, *cells = sheet.iter_rows(values_only=True)
        found = rows(tables.folder, sheet.title)
        assert list(head) == list(found[0])
        assert len(cells) == len(found)
        for row, expected in zip(cells, found, strict=True):
            for cell, text in zip(row, expected.values(), strict=True):
                same = str(cell or "") == text if isinstance(cell, str | None) else cell == pytest.approx(float(text))
                assert same, (sheet.title, cell, text)
    book.close()


def test_the_hdf5_file_has_every_column_with_its_unit(tables):
    """Truth: the CSV files, and the table of columns."""
    file = pytest.importorskip("h5py").File(tables.folder / "tables.h5")
    with file:
        for row in rows(tables.folder, "columns"):
            made = file[row["table"]][row["column"]]
            assert made.attrs["unit"] == row["unit"]
        amplitude = file["lines"]["amplitude_Nm"][...]
        assert json.loads(file.attrs["provenance"])["grade"] == "A"
    np.testing.assert_allclose(amplitude, column(rows(tables.folder, "lines"), "amplitude_Nm"), rtol=1e-11)


def test_what_was_checked_is_said(tables):
    """Truth: mechid_export.json; lines agree with a direct simulation to 1e-6 of the largest."""
    done = json.loads((tables.folder / "mechid_export.json").read_text(encoding="utf-8"))
    largest = column(rows(tables.folder, "lines"), "amplitude_Nm").max()
    assert "full at 46 steps/s" in done["checked"]["against"]
    assert 0.0 < done["checked"]["largest_error"] < 1e-6 * largest
    assert sorted(p.name for p in tables.folder.iterdir()) == sorted([*done["files"], *PAGES, "mechid_export.json"])
    assert any("residual.json" in line for line in done["words"])
    assert any(line.startswith("Left on the bench: [housing]") for line in done["words"])


def test_the_check_finds_lines_that_are_wrong(paper):
    """Truth: a line made 1 % larger."""
    estimate = estimate_on_base(paper)
    one = forcing(estimate, steppings(paper.trials)[0], np.array([46.0]))
    lined = with_line_filter(estimate.mechanism, 2.0 * math.pi * one.mode.highest_hz)
    state = one.states[0][0]
    lines = state.lines.copy()
    lines[1] *= 1.01
    lanes = len(estimate.names) + len(lined.plant.states)
    found = compare_directly(lined, lanes, replace(one, states=((replace(state, lines=lines),),)))
    assert np.abs(found.off).max() == pytest.approx(0.01 * abs(state.lines[1]), rel=1e-3)


def test_a_file_that_holds_other_numbers_is_refused(tmp_path):
    """Truth: a digit changed behind the back of the check."""
    table = Table("t", (texts("name", "", ["a", "b"]), numbers("x_Nm", "N m", "", [1.25, None])))
    write_csv(table, tmp_path)
    refuse_difference(tmp_path / "t.csv", table.numeric, read_csv(table, tmp_path))
    path = tmp_path / "t.csv"
    path.write_text(path.read_text(encoding="utf-8").replace("1.25", "1.26"), encoding="utf-8")
    with pytest.raises(UsageError, match=r"t\.csv: column x_Nm holds other numbers"):
        refuse_difference(path, table.numeric, read_csv(table, tmp_path))


def test_ways_of_stepping_are_told_apart_by_what_they_do():
    """Truth: by hand. Whole steps of the start angle make no difference, half ones in full stepping do."""

    def trial(name, stepping, microsteps, angle, *points):
        rate = RateProfile.through(points)
        command = Command(stepping=stepping, microsteps=microsteps, rate=rate, start_angle_deg=angle)
        return Trial(name, command, SECOND)

    found = steppings(
        (
            trial("a", "full", 1, 45.0, (0.0, 46.0)),
            trial("b", "full", 1, 135.0, (0.0, -92.0)),
            trial("c", "full", 1, 0.0, (0.0, 20.0)),
            trial("d", "micro", 16, 45.0, (0.0, 0.0), (2.0, 100.0)),
            trial("e", "half", 2, 0.0, (0.0, 0.0)),
        )
    )
    assert [(s.name, s.ranges) for s in found] == [
        ("full_45deg", ((46.0, 46.0), (92.0, 92.0))),
        ("full_0deg", ((20.0, 20.0),)),
        ("micro16", ((0.0, 50.0),)),
    ]
    tested = found[0].covers(np.array([45.9, 46.0, 92.0]))
    assert tested.tolist() == [False, True, True]


def test_the_usual_rates_span_the_campaign_and_stand_where_orders_meet_a_resonance(paper):
    """Truth: the resonance of the load on its gear, 46.9 Hz; the sweep's range, 0 to 60 steps/s."""
    mechanism = estimate_on_base(paper).mechanism
    rates = choose_rates(mechanism, steppings(paper.trials))
    (load,) = resonances(mechanism)
    assert (rates[0], rates[-1]) == (60.0 / 24.0, 60.0)
    assert 46.0 in rates
    apart = np.diff(rates)
    for order in np.arange(1, 17) / 2.0:
        inside = np.abs(rates[:-1] * order / load.frequency_hz - 1.0) < load.damping
        assert np.all(apart[inside] <= 0.3001 * load.damping * rates[:-1][inside])
    assert apart.max() <= 57.5 / 40.0 + 1e-9
    assert apart.min() > 0.0


def test_many_narrow_resonances_do_not_ask_for_endless_rates():
    """Truth: the number; modes of 0.1 % damping, each met by many orders."""
    modes = [{"frequency": w, "damping": 0.001, "inertia": 1e-3} for w in (60.0, 150.0)]
    mechanism = to_flight(mechanism_of(changed(paper_table(), {"load": {"mode": modes}})))
    command = Command(stepping="full", microsteps=1, rate=RateProfile.through([(0.0, 5.0), (1.0, 120.0)]))
    rates = choose_rates(mechanism, steppings([Trial("a", command, SECOND)]))
    assert len([r for r in resonances(mechanism) if r.damping < 0.01]) == 2
    assert 100 < rates.size <= 300


def test_without_a_step_command_there_are_no_lines(paper, tmp_path):
    """Truth: the list of files."""
    done = write_export(replace(paper, trials=()), "tables", tmp_path)
    assert done.written.checked is None
    assert "parameters.csv" in done.written.files
    assert not {"lines.csv", "lines.bdf"} & set(done.written.files)
    assert any("no lines, no time histories" in line for line in done.written.words)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"rate": "23"}, 'found "rate"; did you mean "rates"'),
        ({"rates": "23,x"}, 'rates: found "x"; write numbers'),
        ({"rates": "23,-4"}, "rates: found -4; write full steps/s from 0.02 to 100000, 2000 at most"),
        ({"rates": "nan"}, "rates: found nan; write full steps/s from 0.02"),
        ({"rates": ",".join(map(str, range(1, 2102)))}, "rates: found 2101 of them; write"),
        ({"node": "1.5"}, 'node: found "1.5"; write a whole number'),
        ({"node": "0"}, "node: found 0; write a whole number from 1"),
        ({"component": "7"}, "component: found 7; write a whole number from 4 to 6"),
        ({"scale": "0"}, "scale: found 0; write the model's torque units in 1 N m"),
        ({"first_id": "999999999"}, "first_id: found 999999999"),
    ],
)
def test_options_that_cannot_be_are_refused(given, said):
    """Truth: the sentence that names option, value and remedy."""
    with pytest.raises(UsageError) as error:
        Options.read(given)
    assert said in str(error.value)
