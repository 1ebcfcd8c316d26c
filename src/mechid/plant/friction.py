"""Friction laws: Coulomb, Stribeck, directional and load-dependent as set-valued friction; LuGre with a state.

A law acts at a `Site`, the rotor or the output. It supplies `T_fr` and `free` to the body's equation of motion,
J domega/dt = free (T_drive - T_fr), where `free` is 0 while friction holds the body.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

from sympy import Expr, Float, Symbol, exp

from mechid.parameter import Declaration, Role
from mechid.plant.block import Block, Extension, Guard, Rival, Switch
from mechid.plant.start import start as own_start

ARMSTRONG = "Armstrong, Dupont, Canudas de Wit, Automatica 30 (1994) 1083-1138"
LUGRE = "Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans. Automatic Control 40 (1995) 419-425"
KORNIENKO = "Kornienko2013"
_size = partial(Declaration, lower=0.0)


@dataclass(frozen=True, kw_only=True)
class Site:
    """Location of a friction: its table and symbols, its units, and its reference magnitudes.

    Parameters
    ----------
    table : str
        Table of the mechanism file and name of the block.
    suffix : str
        Distinguishes this site's symbols from those of another, e.g. ``"_out"``.
    omega : Symbol
        The body's speed, a state of the plant.
    torque, viscous, rate : str
        Units of a friction torque (or force), of its viscous part, of a speed.
    holding, damping : str or None
        Reference torque and damping, as expressions in the file's symbols, of which friction is a fraction.
    """

    table: str = "friction"
    suffix: str = ""
    omega: Symbol = field(default_factory=lambda: Symbol("omega"))
    torque: str = "N m"
    viscous: str = "N m s/rad"
    rate: str = "rad/s"
    holding: str | None = "k_m*U/R"
    damping: str | None = "k_m*k_v/R"

    def symbol(self, name: str) -> Symbol:
        """Return the site's symbol of that name."""
        return Symbol(f"{name}{self.suffix}")

    @property
    def sigma(self) -> Symbol:
        """Direction of sliding, 1 or -1; 0 while stuck."""
        return self.symbol("sigma")

    @property
    def drive(self) -> Symbol:
        """The torque that friction has to hold at rest."""
        return self.symbol("T_drive")

    @property
    def load(self) -> Symbol:
        """The torque that the gear transmits at this site."""
        return Symbol("T_applied" if self.suffix else "T_rg")


ROTOR = Site()
OUTPUT = Site(table="output_friction", suffix="_out", omega=Symbol("omega_gear"))


def set_valued(
    site: Site,
    declarations: tuple[Declaration, ...],
    *,
    sliding: Expr,
    holds: tuple[Expr, Expr],
    inputs: tuple[Symbol, ...] = (),
    reference: str = KORNIENKO,
) -> Block:
    """Return set-valued friction: stuck while -holds[1] <= T_drive <= holds[0], else T_fr = `sliding`.

    Parameters
    ----------
    site : Site
    declarations : tuple of Declaration
    sliding : Expr
        Friction torque while sliding, a function of the site's `sigma` (direction, 1 or -1) and `omega`.
    holds : (Expr, Expr)
        Largest torque held at rest, against forward and against backward motion. Neither may be below
        `sliding` at zero speed, else the body would be caught at the instant of its release.
    inputs : tuple of Symbol
        Further symbols of the expressions, wired by name (suffix ``_in``).
    """
    free, sigma, omega, T_fr = site.symbol("free"), site.sigma, site.omega, site.symbol("T_fr")
    drive = Symbol(f"{site.drive}_in")
    at_rest = {omega: 0.0}
    switch = Switch(
        name=site.table,
        modes={
            "stuck": {free: 0.0, sigma: 0.0},
            "forward": {free: 1.0, sigma: 1.0},
            "backward": {free: 1.0, sigma: -1.0},
        },
        guards={
            "stuck": (
                Guard(margin=holds[0] - drive, target="forward"),
                Guard(margin=holds[1] + drive, target="backward"),
            ),
            "forward": (Guard(margin=omega, resets=at_rest),),
            "backward": (Guard(margin=-omega, resets=at_rest),),
        },
        entry=(
            # A moving body slides in its direction; one at rest slides only if the drive exceeds the hold.
            (omega, "forward"),
            (-omega, "backward"),
            (drive - holds[0], "forward"),
            (-drive - holds[1], "backward"),
        ),
        otherwise="stuck",
        ideal={free: 1.0, sigma: 0.0},
    )
    return Block(
        name=site.table,
        table=site.table,
        declarations=declarations,
        inputs=(drive, *inputs),
        terms={T_fr: sliding},
        outputs={T_fr.name: T_fr, free.name: free},
        switch=switch,
        reference=reference,
    )


