"""Mechanism files with parameters freed away from their truth, and fits held against it."""

FREE = "{{ value = {:.12g}, min = {:.12g}, max = {:.12g} }}"


def freed(text, truth, off=1.04):
    """Return a mechanism file's text in which the named parameters are free, from values that are off."""
    lines, table = [], ""
    for line in text.splitlines():
        table = line.split("]")[0].lstrip("[") if line.startswith("[") else table
        key = line.split(" = ")[0]
        if (value := truth.get(f"{table}.{key}")) is not None:
            low, high = sorted((0.5 * value, 2.0 * value))
            lines.append(f"{key} = {FREE.format(off * value, low, high)}")
        else:
            lines.append(line)
    return "\n".join(lines) + "\n"


def assert_found(fit, truth, sigmas=4.0, largest=0.05):
    for name, value in truth.items():
        found = fit.parameters[name]
        assert found.status == "free", (name, found)
        assert 0.0 < found.std_error < largest * abs(value), (name, found.std_error)
        assert abs(found.value - value) <= sigmas * found.std_error, (name, found.value, value, found.std_error)
