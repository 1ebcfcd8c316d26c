"""`mechid quiet`: refusals, before anything is computed. Truth: the exit codes of docs/commands.md."""

from paper_estimate import write_estimate_of_paper


def test_a_wrong_design_is_refused_and_nothing_is_written(refused, tmp_path):
    folder = write_estimate_of_paper(tmp_path).parent
    (tmp_path / "quiet.toml").write_text("bits = 2\n")
    line = refused(3, "quiet", folder, "--design", tmp_path / "quiet.toml", "--out", tmp_path / "out")
    assert "quiet.toml: bits: found 2; write a whole number from 4 to 16" in line
    assert not (tmp_path / "out").exists()
