"""Texts for the positions of a kernel's numbers, most of them in one flat workspace."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Row:
    """A row of numbers that starts at a function argument, or an array; `row[i]` is the text of one number."""

    text: str

    def __getitem__(self, index: int | str) -> str:
        return self.text.format(index)


@dataclass(frozen=True)
class Part:
    """A named part of the workspace; `part[i]` is the text of one number.

    A fixed position has a name of its own, such as ``AT_C_5``: a module constant compiles faster than a sum.
    """

    name: str
    used: set[int] = field(default_factory=set)

    def __getitem__(self, index: int | str) -> str:
        if isinstance(index, str):
            return f"w_[AT_{self.name} + {index}]"
        self.used.add(index)
        return f"w_[AT_{self.name}_{index}]"


@dataclass(frozen=True)
class Places:
    """All numbers that the functions of one plant read and write.

    Attributes
    ----------
    x, k, new : Row
        A point (the states, then sine and cosine of each base angle), rates, and the point at the end of a step, at
        `x_at`, `k_at` and `new_at`.
    mid, g, prop : Row
        Midpoint filter inputs, margins and a propagator, at `mid_at`, `g_at` and `prop_at`.
    p, y, w : Row
        Parameters, outputs, and the workspace indexed directly, for a group of lanes.
    z, u, m, c : Part
        Filter states, inputs, mode symbols, constants.
    points, packed, tangent : Part
        Points of the stages and of the end of a step, point by point and side by side; coefficients of the tangent
        program there.
    x_p, g_x, g_p, y_x, y_p : Part
        Derivatives of the start, of margins and of outputs.
    A, B, dA, dB, dz : Part
        Matrices of the filter and their derivatives; derivatives of its states.
    pinned : Part
        Flags of the states that take a fixed value where a guard fires.
    """

    x: Row = Row("w_[x_at + {}]")
    k: Row = Row("w_[k_at + {}]")
    new: Row = Row("w_[new_at + {}]")
    mid: Row = Row("w_[mid_at + {}]")
    g: Row = Row("w_[g_at + {}]")
    prop: Row = Row("w_[prop_at + {}]")
    p: Row = Row("p_[{}]")
    y: Row = Row("y_[{}]")
    w: Row = Row("w_[{}]")
    z: Part = field(default_factory=lambda: Part("Z"))
    u: Part = field(default_factory=lambda: Part("U"))
    m: Part = field(default_factory=lambda: Part("M"))
    c: Part = field(default_factory=lambda: Part("C"))
    points: Part = field(default_factory=lambda: Part("POINTS"))
    packed: Part = field(default_factory=lambda: Part("PACKED"))
    tangent: Part = field(default_factory=lambda: Part("TANGENT"))
    x_p: Part = field(default_factory=lambda: Part("X_P"))
    g_x: Part = field(default_factory=lambda: Part("G_X"))
    g_p: Part = field(default_factory=lambda: Part("G_P"))
    y_x: Part = field(default_factory=lambda: Part("Y_X"))
    y_p: Part = field(default_factory=lambda: Part("Y_P"))
    A: Part = field(default_factory=lambda: Part("A"))
    B: Part = field(default_factory=lambda: Part("B"))
    dA: Part = field(default_factory=lambda: Part("DA"))
    dB: Part = field(default_factory=lambda: Part("DB"))
    dz: Part = field(default_factory=lambda: Part("DZ"))
    pinned: Part = field(default_factory=lambda: Part("PINNED"))

    @property
    def named_positions(self) -> dict[str, list[int]]:
        """Indices of the fixed positions that have a name, by part."""
        parts = (part for part in vars(self).values() if isinstance(part, Part))
        return {part.name: sorted(part.used) for part in parts if part.used}
