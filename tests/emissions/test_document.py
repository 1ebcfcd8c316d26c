"""Files of an emission verdict. Truth: the contract of emission.json, and the names of the figures."""

import json

import mechid
from emission_bench import background, record, requirement, samples, write_campaign

LINES = ((46.0, 0.05), (92.0, 0.02))


def test_it_leaves_its_files(tmp_path):
    wanted = [
        requirement(),
        requirement("d", "mz", "psd", "N^2*m^2/Hz"),
        requirement("b", kind="band_peak", mask=((20.0, 0.2), (500.0, 0.2))),
    ]
    runs = {"run": samples(1, LINES), "fast": samples(3, ((60.0, 0.05),)), "off": samples(2)}
    parts = (record("run", 46.0), record("fast", 60.0), background(), *wanted)
    found = mechid.emission(write_campaign(tmp_path, runs, *parts))
    out = tmp_path / "out"
    found.write(out)
    data = json.loads((out / "emission.json").read_text())
    assert data["format"] == "mechid-emission/1"
    assert set(data["requirements"][0]["worst"]) >= {
        "record",
        "rate",
        "frequency_Hz",
        "value",
        "sigma",
        "limit",
        "margin_dB",
    }
    assert set(data["lines"][0]) >= {
        "record",
        "rate",
        "direction",
        "frequency_Hz",
        "order",
        "amplitude",
        "sigma",
        "background",
        "unit",
    }
    left = {path.name for path in out.iterdir()}
    assert left == {
        "emission.json",
        "emission.html",
        "emission.md",
        "emission.xlsx",
        "lines.csv",
        "verdicts.csv",
        "figures",
    }
    page = (out / "emission.html").read_text()
    for name in (path.stem for path in (out / "figures").glob("*.svg")):
        assert name in page
    assert "emission_mz_density" in page
    assert "emission_requirement_3_over_rate" in page
    assert repr(found) == "<Emission: r: pass, d: pass, b: pass>"
