"""What is shown of profiles. Truth: a parabola by hand, its interval worked out on paper, and a side without an end."""

import json

import numpy as np
import pytest

from mechid.identification.refit.profile import Cliff, Point, Profile, SideEnd
from mechid.profiles.document import PRESENTER
from mechid.profiles.figures import figure_name, profile_figures
from mechid.profiles.numbers import profile_numbers
from mechid.profiles.run import Profiles

STIFFNESS = "gear.stiffness"
LEVEL = 3.84
NOWHERE = np.zeros(0)


def profile(**changes):
    """Return a parabola of standard error 2 about 900."""
    points = tuple(Point(900.0 + 2.0 * k, float(k * k), NOWHERE) for k in np.linspace(-3.0, 3.0, 13))
    known = {
        "name": STIFFNESS,
        "unit": "N m/rad",
        "value": 900.0,
        "std_error": 2.0,
        "std_error_white": 2.0,
        "points": points,
        "level": LEVEL,
        "level_coloured": None,
        "interval": (896.08, 903.92),
        "interval_coloured": (None, None),
        "ends": (SideEnd.CROSSED, SideEnd.CROSSED),
        "cliffs": (),
    }
    return Profile(**{**known, **changes})


def test_files_and_page_have_the_interval(tmp_path):
    found = Profiles(profiles=(profile(),), synthetic=True)
    numbers = PRESENTER.numbers(found)
    names = {path.name for path in PRESENTER.write(found, numbers, tmp_path)}
    assert names == {"profile.json", "profile.csv", "profile.md", "profile.html", "figures"}
    content = json.loads((tmp_path / "profile.json").read_text())
    assert content["profiles"][STIFFNESS]["ci95"] == [896.08, 903.92]
    assert len((tmp_path / "profile.csv").read_text().splitlines()) == 1 + 13
    page, markdown = ((tmp_path / name).read_text() for name in ("profile.html", "profile.md"))
    for text in (page, markdown, PRESENTER.text(found)):
        assert "896.1" in text
        assert "903.9" in text
    assert "Synthetic" in page
    assert f"figures/{figure_name(STIFFNESS)}.svg" in markdown
    assert page.count("<svg") == 1


def test_a_curve_stands_beside_the_parabola_of_its_standard_error():
    """Truth: the parabola by hand."""
    (name, figure), *others = profile_figures(profile_numbers([profile()]))
    assert (name, others) == (figure_name(STIFFNESS), [])
    curve, parabola = figure.axes[0].get_lines()[:2]
    x = parabola.get_xdata()
    assert parabola.get_ydata() == pytest.approx(((x - 900.0) / 2.0) ** 2)
    assert curve.get_ydata() == pytest.approx(((curve.get_xdata() - 900.0) / 2.0) ** 2)


def test_what_is_no_smooth_rise_is_said():
    """Truth: a side that has not come to its level, a jump, and a point below the estimate."""
    points = (Point(895.0, -1.0, NOWHERE), Point(900.0, 0.0, NOWHERE), Point(905.0, 9.0, NOWHERE, "stopped"))
    odd = profile(
        points=points, interval=(None, 903.9), ends=(SideEnd.BOUND, SideEnd.CROSSED), cliffs=(Cliff(895.0, 900.0, 2.0),)
    )
    warnings = profile_numbers([odd])["warnings"]
    assert sum("no end of the interval below" in line for line in warnings) == 1
    assert sum("jumps by 2" in line for line in warnings) == 1
    assert sum("costs less by 1" in line for line in warnings) == 1
    assert len(list(profile_figures(profile_numbers([odd])))) == 1
