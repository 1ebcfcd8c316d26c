"""A reader of bulk data in fixed fields, as strict as the format: nothing outside its columns, nothing unaligned."""

import re
from pathlib import Path

REAL = re.compile(r"-?\d+\.\d*(E[+-]\d+)?|-?\d+\.\d*[+-]\d+")
INTEGER = re.compile(r"-?\d+")


def value(field):
    """Return a field's integer, real number, text, or None where it is blank; a real number has a point."""
    text = field.strip()
    if INTEGER.fullmatch(text):
        return int(text)
    if REAL.fullmatch(text):
        return float(re.sub(r"(?<=[\d.])([+-]\d+)$", r"e\1", text) if "E" not in text else text)
    assert re.fullmatch(r"[A-Z]*", text), text
    return text or None


def cards(path):
    """Return the cards of a file: name, then the values of their fields, continued ones joined."""
    found = []
    for line in Path(path).read_text(encoding="ascii").splitlines():
        assert len(line) <= 72, line
        assert "\t" not in line
        if line.startswith("$"):
            continue
        width = 16 if "*" in line[:8] else 8
        assert width == 16 or " " not in line[: len(line.split()[0])]
        body = line[8:].ljust(64)
        fields = [body[k : k + width] for k in range(0, 64, width)]
        assert all(" " not in field.strip() for field in fields), line
        name = line[:8].strip()
        if name == "*":
            found[-1][1].extend(map(value, fields))
        else:
            assert re.fullmatch(r"[A-Z]+\d?\*?", name), line
            found.append((name.rstrip("*"), list(map(value, fields))))
    return found
