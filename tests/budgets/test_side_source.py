"""Six components through a structure: the sum against NumPy, what counts without a phase, its errors."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mechid.analysis.components_file import SideRecords
from mechid.analysis.residual_emission import TRACKED
from mechid.budgets.line_of_sight import respond
from mechid.budgets.side_here import COHERENT, MAGNITUDE, WITHIN
from mechid.budgets.side_response import side_response
from mechid.budgets.side_source import SideSource
from mechid.command import Command, RateProfile
from mechid.errors import InputFileError
from mechid.records import COMPONENTS, Mounting
from mechid.structure import Location, Modes, Selection, Structure, read_structure
from states_by_hand import state_by_hand
from table_of_six import MEASURED, side_records

MICRO = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(1.0))
FRAME = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""The bench's x is the structure's y."""
DRIVE = {0.5: 0.04 * np.exp(0.4j), 1.0: 0.1 * np.exp(-2.0j), 2.0: 0.03}
HIGHEST_HZ = 500.0


def exerted(rate):
    """Return what the mechanism exerts at its mounting point at a rate, by component and order."""
    return {
        "moment_z": DRIVE,
        "force_x": {1.0: 0.5 * (rate / 10.0) ** 2 * np.exp(1.0j)},
        "force_y": {1.0: 0.2 * np.exp(2.5j), 2.0: 0.1j},
        "force_z": {2.0: 0.05},
        "moment_x": {0.5: 0.01, 1.0: 0.02j},
        "moment_y": {1.0: 0.015 * np.exp(-1.0j)},
    }


def steady(rate, drive=None, error=1e-9):
    """Return a steady state of known lines of the torque, their phases turned as those of another start are."""
    drive = DRIVE if drive is None else drive
    orders = np.array([round(2 * q) for q in drive])
    turned = np.exp(2j * np.pi * 0.3 * np.array(list(drive)))
    return state_by_hand(
        rate,
        orders,
        np.array(list(drive.values())) * turned,
        error=np.full(orders.size, error),
        sample_rate_hz=1e4,
        samples_a_period=1e3,
        rms=0.1,
    )


def wrench(rate, order):
    """Return the six components along the structure's axes at an order, about the mounting point, N and N m."""
    at = exerted(rate)
    bench = np.array([at.get(name, {}).get(order, 0.0) for name in COMPONENTS])
    return np.concatenate([FRAME @ bench[:3], FRAME @ bench[3:]])


def along(rng, n=4):
    """Return a modal structure with six directions and two lines of sight, drawn."""
    shapes = dict(zip(("tx", "ty", "tz", "rx", "ry", "rz"), rng.normal(size=(6, n)) * 0.1, strict=True))
    modes = Modes(
        np.array([0.05, 7.0, 11.0, 23.0]),
        np.array([0.7, 0.01, 0.01, 0.02]),
        shapes["rz"],
        0.1 * rng.normal(size=(2, n)),
    )
    others = {d: replace(modes, interface=shape) for d, shape in shapes.items() if d != "rz"}
    return Structure(name="s", line_of_sight=("x", "y"), model=modes, axis="rz", directions=others)


STRUCTURE = along(np.random.default_rng(5))


def response(source, rate, state=None, command=MICRO):
    state = steady(rate) if state is None else state
    return respond(
        state, source.structure, None, HIGHEST_HZ, side_response(state, source, source.at(command, rate), HIGHEST_HZ)
    )


@cache
def measured(rates, seed, noise, seconds):
    return side_records(exerted, rates, np.random.default_rng(seed), noise=noise, seconds=seconds)


def source_of(structure=STRUCTURE, rates=(9.5, 10.0, 10.5), seed=0, frame=FRAME, noise=1e-6, seconds=4.0):
    return SideSource(measured(rates, seed, noise, seconds), frame, structure)


