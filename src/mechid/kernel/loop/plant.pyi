"""What `kernel.source` writes of a plant, as the time loop sees it: sizes, places, tables and functions."""

from collections.abc import Callable
from typing import Any, Protocol, TypeVar, overload

class Numbers(Protocol):
    """Floating-point numbers by their places, none counted from the end."""

    def __getitem__(self, place: int) -> float: ...
    def __setitem__(self, place: int, value: float) -> None: ...

class Integers(Protocol):
    """Integers by their places."""

    def __getitem__(self, place: int) -> int: ...
    def __setitem__(self, place: int, value: int) -> None: ...

class Array(Numbers, Protocol):
    """A flat array with its length, as the caller hands it over."""

    shape: tuple[int]

    @overload
    def __getitem__(self, place: int) -> float: ...
    @overload
    def __getitem__(self, place: slice) -> Array: ...

class IntegerArray(Integers, Protocol):
    """The same of integers."""

    shape: tuple[int]

    @overload
    def __getitem__(self, place: int) -> int: ...
    @overload
    def __getitem__(self, place: slice) -> IntegerArray: ...

class Table(Protocol):
    """Integers by switch and mode."""

    def __getitem__(self, place: tuple[int, int]) -> int: ...

A = TypeVar("A")
F = TypeVar("F", bound=Callable[..., Any])

INNER: dict[str, Any]
ENTRY: dict[str, Any]
FAST: set[str]

def numbers(array: A) -> A: ...
def njit(**options: Any) -> Callable[[F], F]: ...

# Numbers of lanes, states, filter states and inputs, plant inputs, outputs, parameters, switches, parameters of the
# filter, numbers of a point; terms of the propagator's series; groups of lanes and their layout.
NL: int
NM: int
NX: int
NF: int
NV: int
NU: int
NY: int
NP: int
NS: int
NPF: int
NPOINT: int
TERMS: int
NONE: int  # no switch, no guard
NG: int
NSEED: int  # pairs of a node and a parameter that affects it directly
NFORCED: int  # nodes in them
LANES_PER_GROUP: int
GROUP_SIZE: int
ROW_S: int
ROW_SZ: int
ROW_DIR: int
ROW_DTAU: int
ROW_FORCE: int
SIZE: int
MOST_GUARDS: int
GUARD_FIRST: Table
GUARD_COUNT: Table
GUARD_TARGET: Integers
SEED_FIRST: Integers
SEED_COEFFICIENT: Integers
SEED_PARAMETER: Integers
IN_DRIVE: Integers

# Where each part of the workspace begins, and where some end.
AT_X: int
AT_X_NEW: int
AT_X_TRY: int
AT_POINTS: int
AT_ONE: int
AT_SCALE: int
AT_TANGENT: int
AT_TIME: int
AT_Z: int
AT_U: int
AT_K: int
AT_K_NEW: int
AT_K_EVENT: int
AT_M: int
AT_MID: int
AT_MID_TRY: int
AT_KNOWN: int
AT_CLOSE: int
AT_PINNED: int
END_PINNED: int
AT_DZ: int
AT_A: int
AT_B: int
AT_DA: int
AT_DB: int
AT_POWER: int
END_POWER: int
AT_PRODUCT: int
AT_REGULAR: int
AT_OTHER: int
AT_TABLE: int
END_TABLE: int
AT_JUMP: int
AT_JUMP_LANES: int
END_JUMP_LANES: int
AT_X_P: int
AT_G_OLD: int
AT_G_NEW: int
AT_G_SLOPE: int
AT_G_X: int
AT_G_P: int
END_G_P: int
AT_PAIR: int
AT_DOT_PAIR: int
AT_J_PAIR: int

def turn(w_: Numbers, x_at: int) -> None: ...
def rates(w_: Numbers, x_at: int, k_at: int) -> None: ...
def step(w_: Numbers, x_at: int, k_at: int, h: float, new_at: int, mid_at: int) -> None: ...
def margins(s: int, mode: int, w_: Numbers, x_at: int, g_at: int) -> None: ...
def slopes(s: int, mode: int, w_: Numbers, x_at: int, k_at: int, g_at: int) -> None: ...
def gradients(s: int, mode: int, w_: Numbers, x_at: int) -> None: ...
def entry_mode(s: int, w_: Numbers, x_at: int) -> int: ...
def set_mode(s: int, mode: int, w_: Numbers) -> None: ...
def reset_states(g: int, w_: Numbers, x_at: int) -> None: ...
def start(p_: Numbers, theta_0: float, w_: Numbers, x_at: int) -> None: ...
def outputs(w_: Numbers, x_at: int, y_: Numbers, at: int) -> None: ...
def output_flow(w_: Numbers, x_at: int, k_at: int, y_: Numbers, at: int) -> None: ...
def output_gradient(w_: Numbers, x_at: int) -> None: ...
def filter_matrices(p_: Numbers, w_: Numbers) -> None: ...
def tangents(w_: Numbers) -> None: ...
def lane_rates(w_: Numbers, g: int) -> None: ...
def carry_lanes(w_: Numbers, g: int, h: float, prop_at: int) -> None: ...
def carry_filter_lanes(w_: Numbers, g: int, prop_at: int) -> None: ...
def measure_group(w_: Numbers, g: int, J_: Numbers, to: int) -> None: ...
def constants(p_: Numbers, w_: Numbers) -> None: ...
def force_filter(w_: Numbers, g: int) -> None: ...
def put_turned(w: Numbers, to: int, a: int, b: int, c: int, d: int, scale: int, add: int) -> None: ...
