"""Records by ngspice: windings, two H-bridges and their choppers as a circuit, the mechanism by behavioural sources.

What mechid's model has not: the bridges switch the supply at 12.5 kHz, compared with a triangle, so that a step reaches
the coils with the next edge of it, and their current ripples; friction is a steep smooth law instead of stick and slip.
Coil resistance is that of winding and two switches together.
"""

import math
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from foreign.benches import RATE_HZ, Command
from foreign.values import VALUES
from incomplete.stepping import STEPS

SUPPLY_V, CHOPPER_HZ, SWITCH_OHM = 12.0, 12_500.0, 0.05
CREEP_RATE, STRIBECK_RATE = 0.01, 0.05
"""Of friction, rad/s: where it is nearly all there, and over which it falls from static to Coulomb."""
LONGEST_STEP_S, RAMP_S = 2.5e-6, 1e-7
FACTS: Mapping[str, Any] = {
    "supply_V": SUPPLY_V,
    "chopper_Hz": CHOPPER_HZ,
    "switch_ohm": SWITCH_OHM,
    "creep_rate_rad_s": CREEP_RATE,
    "stribeck_rate_rad_s": STRIBECK_RATE,
}
NETLIST = """\
* Two-phase stepper on two choppers, rotor, gear, load, housing. States are voltages of capacitors of 1 F.
.options reltol=1e-5 abstol=1e-9 vntol=1e-9 chgtol=1e-14 method=gear maxord=2
* the command: steps so far, electrical angle in rad, duty of each phase
Btravel travel 0 V={travel}
Bsteps steps 0 V=floor(V(travel))+max(0,(V(travel)-floor(V(travel))-1)/{ramp!r}+1)
Bangle angle 0 V={angle!r}+V(steps)*{step!r}
Bduty_A duty_A 0 V=0.5-{depth!r}*cos(V(angle))
Bduty_B duty_B 0 V=0.5+{depth!r}*sin(V(angle))
Vcarrier carrier 0 PULSE(0 1 0 {half!r} {half!r} 1n {period!r})
Vsupply supply 0 {supply!r}
.model bridge SW(vt=0 vh=1e-4 ron={switch!r} roff=1e6)
{phases}
* rotor angle rad, its rate rad/s, twist of the gear in mrad at the output, rate of the load in mrad/s
Calpha alpha 0 1 IC={alpha!r}
Balpha 0 alpha I=V(omega)
Comega omega 0 1 IC=0
Bomega 0 omega I=V(resulting)/{J_rot!r}
Ctwist twist 0 1 IC=0
Btwist 0 twist I=V(omega)*{per_mrad!r}-V(load_rate)
Cload load_rate 0 1 IC=0
Bload 0 load_rate I=1e3*V(applied)/{J_m!r}
* torques in N m
Bmotor motor 0 V={k_m!r}*(I(Vsense_A)*sin({half_poles!r}*V(alpha))+I(Vsense_B)*cos({half_poles!r}*V(alpha)))
+ -{detent_1!r}*sin({detent_order_1!r}*V(alpha)+{detent_phase_1!r})
+ -{detent_2!r}*sin({detent_order_2!r}*V(alpha)+{detent_phase_2!r})
Bapplied applied 0 V=1e-3*({K_s!r}*V(twist)+{D!r}*(V(omega)*{per_mrad!r}-V(load_rate)))
Bfriction friction 0 V=tanh(V(omega)/{creep!r})*({coulomb!r}+{excess!r}*exp(-(V(omega)/{stribeck!r})**2))
+ +{viscous!r}*V(omega)
Bresulting resulting 0 V=V(motor)-V(friction)-V(applied)/{G!r}
* housing: deflection as a torque, and its rate over the natural frequency
Cz z 0 1 IC=0
Bz 0 z I={w_0!r}*V(z_rate)
Cz_rate z_rate 0 1 IC=0
Bz_rate 0 z_rate I={w_0!r}*({K_res!r}*V(resulting)-V(z)-2*{zeta!r}*V(z_rate))
By y 0 V=-(V(z)+V(applied))
.save v(y)
.control
set numdgt=12
tran {interval!r} {seconds!r} 0 {longest!r} uic
linearize v(y)
set wr_singlescale
wrdata {out} v(y)
quit
.endc
.end
"""
PHASE = """\
B{x}_gate gate_{x} 0 V=V(duty_{x})-V(carrier)
B{x}_other other_{x} 0 V=V(carrier)-V(duty_{x})
S{x}1 supply plus_{x} gate_{x} 0 bridge
S{x}2 plus_{x} 0 other_{x} 0 bridge
S{x}3 supply minus_{x} other_{x} 0 bridge
S{x}4 minus_{x} 0 gate_{x} 0 bridge
R{x} plus_{x} wound_{x} {winding!r}
L{x} wound_{x} behind_{x} {L!r} IC={current!r}
Vsense_{x} behind_{x} emf_{x} 0
B{x}_emf emf_{x} minus_{x} V={k_m!r}*V(omega)*{shape}({half_poles!r}*V(alpha))"""


