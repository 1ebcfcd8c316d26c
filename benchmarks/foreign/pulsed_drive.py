"""A pulsed stepper by ngspice: coils, the driver's switches and clamping diodes as a circuit, the rotor as a capacitor.

Nothing of mechid's equations is used: a coil conducts where its diodes let it, and the instants of all changes are
found by the circuit simulator's own step control. The command is typed by hand, a step each 50 ms.
"""

import math
import subprocess
import tempfile
from pathlib import Path

import numpy as np

VALUES = {"U": 12.0, "R": 9.5, "L": 0.0229, "k": 0.277, "J": 3e-5, "viscous": 1e-3, "half_poles": 50.0}
"""SI units."""
CLAMP_V = {2: 9.0, 4: 1.8}
"""That of a bridge has to be above its supply, or it would conduct while the coil is fed."""
DIODE_DROP_V = 0.0065
"""Of the circuit's diodes at 0.1 A: 0.01 kT/q ln(0.1/1e-12)."""
PULSE_S, STEP_S, SECONDS, RATE_HZ = 0.02, 0.05, 0.1, 20_000.0
RAMP_S, LONGEST_STEP_S = 1e-7, 2e-6
NETLIST = """\
* Pulsed stepper: states of the rotor are voltages of capacitors, angle in rad and rate in rad/s
.options reltol=1e-6 abstol=1e-10 vntol=1e-9 chgtol=1e-15 method=gear maxord=2
.model driver SW(vt=0.5 vh=0 ron=1e-4 roff=1e9)
.model diode D(IS=1e-12 N=0.01 RS=1e-4)
Vgate gate 0 PULSE(0 1 {step!r} {ramp!r} {ramp!r} {on!r} {step!r})
{coils}
Calpha alpha 0 1 IC={alpha!r}
Balpha 0 alpha I=V(omega)
Comega omega 0 1 IC=0
Bomega 0 omega I=({torques}-{viscous!r}*V(omega))/{J!r}
.save v(alpha) i(Vsense_A) v(wound_A)
.control
set numdgt=12
tran {interval!r} {seconds!r} 0 {longest!r} uic
linearize v(alpha) i(Vsense_A) v(wound_A)
set wr_singlescale
wrdata {out} v(alpha) i(Vsense_A) v(wound_A)
quit
.endc
.end
"""
BRIDGE = """\
Vfeed_{x} feed_{x} 0 PWL({held})
Bon_{x} on_{x} 0 V=V(gate)
S{x} feed_{x} wound_{x} on_{x} 0 driver
Vlow_{x} low_{x} 0 {low!r}
Dlow_{x} low_{x} wound_{x} diode
Vhigh_{x} high_{x} 0 {clamp!r}
Dhigh_{x} wound_{x} high_{x} diode"""
"""A coil on a bridge, which feeds it either way; two diodes clamp it."""
HALF = """\
Vfeed_{x} feed_{x} 0 {U!r}
Vduty_{x} duty_{x} 0 PWL({held})
Bon_{x} on_{x} 0 V=V(gate)*V(duty_{x})
S{x} feed_{x} wound_{x} on_{x} 0 driver
Vlow_{x} low_{x} 0 {low!r}
Dlow_{x} low_{x} wound_{x} diode"""
"""Half of a pole's winding, fed one way, with the diode that clamps it. That in series with its switch is left out:
with both the circuit simulator finds no step. No current turns here while a half is fed."""
COIL = """
R{x} wound_{x} inner_{x} {R!r}
L{x} inner_{x} sensed_{x} {L!r} IC=0
Vsense_{x} sensed_{x} emf_{x} 0
Bemf_{x} emf_{x} 0 V={k!r}*V(omega)*sin({half_poles!r}*V(alpha)+{shift!r})"""


def netlist(phases: int, out: Path) -> str:
    """Return the netlist of a motor with two coils on bridges, or with four halves."""
    v, clamp = VALUES, CLAMP_V[phases]
    start = math.radians(45.0 if phases == 2 else 0.0)
    count = round(SECONDS / STEP_S)
    coils, torques = [], []
    for number, x in enumerate("ABCD"[:phases]):
        shift = number * 0.5 * math.pi
        # The field that holds the rotor at an electrical angle: minus its cosine, a quarter turn apart.
        duties = [-math.cos(start + 0.5 * math.pi * k + shift) for k in range(count + 1)]
        held = [v["U"] * duty if phases == 2 else float(duty > 0.5) for duty in duties]
        points = [(0.0, held[0])]
        for k in range(1, count + 1):
            points += [(k * STEP_S - RAMP_S, held[k - 1]), (k * STEP_S, held[k])]
        text = " ".join(f"{t!r} {value!r}" for t, value in points)
        own = BRIDGE if phases == 2 else HALF
        coils.append((own + COIL).format(x=x, held=text, low=-clamp, clamp=clamp, shift=shift, **v))
        torques.append(f"{v['k']!r}*I(Vsense_{x})*sin({v['half_poles']!r}*V(alpha)+{shift!r})")
    return NETLIST.format(
        coils="\n".join(coils),
        torques="+".join(torques),
        alpha=start / v["half_poles"],
        step=STEP_S,
        on=PULSE_S,
        ramp=RAMP_S,
        interval=1.0 / RATE_HZ,
        seconds=SECONDS + 2.0 / RATE_HZ,
        longest=LONGEST_STEP_S,
        out=out,
        **{key: v[key] for key in ("viscous", "J")},
    )


def run(phases: int) -> dict[str, np.ndarray]:
    """Return rotor angle in rad, current in A and voltage in V of coil A, (N,) each, a sample every 1/RATE_HZ s."""
    with tempfile.TemporaryDirectory() as folder:
        circuit, out = Path(folder, "pulsed.cir"), Path(folder, "out.data")
        circuit.write_text(netlist(phases, out))
        done = subprocess.run(["ngspice", "-b", str(circuit)], capture_output=True, text=True, check=False)
        said = done.stdout + done.stderr
        if "aborted" in said or not out.exists():
            raise SystemExit(f"ngspice: {said[-2000:]}")
        time, *columns = np.loadtxt(out).T[:4]
    at = np.arange(round(SECONDS * RATE_HZ) + 1) / RATE_HZ
    names = ("rotor_angle", "current_phase_a", "voltage_phase_a")
    return {name: np.interp(at, time, column) for name, column in zip(names, columns, strict=True)}
