"""Dry friction that varies with the angle of the rotor, also by direction, or of the output, for any friction law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from sympy import Expr, Float, Integer, Symbol, sympify

from mechid.errors import InputFileError
from mechid.plant.block import Block, Extension, Series, Switch
from mechid.plant.drive_train import PER_STEP, G, alpha, alpha_gear
from mechid.plant.friction import Site
from mechid.plant.harmonic import ListedHarmonic, coordinates_of
from mechid.plant.layout import Layout

ARMSTRONG = "Armstrong, Dupont, Canudas de Wit, Automatica 30 (1994) 1083-1138"


@dataclass(frozen=True, kw_only=True)
class _Over:
    """An angle over which friction varies: its table, the rotating part, the angle, its turns per rotor turn, orders.

    `most` is the highest order that growth tries: bearings of the rotor run out and its halves do not align; a large
    output bearing has about that many balls. `mode` is the sliding mode in which it varies, empty for both.
    """

    table: str
    what: str
    angle: Symbol
    turns: Expr
    letters: tuple[str, str, str, str, str]
    looked_for: tuple[int, ...]
    most: int
    name: str
    mode: str = ""

    def harmonics(self, count: int) -> tuple[ListedHarmonic, ...]:
        """Return a number of harmonics of the friction level over this angle; their orders are values of the kernel."""
        return tuple(
            ListedHarmonic(
                table=self.table,
                index=index,
                order=None,
                letters=self.letters,
                unit="1",
                most=1.0,
                turns=self.turns,
                source=ARMSTRONG,
                meanings=(
                    f"periods of dry friction {self.mode} per turn of the {self.what}".replace("  ", " "),
                    "amplitude of the variation over the mean of dry friction",
                    "phase of the variation",
                ),
            )
            for index in range(count)
        )

    def extension(self, order: int) -> Extension:
        """Return a harmonic that may be added, with 20 % of dry friction."""
        return Extension(
            name=f"{self.name}:{order}",
            words=f"dry friction{self._of_mode} varies with the angle of the {self.what}, {{order:g}} per turn",
            table=self.table,
            structure={"order": Integer(order)},
            widths={"amplitude": Float(0.2)},
            grown=False,
        )

    @property
    def _of_mode(self) -> str:
        return f" {self.mode} alone" if self.mode else ""

    @property
    def extensions(self) -> tuple[Extension, ...]:
        """The harmonics that are tested against a finished fit in addition."""
        return tuple(map(self.extension, self.looked_for))

    @property
    def series(self) -> Series:
        """The harmonics of any order up to the highest."""
        return Series(per_step=self.turns * PER_STEP, entry=self.extension, most=self.most, is_line=False)


ROTOR = _Over(
    table="friction.position",
    what="rotor",
    angle=alpha,
    turns=Integer(1),
    looked_for=(1, 2),
    most=8,
    letters=("n_f", "A_f", "phi_f", "c_f", "s_f"),
    name="friction.position",
)
FORWARD = _Over(
    table="friction.position_forward",
    what="rotor",
    angle=alpha,
    turns=Integer(1),
    looked_for=(1, 2),
    most=0,
    letters=("n_p", "A_p", "phi_p", "c_p", "s_p"),
    name="friction.position:forward",
    mode="forward",
)
BACKWARD = replace(
    FORWARD,
    table="friction.position_backward",
    # Friction that varies the same both ways, and forward in addition, is free in both directions.
    looked_for=(),
    letters=("n_q", "A_q", "phi_q", "c_q", "s_q"),
    name="friction.position:backward",
    mode="backward",
)
OUTPUT = _Over(
    table="friction.output_position",
    what="output",
    angle=alpha_gear,
    turns=1 / G,
    looked_for=(1,),
    most=100,
    letters=("n_g", "A_g", "phi_g", "c_g", "s_g"),
    name="friction.position:output",
)


def vary_with_angle(law: tuple[Block, ...], site: Site, layout: Layout, *, geared: bool) -> tuple[Block, ...]:
    """Return a friction law with varying static and Coulomb friction: each times 1 + sum A_n sin(n x + phi_n).

    x is the angle of the rotor or of the output and n an integer, so that friction repeats with each turn. Armstrong et
    al. (1994), section 2. Static friction keeps its ratio to Coulomb friction. Harmonics of `FORWARD` and `BACKWARD`
    count in their direction of sliding alone, and for the torque held against it.

    Parameters
    ----------
    law : tuple of Block
        The blocks of the law; that of the site first.
    site : Site
    layout : Layout
    geared : bool
        Whether there is an output in addition to the rotor.

    Raises
    ------
    InputFileError
        The layout has such a list although the axis slides, there is no output, or friction is the user's own block.
    """
    turning = site.rate == "rad/s"
    _refuse(layout, turning=turning, geared=geared)
    first, *rest = law
    over = [ROTOR, OUTPUT] if geared else [ROTOR]
    # By direction is tried where friction varies with the angle at all: records in one direction cannot tell.
    listed = [*over, FORWARD] if layout.count(ROTOR.table) else over
    beside = tuple(e for one in listed if turning for e in one.extensions)
    series = tuple(one.series for one in over if turning)
    first = replace(first, extensions=(*first.extensions, *beside), series=(*first.series, *series))
    found = [(one, h) for one in (*over, FORWARD, BACKWARD) for h in one.harmonics(layout.count(one.table))]
    return (_vary(first, site, found) if found else first, *rest)


def _vary(law: Block, site: Site, found: Sequence[tuple[_Over, ListedHarmonic]]) -> Block:
    """Return a law whose levels of dry friction are multiplied by a function of the angles, also by direction."""
    harmonics = [h for _, h in found]
    level, levels = _levels(law, site, found)
    # One factor for both levels: static friction keeps its ratio to Coulomb friction.
    varied = {mode: {s: s * own for s in map(site.symbol, ("T_frs", "T_frd"))} for mode, own in level.items()}
    terms = {symbol: sympify(e).xreplace(varied[""]) for symbol, e in law.terms.items()}
    return replace(
        law,
        declarations=(*law.declarations, *(d for h in harmonics for d in h.declarations)),
        coordinates={**law.coordinates, **coordinates_of(harmonics)},
        polar=(*law.polar, *(h.polar for h in harmonics)),
        terms={**levels, **terms},
        # The guards compare with the same levels and vary with them.
        switch=_vary_switch(law.switch, varied) if law.switch else None,
    )


def _levels(
    law: Block, site: Site, found: Sequence[tuple[_Over, ListedHarmonic]]
) -> tuple[dict[str, Symbol], dict[Symbol, Expr]]:
    """Return the factor on dry friction by the mode that sliding would have, "" for the present one, and its terms."""

    def total(*modes: str) -> Expr:
        return 1 + sum((h.over(one.angle) for one, h in found if one.mode in modes), Integer(0))

    level = site.symbol("level_fr")
    if not any(one.mode for one, _ in found):
        return dict.fromkeys(("", FORWARD.mode, BACKWARD.mode), level), {level: total("")}
    up, down = site.symbol("level_forward"), site.symbol("level_backward")
    assert law.switch is not None
    # LuGre friction has a direction of its own name, and never sticks.
    sign = next(s for s in law.switch.modes[FORWARD.mode] if s in (site.sigma, site.symbol("direction")))
    terms = {up: total("", FORWARD.mode), down: total("", BACKWARD.mode)}
    terms[level] = ((1 + sign) * up + (1 - sign) * down) / 2
    return {"": level, FORWARD.mode: up, BACKWARD.mode: down}, terms


def _vary_switch(switch: Switch, varied: Mapping[str, Mapping[Symbol, Expr]]) -> Switch:
    """Return the switch of a law: what is held against a direction is the level in that direction."""

    def of(margin: Expr, target: str | None) -> Expr:
        target = target or ""
        return sympify(margin).xreplace(varied.get(target, varied[""]))

    guards = {
        mode: tuple(replace(guard, margin=of(guard.margin, guard.target)) for guard in guards)
        for mode, guards in switch.guards.items()
    }
    return replace(switch, guards=guards, entry=tuple((of(e, mode), mode) for e, mode in switch.entry))


def _refuse(layout: Layout, *, turning: bool, geared: bool) -> None:
    there = next((one.table for one in (OUTPUT, ROTOR, FORWARD, BACKWARD) if layout.orders.get(one.table)), "")
    if there and ROTOR.table.partition(".")[0] in layout.own:
        raise InputFileError(
            f"{there}: stands beside a friction of your own, which does not know of it; write the "
            "variation into your block, or take a law of the library"
        )
    if there and not turning:
        raise InputFileError(f"{there}: is per turn, and this axis slides; delete it")
    if there == OUTPUT.table and not geared:
        raise InputFileError(f"{there}: there is no gear, the output is the rotor; write [[{ROTOR.table}]]")
