"""Records of some thousand samples treated as long ones: kept in files, read by blocks of odd sizes."""

import pytest

from mechid.records import arrays, csv, formats, parquet
from mechid.signal import stored_series

IN_MEMORY, AT_ONCE = 700, 333


@pytest.fixture
def little_memory(monkeypatch, tmp_path):
    """Hold 700 samples of a series in memory, and 333 of a longer one together; return the folder of the files.

    Readers run here, where their own numbers can be changed too.
    """
    monkeypatch.setattr(formats, "GUARDED", {})
    monkeypatch.setenv("MECHID_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(stored_series, "MAX_IN_MEMORY", IN_MEMORY)
    for module in (stored_series, arrays, csv):
        monkeypatch.setattr(module, "AT_ONCE", AT_ONCE)
    monkeypatch.setattr(csv, "WHOLE_BYTES", 1000)
    monkeypatch.setattr(parquet, "BATCH", 100)
    return tmp_path / "cache"


@pytest.fixture
def undone(monkeypatch):
    """Return what makes memory as large again as it was."""
    return monkeypatch.undo
