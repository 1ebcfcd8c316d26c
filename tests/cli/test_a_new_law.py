"""A friction law that the library has not, in one place, walked through the whole chain.

The law stands here as it would in `plant/friction.py`: its equations, its parameters, one entry in `LAWS`. Nothing
else of mechid knows of it.
"""

import json
import math

import numpy as np
import pytest
from sympy import Symbol

from freed import freed
from layouts import changed, mechanism_of, paper_table
from mechid.campaign import load_campaign, load_mechanism, mechanism_text
from mechid.parameter import Declaration, Role
from mechid.plant import friction
from mechid.web import Source
from mechid.web.session import Session
from paper import constant
from runs import base, run_twin

SOURCE = "a law of this test"
TRUTH = {"friction.dry": 0.004, "friction.drag": 6.0e-4, "gear.stiffness": 913.47}
DESIGN = """
[recording]
noise_Nm = 0.002
[candidates]
steppings = ["full"]
rates = [23.0]
start_angles_deg = [45.0]
sweeps_s = []
[limits]
between_s = 1.0
total_s = 3.0
[prior]
mechanisms = 2
"""
STRUCTURE = """
axis = "rz"
line_of_sight = ["x"]
[[mode]]
frequency_hz = 300.0
damping = 0.005
interface = 0.15
line_of_sight = [0.04]
"""
BUDGET = """
estimate = "estimate.json"
[structure]
file = "structure.toml"
coupled_below_hz = 10.0
[[mode]]
name = "slew"
command = { stepping = "full", rate = 46.0, start_angle_deg = 45.0 }
[[requirement]]
name = "stability"
index = "APE"
axis = "x"
limit_rad = 1e-4
interpretation = "temporal"
confidence = 0.95
evaluation_period_s = 60.0
"""


def turbulent(site):
    """T_fr = T_c sign(omega) + c omega |omega|, held up to T_c: the drag of a rotor that churns its lubricant."""
    T_c, c = Symbol(f"T_dry{site.suffix}"), Symbol(f"c_drag{site.suffix}")
    own = (
        Declaration(
            key="dry",
            symbol=T_c.name,
            unit=site.torque,
            meaning="dry friction",
            lower=0.0,
            source=SOURCE,
            role=Role.DRY_FRICTION,
        ),
        Declaration(
            key="drag",
            symbol=c.name,
            unit="N m s2/rad2",
            meaning="drag at the square of the speed",
            lower=0.0,
            source=SOURCE,
        ),
    )
    return friction.set_valued(
        site, own, sliding=site.sigma * (T_c + c * site.omega**2), holds=(T_c, T_c), reference=SOURCE
    )


@pytest.fixture(scope="module", autouse=True)
def law():
    """Have the law in the library while this module runs."""
    friction.LAWS["turbulent"] = lambda site: (turbulent(site),)
    yield
    del friction.LAWS["turbulent"]


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Return a campaign of two short records, made by the slow twin, from which the law is to be identified."""
    folder = tmp_path_factory.mktemp("bench")
    changes = {"friction": None, "housing": None}
    table = changed(paper_table(), changes) | {"friction": {"law": "turbulent", "dry": 0.004, "drag": 6.0e-4}}
    mechanism, rng = mechanism_of(table), np.random.default_rng(5)
    lines = ['mechanism = "mechanism.toml"']
    for name, rate in (("slow", 20.0), ("fast", 46.0)):
        time_base = base(0.25)
        y = run_twin(mechanism, constant(rate), time_base).y[:, 0] + rng.normal(0.0, 2e-3, time_base.samples)
        columns = np.stack([time_base.times, y], axis=1)
        np.savetxt(folder / f"{name}.csv", columns, delimiter=",", header="time_s,torque_Nm", comments="")
        lines += [
            "[[record]]",
            f'name = "{name}"',
            f'file = "{name}.csv"',
            f'command = {{ stepping = "full", rate = {rate}, start_angle_deg = 45.0 }}',
        ]
    names = ", ".join(f'"{name}"' for name in TRUTH)
    lines += ["[[stage]]", "window_s = [0.0, 0.06]", f"free = [{names}]", "[[stage]]", f"free = [{names}]"]
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "mechanism.toml").write_text(freed(mechanism_text(mechanism), TRUTH, off=1.02), encoding="utf-8")
    return folder


@pytest.mark.slow
def test_a_new_friction_law_through_the_whole_chain(run, bench):
    """Truth: the values that made the records; the torque that flies is that of the law, not of another."""
    assert run("check", bench).exit_code == 0
    fit = bench / "fit"
    identified = run("identify", bench, "--out", fit)
    assert identified.exit_code == 0, identified.stderr
    estimate = json.loads((fit / "estimate.json").read_text(encoding="utf-8"))
    for name, value in TRUTH.items():
        p = estimate["parameters"][name]
        assert abs(p["value"] - value) < 5.0 * p["std_error"] < 0.2 * value, name
    assert load_mechanism(fit / "mechanism.toml").options["friction.law"] == "turbulent"
    page = (fit / "report.html").read_text(encoding="utf-8")
    assert "friction.drag" in page
    assert "drag at the square of the speed" in page
    _explored(bench)
    _designed(run, bench)
    _flown(run, fit)


def _explored(bench):
    """Turn the new parameter in the explorer: the model and its equations follow."""
    session = Session(Source(load_campaign(bench)))
    (before,) = [picture.modelled.copy() for picture in session.pictures().values()]
    session.turn("friction.drag", 2.0 * TRUTH["friction.drag"])
    (after,) = [picture.modelled for picture in session.pictures().values()]
    assert np.abs(after - before).max() > 1e-3


def _designed(run, bench):
    """Plan the next test of it: what a record would tell of the drag, and what friction costs steps."""
    (bench / "design.toml").write_text(DESIGN, encoding="utf-8")
    result = run("design", bench, "--out", bench / "next")
    assert result.exit_code == 0, result.stderr
    content = (bench / "next" / "design.json").read_text(encoding="utf-8")
    assert "friction.drag" in content


def _flown(run, fit):
    """Fly it: its share is in the band, and the line is that of the equations with the estimate's values."""
    (fit / "structure.toml").write_text(STRUCTURE, encoding="utf-8")
    (fit / "budget.toml").write_text(BUDGET, encoding="utf-8")
    result = run("budget", fit / "budget.toml", "--out", fit / "budget")
    assert result.exit_code == 0, result.stderr
    data = json.loads((fit / "budget" / "budget.json").read_text(encoding="utf-8"))
    assert {"friction.dry", "friction.drag"} <= data["requirements"][0]["variance_shares"].keys()
    estimated = load_mechanism(fit / "mechanism.toml")
    torque = run_twin(estimated, constant(46.0), base(1.5)).y[:, 0]
    last = torque[-1 - round(10_000 * 22 / 46.0) : -1]
    assert math.isclose(data["modes"][0]["torque_rms_Nm"], np.std(last), rel_tol=0.01)