@pytest.mark.data
def test_the_coherent_sum_on_a_craig_bampton_model(data_folder):
    """Truth: NumPy's solution of the equations of motion under all six components at once, each with its phase.

    The bench's axes are turned to the structure's, its moments moved from the table to the mounting point; the model is
    in mm and kg, its damping 1 % modal. A measured line is off by its noise: 1e-3 of it at most here.
    """
    with np.printoptions():
        pytest.importorskip("pyyeti.nastran")
    from pyyeti.nastran import op4

    path = data_folder / "craig_bampton" / "cla_test_data_2020" / "outboard.op4"
    lines = {"tilt": (Location(27, "rx"),), "shift": (Location(11, "ty", 0.5), Location(19, "rz"))}
    selection = Selection(interface=Location(3, "rz"), line_of_sight=lines, damping=0.01, length_unit_m=1e-3)
    found = response(source_of(read_structure(path, selection)), 10.0)
    content = op4.read(str(path))
    K, M = content["kxx"], content["mxx"]
    root = np.linalg.inv(np.linalg.cholesky(M))
    values, shapes = np.linalg.eigh(root @ K @ root.T)
    phi, w_k = root.T @ shapes, np.sqrt(np.where(np.arange(len(K)) < 6, 0.0, values))
    C = M @ phi @ np.diag(2.0 * 0.01 * w_k) @ phi.T @ M
    for k, order in enumerate(DRIVE):
        w = 2.0 * np.pi * 10.0 * order
        push = np.zeros(len(K), dtype=complex)
        push[:6] = wrench(10.0, order) * np.repeat([1e3, 1e6], 3) * np.exp(2j * np.pi * 0.3 * order)
        u = np.linalg.solve(K - w**2 * M + 1j * w * C, push)
        wanted = np.array([u[18 + 3], 0.5e-3 * u[6] + u[12 + 5]])
        np.testing.assert_allclose(found.phasors[k], wanted, rtol=1e-3)
        assert np.abs(found.drive[k] / wanted - 1.0).max() > 0.05  # without the others it is another sum


def test_the_sum_of_modes_written_out():
    """Truth: the sum over modes and components, with NumPy."""
    found = response(source_of(), 10.0)
    shapes = np.array([STRUCTURE.directions[d].interface for d in ("tx", "ty", "tz", "rx", "ry")])
    shapes = np.vstack([shapes, STRUCTURE.model.interface])
    wk, zeta = 2.0 * np.pi * STRUCTURE.model.frequency_hz, STRUCTURE.model.damping
    for k, order in enumerate(DRIVE):
        w = 2.0 * np.pi * 10.0 * order
        modal = wrench(10.0, order) @ shapes / (wk**2 - w**2 + 2j * zeta * wk * w)
        wanted = STRUCTURE.model.line_of_sight @ modal * np.exp(2j * np.pi * 0.3 * order)
        np.testing.assert_allclose(found.phasors[k], wanted, rtol=2e-3)


def test_between_two_rates_a_line_is_known_to_what_they_differ_by():
    """Truth: the force that grows with the rate squared, and the steady one, at a rate that no record has."""
    here = source_of().at(MICRO, 10.2)
    k = TRACKED.index(1.0)
    for name in ("force_x", "force_y"):
        j, true = MEASURED.index(name), exerted(10.2)[name][1.0] / np.exp(1j * np.angle(DRIVE[1.0]))
        assert abs(here.lines[k, j] - true) < 2.0 * here.sigma[k, j] + 1e-4
    at_bench = source_of().at(MICRO, 10.0)
    grows, steady_one = MEASURED.index("force_x"), MEASURED.index("force_y")
    assert here.sigma[k, grows] > 100.0 * at_bench.sigma[k, grows]
    assert here.sigma[k, steady_one] < 0.01 * abs(here.lines[k, steady_one])


def test_what_has_no_phase_is_a_bound():
    """Truth: no sum of the same magnitudes, in whatever phases, is larger; one in the worst phases is as large."""
    source = source_of()
    here = source.at(MICRO, 10.0)
    state = steady(10.0)
    loose = side_response(state, source, here.without_phases(), HIGHEST_HZ)
    bound = np.abs(loose.add_to(STRUCTURE.to_line_of_sight(state.frequency_hz) * state.lines[:, None]))
    rng, transfer = np.random.default_rng(2), source.transfer(state.frequency_hz)
    drive = STRUCTURE.to_line_of_sight(state.frequency_hz) * state.lines[:, None]
    sizes = np.abs(here.lines[[TRACKED.index(q) for q in DRIVE]])
    largest = np.zeros_like(bound)
    for _ in range(4000):
        phases = np.exp(2j * np.pi * rng.random(sizes.shape))
        largest = np.maximum(largest, np.abs(drive + np.einsum("nms,ns->nm", transfer, sizes * phases)))
    assert np.all(largest <= bound * (1.0 + 1e-12))
    assert np.all(largest >= 0.85 * bound)
    worst = np.abs(drive) + np.einsum("nms,ns->nm", np.abs(transfer), sizes)
    np.testing.assert_allclose(bound, worst, rtol=1e-12)


