"""A small module in the language of kernels, and the same as Python runs it."""

import ast

import numpy as np

TEXT = '''"""A small kernel."""
N = 4
SCALE = 0.5
ORDER = np.array([2, 0, 3, 1])


# Sums of what
# is weighted.
@njit
def weighted(w: Numbers, sensitive: int) -> float:
    """Return the sum of each entry times its place."""
    total = 0.0
    for k in range(N):
        total = total + w[ORDER[k]] * k  # by place
    if sensitive:
        total = total + 1000.0
    return total


@njit
def ends(w: Numbers, low: float) -> tuple[float, float]:
    """Return the least entry, or a limit above it, and the largest."""
    least, largest = w[0], w[0]
    for k in range(1, N):
        least = min(least, w[k])
        largest = max(largest, w[k])
    return max(least, low), largest


@njit
def never_called(w: Numbers) -> float:
    return w[0]


@njit
def run(w: Numbers, out: Array, low: float, sensitive: int) -> int:
    """Write sum, ends and their mean; return how many entries are above half and not 2."""
    least, largest = ends(w, low)
    out[0] = weighted(w, sensitive)
    out[1], out[2] = least, largest
    out[3] = SCALE * (least + largest)
    above = 0
    for k in range(N):
        if w[k] > 0.5 and not w[k] == 2.0:
            above = above + 1
    return above
'''


def interpreted(module):
    """Return the functions and constants of a module as Python itself runs them."""
    known = {"np": np, **module.constants}
    for node in module.functions.values():
        bare = ast.parse(ast.unparse(node)).body[0]
        bare.decorator_list, bare.returns = [], None
        for argument in bare.args.args:
            argument.annotation = None
        exec(compile(ast.fix_missing_locations(ast.Module([bare], [])), "small_kernel", "exec"), known)
    return known


def ran(module, w, low, *sensitive):
    """Return what `run` returns and writes."""
    out = np.zeros(4)
    return interpreted(module)["run"](np.array(w), out, low, *sensitive), out
