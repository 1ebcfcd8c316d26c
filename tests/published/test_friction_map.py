"""Friction of a harmonic drive over 36 bins of its rotor's angle, in both directions.

harivin/harmonic-drive-actuator (2026), ratio 50, as its controller reports it at the output. Case F of
docs/validation.md.
"""

import json

import numpy as np
import pytest

import mechid

PUBLISHED = {"map_pos": (7.959, 1.594, 1.005), "map_neg": (7.289, 1.042, 1.021)}
"""By direction: mean and amplitudes of orders 1 and 2 in N m, by an independent fit."""


@pytest.fixture(scope="module")
def bins(data_folder):
    """Return friction in N m over one turn of the rotor by direction, (36,) each."""
    file = data_folder / "harmonic_friction_map_harivin" / "friction_map.json"
    return {name: np.array(values) for name, values in json.loads(file.read_text()).items() if name in PUBLISHED}


@pytest.mark.data
def test_order_1_depends_on_the_direction(bins):
    """Truth: the data; one map for both directions, as `[[friction.position]]` has it, cannot hold them within 3 %."""
    found = {name: np.abs(np.fft.rfft(values))[:3] * (1.0, 2.0, 2.0) / values.size for name, values in bins.items()}
    for name, published in PUBLISHED.items():
        assert found[name] == pytest.approx(published, rel=1e-3)
    forward, backward = (found[name] / found[name][0] for name in PUBLISHED)
    assert forward[1] / backward[1] > 1.35


RATE, RAMP_S, LASTS_S, SAMPLE_RATE_HZ = 2.0 * np.pi * 0.05 * 50.0, 0.5, 2.8, 500.0
"""Rotor behind a ratio of 50 at the 0.05 turns/s of the measurements, rad/s, after a sine's quarter from rest."""
INERTIA = 2.0
DIRECTIONS = {"forward": ("map_pos", 1.0), "backward": ("map_neg", -1.0)}


def turning_on(bins, way):
    """Return the torque that turns a body on the map's friction, interpolated by its harmonics, and its rate."""
    time = np.arange(round(LASTS_S * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    pace, is_ramp = 0.5 * np.pi / RAMP_S, time < RAMP_S
    rate = np.where(is_ramp, RATE * np.sin(pace * time), RATE)
    acceleration = np.where(is_ramp, RATE * pace * np.cos(pace * time), 0.0)
    angle = np.where(is_ramp, RATE * (1.0 - np.cos(pace * time)) / pace, RATE / pace + RATE * (time - RAMP_S))
    lines = np.fft.rfft(bins) / bins.size
    k = np.arange(1, lines.size - 1)
    friction = lines[0].real + 2.0 * (np.exp(1j * np.outer(way * angle, k)) @ lines[1:-1]).real
    noise = 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    return np.column_stack([time, way * (INERTIA * acceleration + friction), way * rate + noise])


def campaign(folder, bins):
    """Write a campaign of a turn each way; return it, and the harmonics' parameters."""
    names, lists, records = [], "", ""
    for direction, (key, way) in DIRECTIONS.items():
        header = "time_s,torque_Nm,rate"
        table = turning_on(bins[key], way)
        np.savetxt(folder / f"{direction}.csv", table, delimiter=",", header=header, comments="")
        records += (
            f'[[record]]\nname = "{direction}"\nfile = "{direction}.csv"\nchannels = [\n'
            '  { quantity = "torque", column = "torque_Nm", unit = "N*m", role = "input" },\n'
            '  { quantity = "output_rate", column = "rate", unit = "rad/s" },\n]\n'
        )
        for k in range(4):
            lists += (
                f"[[friction.position_{direction}]]\norder = {k + 1}\n"
                "amplitude = { value = 0.05, min = 0.0, max = 0.5 }\n"
                "phase_deg = { value = 0.0, min = -180.0, max = 180.0 }\n"
            )
            names += [f"friction.position_{direction}.{k}.{key}" for key in ("amplitude", "phase_deg")]
    (folder / "mechanism.toml").write_text(
        f'assembly = "direct_torque_drive"\n[load]\ninertia = {INERTIA}\n[friction]\nlaw = "directional"\n'
        "coulomb = { value = 6.0, min = 1.0, max = 15.0 }\nviscous = 0.0\n"
        f"asymmetry = {{ value = 0.0, min = -0.5, max = 0.5 }}\n{lists}"
    )
    level = ["friction.coulomb", "friction.asymmetry"]
    stages = "".join(f"[[stage]]\nfree = {json.dumps(free)}\n" for free in (level, level + names))
    (folder / "campaign.toml").write_text(f'mechanism = "mechanism.toml"\n{records}{stages}')
    return mechid.load_campaign(folder)


@pytest.mark.data
@pytest.mark.slow
def test_a_fit_finds_the_orders_by_direction(bins, tmp_path, note):
    """Published: mean and amplitudes of orders 1 and 2 by direction to 3 %; phases from the bins to 3 deg.

    A body of 2 kg m2 turns on the map both ways; orders 3 and 4, which the map has too, are free as well. The fit
    starts at a twentieth of the mean for all, at phases of 0.
    """
    fit = mechid.identify(campaign(tmp_path, bins))
    value = {name: parameter.value for name, parameter in fit.parameters.items()}
    for direction, (key, way) in DIRECTIONS.items():
        mean = value["friction.coulomb"] * (1.0 + way * value["friction.asymmetry"])
        place = f"friction.position_{direction}"
        found = (mean, *(mean * value[f"{place}.{k}.amplitude"] for k in (0, 1)))
        note(f"friction map {direction}: mean, orders 1 and 2: {', '.join(f'{one:.3f}' for one in found)} N m")
        assert found == pytest.approx(PUBLISHED[key], rel=0.03)
        for k in (0, 1):
            # A sine leads the cosine of a spectrum's phase by a quarter.
            phase = np.degrees(np.angle(1j * np.fft.rfft(bins[key])[k + 1]))
            assert abs((value[f"{place}.{k}.phase_deg"] - phase + 180.0) % 360.0 - 180.0) < 3.0