def coulomb(site: Site) -> Block:
    """Coulomb friction, viscous friction and stiction: T_fr = T_frd sign(omega) + T_visc omega, held up to T_frs.

    Equation (8) of [Kornienko2013]_, interpreted as set-valued: the rotor is stuck while |T_mot - T_rg| <= T_frs;
    N m, rad/s. `free` is 0 in the stuck mode and 1 in the sliding ones, `sigma` is the direction of sliding.
    """
    T_frs, T_frd, T_visc = map(site.symbol, ("T_frs", "T_frd", "T_visc"))
    block = set_valued(site, _levels(site), sliding=T_frd * site.sigma + T_visc * site.omega, holds=(T_frs, T_frs))
    asymmetry = Extension(
        name=f"{site.table}.directional",
        words="friction differs between the two directions",
        table=site.table,
        law="directional",
        widths={"asymmetry": Float(0.1), "viscous_asymmetry": Float(0.1)},
    )
    falling = Rival(
        name=f"{site.table}.stribeck",
        words="friction falls with speed (Stribeck)",
        table=site.table,
        law="stribeck",
        free={"stribeck_rate": (Float(1.5), Float(0.05), Float(50.0))},
    )
    return replace(block, extensions=(asymmetry,), rivals=(falling,))


def stribeck(site: Site) -> Block:
    """Stribeck friction: T_fr = sign(omega) (T_frd + (T_frs - T_frd) exp(-(omega/omega_s)^2)) + T_visc omega.

    Armstrong et al. (1994), with exponent 2; held up to T_frs, from which the torque falls continuously.
    """
    T_frs, T_frd, T_visc, omega_s = map(site.symbol, ("T_frs", "T_frd", "T_visc", "omega_s"))
    level = T_frd + (T_frs - T_frd) * exp(-((site.omega / omega_s) ** 2))
    return set_valued(
        site,
        (*_levels(site), _stribeck_rate(site, omega_s, ARMSTRONG)),
        sliding=level * site.sigma + T_visc * site.omega,
        holds=(T_frs, T_frs),
        reference=ARMSTRONG,
    )


def directional(site: Site) -> Block:
    """Directional friction: T_fr = (sign(omega) + a) T_frd + (1 + a_v sign(omega)) T_visc omega.

    Coulomb and static friction are (1 + a) times the file's forward and (1 - a) times backward, viscous friction
    (1 + a_v) and (1 - a_v) times; forward is the direction of positive speed. Armstrong et al. (1994).
    """
    T_frs, T_frd, T_visc, a, a_v = map(site.symbol, ("T_frs", "T_frd", "T_visc", "a_fr", "a_visc"))
    share = partial(Declaration, unit="1", lower=-1.0, upper=1.0, source=ARMSTRONG)
    dry = "half the difference of dry friction between forward and backward, over its mean"
    own = (
        share(key="asymmetry", symbol=a.name, meaning=dry),
        share(key="viscous_asymmetry", symbol=a_v.name, meaning="the same of viscous friction", default=0.0),
    )
    sigma, omega = site.sigma, site.omega
    return set_valued(
        site,
        (*_levels(site), *own),
        sliding=T_frd * (sigma + a) + T_visc * (1 + a_v * sigma) * omega,
        holds=(T_frs * (1 + a), T_frs * (1 - a)),
        reference=ARMSTRONG,
    )


def load_dependent(site: Site) -> Block:
    """Friction that increases with the transmitted torque: T_frd + mu |T_rg| sliding, T_frs + mu |T_rg| at rest.

    Armstrong et al. (1994). The sign of T_rg is a second switch (`load_side`), so that its zeros are located exactly.
    """
    T_frs, T_frd, T_visc, mu, side = map(site.symbol, ("T_frs", "T_frd", "T_visc", "mu_fr", "side"))
    load = Symbol(f"{site.load}_in")
    share = _size("load_share", mu.name, "1", "friction torque over transmitted torque", source=ARMSTRONG)
    added = mu * side * load
    return set_valued(
        site,
        (*_levels(site), share),
        sliding=site.sigma * (T_frd + added) + T_visc * site.omega,
        holds=(T_frs + added, T_frs + added),
        inputs=(load, Symbol(f"{side}_in")),
        reference=ARMSTRONG,
    )


def load_side(site: Site) -> Block:
    """Sign of the torque that the gear transmits, as a switch: `side` is 1 or -1."""
    side, load = site.symbol("side"), Symbol(f"{site.load}_in")
    switch = Switch(
        name=f"{site.table}.side",
        modes={"positive": {side: 1.0}, "negative": {side: -1.0}},
        guards={
            "positive": (Guard(margin=load, target="negative"),),
            "negative": (Guard(margin=-load, target="positive"),),
        },
        entry=((-load, "negative"),),
        otherwise="positive",
        ideal={side: 0.0},
    )
    return Block(
        name=f"{site.table}_side",
        table=site.table,
        inputs=(load,),
        outputs={side.name: side},
        switch=switch,
        reference=ARMSTRONG,
    )


