"""Comma-separated files as a recorder writes them: a line of names, then a line a sample."""

import numpy as np


def write_csv(path, header, *columns, fmt="%.18e"):
    """Write columns of one length below their names."""
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=header, comments="", fmt=fmt)
