"""Where the numbers of a kernel stand, as the texts of its functions name them: nearly all in one flat workspace."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Row:
    """Numbers in a row that begins at an argument of the function, or an array; `row[i]` is the text of one."""

    text: str

    def __getitem__(self, index: int | str) -> str:
        return self.text.format(index)


@dataclass(frozen=True)
class Part:
    """A part of the workspace by its name; `part[i]` is the text of one of its numbers.

    A single place has a name of its own, such as ``AT_C_5``: a constant of the module is cheaper to compile than a sum.
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
    """All that the functions of one plant read and write.

    Attributes
    ----------
    x, k, new : Row
        A point (the states, then sine and cosine of each base angle), rates, and the point that a step leads to, from
        `x_at`, `k_at` and `new_at` on.
    mid, g, prop : Row
        Filter inputs half way, margins, a propagator, from `mid_at`, `g_at` and `prop_at` on.
    p, y, w : Row
        Parameters; outputs; a group of lanes at its place.
    z, u, m, c : Part
        Filter states, inputs, mode symbols, constants.
    points, tangent : Part
        The points of a step's stages and end; the tangent program's coefficients there.
    x_p, g_x, g_p, y_x, y_p : Part
        Derivatives of the start, of margins and outputs.
    A, B, dA, dB, dz : Part
        Matrices of the filter, their derivatives, and those of its states.
    pinned : Part
        Which states take a fixed value where a guard fires.
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
    def named(self) -> dict[str, list[int]]:
        """Single places that have a name, by part."""
        parts = (part for part in vars(self).values() if isinstance(part, Part))
        return {part.name: sorted(part.used) for part in parts if part.used}