def lugre(site: Site) -> Block:
    """LuGre friction: z' = omega - s_0 |omega| z / g, T_fr = s_0 z + s_1 z' + T_visc omega.

    g = T_frd + (T_frs - T_frd) exp(-(omega/omega_s)^2); z is the mean deflection of the bristles in rad, s_0 their
    stiffness in N m/rad and s_1 their damping in N m s/rad. Canudas de Wit et al. (1995). The body never sticks, it
    creeps within the bristles; the zeros of the speed, where |omega| has its kink, are located exactly.
    """
    T_frs, T_frd, T_visc, omega_s = map(site.symbol, ("T_frs", "T_frd", "T_visc", "omega_s"))
    s_0, s_1, z, g = map(site.symbol, ("s_0", "s_1", "z_fr", "g_fr"))
    slip, T_fr, direction = map(site.symbol, ("slip", "T_fr", "direction"))
    omega, displacement = site.omega, site.rate.removesuffix("/s")
    own = (
        _stribeck_rate(site, omega_s, LUGRE),
        _size("bristle_stiffness", s_0.name, f"{site.torque}/{displacement}", "stiffness before sliding", source=LUGRE),
        _size("bristle_damping", s_1.name, site.viscous, "damping before sliding", default=0.0, source=LUGRE),
    )
    z_0 = Symbol(f"{z}_start")
    switch = Switch(
        name=site.table,
        modes={"forward": {direction: 1.0}, "backward": {direction: -1.0}},
        guards={
            "forward": (Guard(margin=omega, target="backward"),),
            "backward": (Guard(margin=-omega, target="forward"),),
        },
        entry=((-omega, "backward"),),
        otherwise="forward",
        ideal={direction: 0.0},
    )
    return Block(
        name=site.table,
        table=site.table,
        declarations=(*_levels(site), *own),
        terms={
            g: T_frd + (T_frs - T_frd) * exp(-((omega / omega_s) ** 2)),
            slip: omega - s_0 * direction * omega * z / g,
            T_fr: s_0 * z + s_1 * slip + T_visc * omega,
        },
        rates={z: slip},
        initial={z: z_0},
        starts=(own_start("bristle", z_0, displacement, "deflection of the bristles at the start", f"{T_frs}/{s_0}"),),
        outputs={T_fr.name: T_fr, site.symbol("free").name: 1},
        switch=switch,
        reference=LUGRE,
    )


def dry_output(site: Site) -> Block:
    """Friction at the output: T_fr = T_c sign(omega) + T_v omega, held up to T_c + T_s.

    As `coulomb`, but with static friction given by its excess over Coulomb friction, 0 by default.
    """
    T_c, T_s, T_v = (Symbol(f"{name}{site.suffix}") for name in ("T_frd", "T_stick", "T_visc"))
    declarations = (
        _size("coulomb", T_c.name, site.torque, "Coulomb friction"),
        _size("stiction", T_s.name, site.torque, "static friction above Coulomb friction", default=0.0),
        _size("viscous", T_v.name, site.viscous, "viscous friction", default=0.0),
    )
    return set_valued(site, declarations, sliding=T_c * site.sigma + T_v * site.omega, holds=(T_c + T_s, T_c + T_s))


def _levels(site: Site) -> tuple[Declaration, ...]:
    """Return the declarations of static, Coulomb and viscous friction, common to all laws at the rotor."""
    names = [site.symbol(name).name for name in ("T_frs", "T_frd", "T_visc")]
    dry, shares = partial(_size, unit=site.torque, role=Role.DRY_FRICTION), partial(_shares, site.holding)
    return (
        dry(
            key="static",
            symbol=names[0],
            meaning="static friction",
            typical=shares(0.002, 0.1),
            above="coulomb",
            tied_to="coulomb",
        ),
        dry(key="coulomb", symbol=names[1], meaning="Coulomb friction", typical=shares(0.002, 0.15)),
        _size("viscous", names[2], site.viscous, "viscous friction", typical=_shares(site.damping, 0.02, 2.0)),
    )


def _shares(scale: str | None, least: float, most: float) -> tuple[str, float, float] | None:
    """Return the typical range of a level relative to its scale; None if a site has no scale."""
    return (scale, least, most) if scale else None


def _stribeck_rate(site: Site, symbol: Symbol, source: str) -> Declaration:
    meaning = "speed over which static falls to Coulomb friction"
    return _size("stribeck_rate", symbol.name, site.rate, meaning, source=source)


Law = Callable[[Site], tuple[Block, ...]]


def _alone(law: Callable[[Site], Block]) -> Law:
    return lambda site: (law(site),)


LAWS: Mapping[str, Law] = {
    "coulomb": _alone(coulomb),
    "stribeck": _alone(stribeck),
    "directional": _alone(directional),
    "load_dependent": lambda site: (load_dependent(site), load_side(site)),
    "lugre": _alone(lugre),
}
"""Friction laws of the rotor by their names in mechanism.toml; the first is the paper's."""
UNGEARED_LAWS: Mapping[str, Law] = {name: law for name, law in LAWS.items() if name != "load_dependent"}
"""Friction laws that need no transmitted torque."""
