"""`mechid open`. Truth: a fit written by hand, and the contract of exit codes."""

import webbrowser

from results_by_hand import write_fit


def test_an_index_is_written_and_said(run, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    write_fit(tmp_path / "fit")
    result = run("open", tmp_path)
    assert result.exit_code == 0, result.stderr
    assert "fit: Grade B" in result.stdout
    assert str(tmp_path / "index.html") in result.stdout.splitlines()
    assert opened == []  # no terminal, so that nobody waits for a browser
    assert run("open", tmp_path, "--browser").exit_code == 0
    assert opened == [(tmp_path / "index.html").as_uri()]


def test_a_folder_without_results_is_a_wrong_command_line(refused, tmp_path):
    assert "holds no campaign and no result" in refused(2, "open", tmp_path)
    assert "is no folder" in refused(2, "open", tmp_path / "gone")
