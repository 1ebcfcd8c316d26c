"""Mechanisms on a test stand as exports are handed them, and closed forms of the stand's stages."""

from dataclasses import replace

import numpy as np

from layouts import changed, mechanism_of, paper_table
from mechid.plant.test_stand import anti_alias_response

MOVED = ("gear.stiffness", "friction.coulomb")
RELATIVE = 0.01


def bench_of(handed, changes):
    """Return a handover with another test stand, each of its parameters and `MOVED` with an error of its own."""
    own = changed(paper_table(), {"stepper": {"back_emf_constant": None}, **changes})
    mechanism = mechanism_of(own)
    stand = ("housing", "transducer", "charge_amplifier", "anti_alias")
    names = [n for n, d in mechanism.plant.declarations.items() if n.split(".")[0] in stand and not d.structural]
    sigma = [RELATIVE * abs(mechanism.value(name)) for name in (*names, *MOVED)]
    covariance = np.diag(np.square(sigma))
    alone = replace(handed.fit, folder=None, campaign=None)  # its records are of another bench
    return replace(handed, mechanism=mechanism, names=(*names, *MOVED), covariance=covariance, fit=alone)


def stage_response(stages, hertz):
    """Return what the stages of a table let through at frequencies, (n,) complex."""
    s, out = 2j * np.pi * hertz, np.ones(len(hertz), dtype=complex)
    if transducer := stages.get("transducer"):
        out *= transducer.get("gain", 1.0)
        w = transducer.get("frequency")
        if "stiffness" in transducer:
            w = np.sqrt(transducer["stiffness"] / transducer["adaptor_inertia"])
        if w is not None:
            out *= w**2 / (s**2 + 2.0 * transducer["damping"] * w * s + w**2)
    if charge := stages.get("charge_amplifier"):
        out *= charge["time_constant"] * s / (charge["time_constant"] * s + 1.0)
    if low := stages.get("anti_alias"):
        out *= anti_alias_response(low["order"], low["frequency"], hertz)
    return out
