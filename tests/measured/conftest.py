"""The campaigns of examples/measured/, their data beside them."""

import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mechid.campaign import load_campaign
from mechid.cli.app import app
from mechid.identification.result.fit_file import read_fit

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "measured"


@pytest.fixture(scope="module")
def example(data_folder, tmp_path_factory):
    """Return a function that copies an example campaign, puts the data beside it, and changes text in its files."""

    def copy(name, **changes):
        folder = tmp_path_factory.mktemp(name) / name
        shutil.copytree(EXAMPLES / name, folder, ignore=shutil.ignore_patterns("data"))
        (folder / "data").symlink_to(data_folder, target_is_directory=True)
        for file, (old, new) in changes.items():
            path = folder / f"{file}.toml"
            text = path.read_text(encoding="utf-8")
            assert old in text
            path.write_text(text.replace(old, new), encoding="utf-8")
        return folder

    return copy


@pytest.fixture(scope="module")
def identified():
    """Return a function that runs `mechid identify` on a folder; it returns the fit, and the folder of results."""

    def run(folder, *options, out="fit"):
        result = CliRunner().invoke(app, ["identify", str(folder), "--out", str(folder / out), *options])
        if result.exit_code not in (0, 5):
            pytest.fail(result.stderr or repr(result.exception))
        return read_fit(folder / out / "estimate.json", load_campaign(folder)), folder / out

    return run
