"""Campaigns in which one thing is wrong; truth: what `benchmarks/wrong` has made wrong.

Each has to be named in the first three lines, or be put right and said; none may end as a confident wrong answer.
"""

import re

import pytest

from wrong.bench import Files, right_files
from wrong.cases import cases
from wrong_campaigns import FIRST, estimated, is_confident_and_wrong, named

CASES = {case.name: case for case in cases()}
LEFT_TO_IDENTIFY = (
    "sign_one",
    "sign_all",
    "rate_sign_one",
    "late_5ms_one",
    "late_5ms_all",
    "begun_30ms_one",
    "gain_full_46",
    "gain_sweep",
    "16_as_8",
    "full_as_half",
    "200_ppm_all",
    "200_ppm_sweep",
    "compressing_full",
    "torque_constant",
    "gear_stiffness",
    "rotor_inertia",
    "load_inertia",
    "stiffness_free",
)
"""What no record shows without a fit, which names it in its first lines, or puts it right and says so."""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Return a function that writes a wrong campaign, or the right one, into a folder whose name says nothing."""
    folder = tmp_path_factory.mktemp("benches")
    right = right_files(folder / "right")

    def write(name=None, **options):
        files = Files()
        if name:
            CASES[name].make(files)
        return files.write(folder / f"{[*CASES, None].index(name):02d}", right, **options)

    return write


def lines_of(result):
    return result.stdout.splitlines() or result.stderr.splitlines()


def test_nothing_is_said_of_the_right_campaign(run, written):
    result = run("check", written())
    assert result.exit_code == 0
    assert "warning" not in result.stdout


SEEN = [name for name in CASES if name not in (*LEFT_TO_IDENTIFY, "semicolons")]
SIBLINGS = (
    "micro_92_sweep",
    "full_46_full_23",
    "ms_one",
    "clipped_full",
    "Ncm_all",
    "Ncm_one",
    "mNm_all",
    "hum_all",
    "housing_hertz",
    "start_angle_rad",
    "torque_constant_free",
    "rate_10pc_micro",
    "full_as_16",
    "full_46_micro_46",
    "200_Hz_one",
    "one_percent_one",
    "rate_1pc_full",
)
"""Cases of a mistake of which the default tests have another, cheaper case."""


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=pytest.mark.slow) if one in SIBLINGS else one for one in SEEN]
)
def test_check_names_the_cause_in_its_first_lines(run, written, name):
    said = lines_of(run("check", written(name)))
    assert named(CASES[name], said) == "first lines", said[:FIRST]


def test_a_decimal_comma_with_semicolons_is_read_as_meant(run, written):
    """Truth: the same numbers with points; what is said of both but for the folder is equal."""
    one, other = (lines_of(run("check", written(name)))[1:] for name in ("semicolons", None))
    assert one == other


@pytest.mark.parametrize(
    "name",
    [
        "16_as_8",
        *(
            pytest.param(one, marks=pytest.mark.slow)
            for one in ("gain_sweep", "sign_one", "late_5ms_all", "rotor_inertia")
        ),
    ],
)
def test_check_says_nothing_wrong_of_what_only_a_fit_shows(run, written, name):
    """A wrong cause would be worse than none: no record is read otherwise than declared."""
    said = "\n".join(lines_of(run("check", written(name)))[:FIRST])
    assert not re.search("seem to be swapped|torque times|low-pass|hum|unit", said), said


@pytest.mark.slow
@pytest.mark.parametrize("name", LEFT_TO_IDENTIFY)
def test_no_fit_is_confident_and_wrong(run, written, name):
    """Truth: the values that made the records; begun there, since the optimum is judged and not the way to it."""
    campaign = written(name, from_truth=True)
    said = lines_of(run("identify", campaign, "--out", campaign / "result"))
    fit = {"named": named(CASES[name], said), **estimated(campaign / "result")}
    assert not is_confident_and_wrong(fit), fit["wrong"]
    assert named(CASES[name], said) == "first lines", said[:FIRST]
