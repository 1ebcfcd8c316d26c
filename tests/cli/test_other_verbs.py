"""`mechid new`, `mechid kernel`, `mechid --version`, and the public face; truth: the library's own functions."""

from types import SimpleNamespace

import mechid
from mechid.campaign import catalogue_mechanism, load_campaign, load_mechanism
from mechid.kernel.equation_text import equations_latex, equations_text


def test_new_writes_files_that_check_refuses_until_they_are_filled_in(run, refused, bench, tmp_path):
    mine = tmp_path / "mine"
    result = run("new", mine, bench / "full_46.csv", bench / "sweep.csv")
    assert result.exit_code == 0
    assert f"written: {mine / 'campaign.toml'}" in result.stdout.splitlines()
    for verb in (("check", mine), ("identify", mine, "--out", tmp_path / "fit"), ("simulate", mine, "--out", tmp_path)):
        line = refused(3, *verb)
        assert "record[0].command, record[1].command: empty, as mechid new wrote it" in line
        assert "mechanism.toml: template: nothing is filled in" in line
    assert "template" in refused(3, "kernel", mine / "mechanism.toml")
    for name in ("campaign.toml", "mechanism.toml"):
        path = mine / name
        kept = [line for line in path.read_text().splitlines() if not line.startswith("template")]
        path.write_text("\n".join(kept).replace("command = {}", "command = { stepping = 'full', rate = 46.0 }"))
    assert [record.name for record in load_campaign(mine).records] == ["full_46", "sweep"]
    assert run("check", mine).exit_code == 0


def test_new_overwrites_nothing(refused, run, tmp_path):
    run("new", tmp_path)
    before = (tmp_path / "mechanism.toml").read_text()
    assert "already exists" in refused(2, "new", tmp_path)
    assert (tmp_path / "mechanism.toml").read_text() == before


def test_new_warns_of_files_that_are_not_there_yet(run, tmp_path):
    result = run("new", tmp_path, tmp_path / "later.csv")
    assert result.exit_code == 0
    assert "there is no such file yet" in result.stderr


def test_kernel_prints_the_equations(run):
    plant = catalogue_mechanism().plant
    assert run("kernel").stdout == equations_text(plant)
    assert run("kernel", "--latex").stdout == equations_latex(plant)


def test_kernel_prints_the_equations_of_a_file(run, folder, monkeypatch):
    """The housing's other form stands in them; it is not compiled here, which would take its time."""
    path = folder / "mechanism.toml"
    path.write_text(path.read_text().replace('form = "paper"', 'form = "unit_dc"'))
    monkeypatch.setattr("mechid.cli.kernel_notice.prepare_kernel", lambda *_: SimpleNamespace(path=path))
    result = run("kernel", path)
    assert result.exit_code == 0
    assert result.stdout == equations_text(load_mechanism(path).plant)
    assert result.stdout != equations_text(catalogue_mechanism().plant)


def test_kernel_prints_its_source(run):
    result = run("kernel", "--source")
    assert result.stdout.startswith('"""Kernel of stepper_gear_mass')
    compile(result.stdout, "kernel", "exec")
    assert "cache" in result.stderr


def test_a_first_compilation_is_told_as_such(monkeypatch, capsys):
    from mechid.cli import kernel_notice

    monkeypatch.setattr(kernel_notice, "is_compiled", lambda *_: False)
    monkeypatch.setattr(kernel_notice, "kernel_for", lambda *_: SimpleNamespace(seconds=8.234, cached=False))
    kernel_notice.prepare_kernel(catalogue_mechanism().plant)
    assert capsys.readouterr().err == "compiling the kernel (first time, cached afterwards) ... 8.2 s\n"


def test_the_public_names_are_what_they_say():
    from mechid.campaign.prediction import simulate
    from mechid.reports.run import identify

    assert mechid.identify is identify
    assert mechid.simulate is simulate
    assert set(mechid.__all__) <= set(dir(mechid))