def version() -> str:
    """Return ngspice's version; SystemExit where it is not there."""
    try:
        told = subprocess.run(["ngspice", "--version"], capture_output=True, text=True, check=False).stdout
    except FileNotFoundError as error:
        raise SystemExit("there is no ngspice here: install it (Debian's package is named ngspice)") from error
    return next(line for line in told.splitlines() if "ngspice-" in line).split("ngspice-")[1].split()[0]


def torque_of(command: Command, seconds: float) -> np.ndarray:
    """Return the torque of a test run, a sample every 1/RATE_HZ s, N m."""
    interval, samples = 1.0 / RATE_HZ, round(seconds * RATE_HZ) + 1
    with tempfile.TemporaryDirectory() as folder:
        circuit, out = Path(folder, "bench.cir"), Path(folder, "out.data")
        circuit.write_text(netlist(command, seconds + 2.0 * interval, interval, out))
        done = subprocess.run(["ngspice", "-b", str(circuit)], capture_output=True, text=True, check=False)
        told = done.stdout + done.stderr
        if "aborted" in told or not out.exists():
            raise SystemExit(f"ngspice: {told[-2000:]}")
        time, torque = np.loadtxt(out).T[:2]
    return np.interp(np.arange(samples) * interval, time, torque)


def netlist(command: Command, seconds: float, interval: float, out: Path) -> str:
    """Return the netlist of a test run."""
    v = VALUES
    angle = math.radians(command.get("start_angle_deg", 0.0))
    n = STEPS.get(command["stepping"]) or int(command["microsteps"])
    travel, fastest = _travel(command, n)
    currents = {"A": -v["U"] * math.cos(angle) / v["R"], "B": v["U"] * math.sin(angle) / v["R"]}
    shapes = {"A": "sin", "B": "cos"}
    winding = v["R"] - 2.0 * SWITCH_OHM
    phases = [PHASE.format(x=x, winding=winding, current=currents[x], shape=shapes[x], **v) for x in ("A", "B")]
    return NETLIST.format(
        angle=angle,
        step=0.5 * math.pi / n,
        travel=travel,
        ramp=RAMP_S * fastest,
        depth=0.5 * v["U"] / SUPPLY_V,
        period=1.0 / CHOPPER_HZ,
        half=0.5 / CHOPPER_HZ - 1e-9,
        supply=SUPPLY_V,
        switch=SWITCH_OHM,
        phases="\n".join(phases),
        alpha=angle / v["half_poles"],
        per_mrad=1e3 / v["G"],
        creep=CREEP_RATE,
        excess=v["static"] - v["coulomb"],
        stribeck=STRIBECK_RATE,
        interval=interval,
        seconds=seconds,
        longest=LONGEST_STEP_S,
        out=out,
        **v,
    )


def _travel(command: Command, n: int) -> tuple[str, float]:
    """Return the steps travelled as an expression of time, and the most of them in a second; the rate rises from 0."""
    if "rate" in command:
        rate = float(n * command["rate"])
        return f"{rate!r}*time", rate
    (_, _), (end, last) = command["rate_profile"]
    return f"{0.5 * n * last / end!r}*time*time", float(n * last)
