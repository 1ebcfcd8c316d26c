"""Progress in a notebook. Truth: what was told."""

import sys
from types import ModuleType, SimpleNamespace

import mechid
from mechid.progress.listening import NotebookLine, line_receiver, progress_listener, progress_words


def notebook(monkeypatch, shown):
    """Stand in for IPython in a kernel; what is displayed is noted."""
    handle = SimpleNamespace(update=shown.append)
    display = ModuleType("IPython.display")
    display.HTML = lambda text: text
    display.display = lambda ink, display_id: shown.append(ink) or handle
    shell = ModuleType("IPython")
    shell.get_ipython = lambda: SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", shell)
    monkeypatch.setitem(sys.modules, "IPython.display", display)


def test_progress_in_a_notebook_is_one_line_that_goes(monkeypatch):
    shown = []
    notebook(monkeypatch, shown)
    told = [mechid.Progress(1, 4, "multi-start", f"start {k}", 1.0, 2.0) for k in (1, 2)]
    with progress_listener(None) as listener:
        assert isinstance(listener, NotebookLine)
        for one in told:
            listener(one)
    assert [progress_words(one) in ink for one, ink in zip(told, shown, strict=False)] == [True, True]
    assert shown[2:] == [""]


def test_a_listener_goes_before_the_notebooks_line(monkeypatch):
    notebook(monkeypatch, [])
    heard = []
    with progress_listener(heard.append) as listener:
        listener(mechid.Progress(1, 4, "multi-start", "", None, 0.0))
    assert len(heard) == 1


def test_a_script_hears_nothing():
    with progress_listener(None) as listener:
        assert not isinstance(listener, NotebookLine)


def test_lines_told_in_a_notebook_are_one_line_too(monkeypatch):
    shown = []
    notebook(monkeypatch, shown)
    with line_receiver(None) as told:
        told("mode <slew>: 3 rates")
    assert ["&lt;slew&gt;" in shown[0], shown[1:]] == [True, [""]]