def test_at_an_order_without_a_line_of_the_model_it_stands_by_itself():
    """Truth: the magnitudes through the modes; a line of the torque below its own error has no phase either."""
    source = source_of()
    without = {q: line for q, line in DRIVE.items() if q != 2.0}
    found = response(source, 10.0, steady(10.0, without))
    sizes = np.abs([exerted(10.0)[name].get(2.0, 0.0) for name in MEASURED])
    amplitude = np.abs(source.transfer(np.array([20.0]))[0]) @ sizes
    np.testing.assert_allclose(found.side.alone.frequency_hz, [20.0])
    np.testing.assert_allclose(found.side.alone.power[0], 0.5 * amplitude**2, rtol=1e-3)
    tiny = response(source, 10.0, steady(10.0, {**without, 2.0: 1e-6}, error=1e-5))
    assert tiny.side.alone is None
    np.testing.assert_allclose(np.abs(tiny.phasors[2]), amplitude, rtol=1e-2)


def test_the_band_holds_the_truth():
    """Truth: the sum without noise, over 6 draws of the noise: the 95 % interval of the RMS holds nearly all."""
    truth = response(source_of(), 10.0).rms()
    inside = []
    for seed in range(6):
        found = response(source_of(seed=seed, noise=0.05, rates=(10.0,), seconds=6.0), 10.0)
        drive = np.broadcast_to(found.drive, (400, *found.drive.shape))
        draws = found.side.draw(drive, np.zeros((400, len(found.drive))), np.random.default_rng(0))
        low, high = np.quantile(np.sqrt(0.5 * np.sum(np.abs(draws) ** 2, axis=1)), (0.025, 0.975), axis=0)
        inside += ((low <= truth) & (truth <= high)).tolist()
    assert sum(inside) >= 10


def test_how_lines_count_and_where_nothing_is_near():
    """Truth: the kinds that the records were made with; outside the rates amplitudes grow with the rate squared."""
    source = source_of()
    near, above = source.at(MICRO, 10.0), source.at(MICRO, 21.0)
    one, force_x = TRACKED.index(1.0), MEASURED.index("force_x")
    assert near.line_use(one, force_x) == COHERENT
    assert near.line_use(one, MEASURED.index("force_z")) == WITHIN
    assert not near.far
    assert above.line_use(one, force_x) == MAGNITUDE
    assert above.far
    assert above.outside
    grown = 0.5 * 1.05**2 * (21.0 / 10.5) ** 2
    assert above.bounds[one, force_x] == pytest.approx(grown, rel=1e-2)
    other = Command(stepping="full", microsteps=1, rate=RateProfile.constant(1.0), start_angle_deg=45.0)
    assert not source.has_same_stepping(other)
    assert source.at(other, 10.0).line_use(one, force_x) == MAGNITUDE
    gap = source_of(rates=(5.0, 20.0)).at(MICRO, 10.0)
    assert gap.far
    assert not gap.outside
    assert gap.bounds[one, force_x] == pytest.approx(0.5 * 4.0, rel=1e-2)


def test_directions_that_the_structure_lacks_are_named():
    some = replace(STRUCTURE, directions={d: STRUCTURE.directions[d] for d in ("tx", "rx")})
    source = source_of(some)
    assert source.flying_components == ("force_y", "moment_y")  # the bench's x is the structure's y
    assert source.absent == {"force_x": "ty", "force_z": "tz", "moment_x": "ry"}
    assert response(source, 10.0).side.here.components == ("force_y", "moment_y")
    nothing = source_of(replace(STRUCTURE, directions={}))
    assert nothing.flying_components == ()


def test_a_torque_that_turns_the_other_way():
    """Truth: the same bench, its torque counted about -z: the line of sight is that of before with the other sign."""
    source = source_of()
    flip = np.ones((6, 6))
    flip[0], flip[:, 0] = -1.0, -1.0
    flip[0, 0] = 1.0
    records = tuple(
        replace(r, rates=tuple(replace(at, power=flip * at.power, noise=flip * at.noise) for at in r.rates))
        for r in source.measured.records
    )
    other = SideRecords(mounting=Mounting("-z", source.measured.mounting.point_m), records=records)
    state = steady(10.0, {q: -line for q, line in DRIVE.items()})
    found = response(SideSource(other, FRAME, STRUCTURE), 10.0, state)
    np.testing.assert_allclose(found.phasors, -response(source, 10.0).phasors, rtol=1e-9)


def test_a_drive_axis_that_is_not_the_structures_is_refused():
    turned = FRAME[:, [1, 2, 0]]
    with pytest.raises(InputFileError, match=r"drive axis z points along \[0, 1, 0\].*torque acts about rz"):
        source_of(frame=turned)
    assert math.isclose(np.linalg.det(turned), 1.0)
