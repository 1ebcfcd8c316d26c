"""A stepper whose rotor follows each step at once, with a load that swings on its gear, and the swing of that load."""

import math

import numpy as np

import mechid

MODE_HZ = 5.0


def stiff_motor(gear, inertia):
    """Return the paper's mechanism without detents and dry friction, with a motor far stiffer than a given gear."""
    detents = [{"period_deg": period, "amplitude": 0.0, "phase_deg": 0.0} for period in (1.8, 3.6)]
    stepper = {
        "poles": 100,
        "peak_voltage": 5.7,
        "rotor_inertia": 8.9e-6,
        "coil_resistance": 9.5,
        "coil_inductance": 1e-3,
        "torque_constant": 50.0,
        "back_emf_constant": 1e-6,
        "detent": detents,
    }
    return mechid.make_mechanism(
        {
            "stepper": stepper,
            "friction": {"static": 0.0, "coulomb": 0.0, "viscous": 0.15},
            "gear": gear,
            "load": {"inertia": inertia},
            "housing": {"gain": 4.6, "frequency": 5578.0, "damping": 0.095},
        }
    )


def with_mode(damping):
    """Return a stiff motor with a load that swings at `MODE_HZ` with a given damping ratio."""
    K = 2200.0
    J = K / (2.0 * math.pi * MODE_HZ) ** 2
    return stiff_motor({"ratio": 50, "stiffness": K, "damping": 2.0 * damping * math.sqrt(K * J)}, J)


def swing(mechanism, times_s, damping):
    """Return the amplitude of the load's swing just after the last step: the decaying mode, fitted to the torque."""
    planned = mechid.make_record("a", command=mechid.make_command("full", step_times=times_s))
    run = mechid.simulate(mechid.make_campaign(mechanism, [planned]), sample_rate_hz=2000.0, duration_s=1.0)
    after = np.asarray(run.time) - times_s[-1]
    used = after > 0.02
    omega = 2.0 * math.pi * MODE_HZ
    t, damped = after[used], omega * math.sqrt(1.0 - damping**2)
    decay = np.exp(-damping * omega * t)
    waves = np.stack((decay * np.cos(damped * t), decay * np.sin(damped * t), np.ones_like(t)), axis=1)
    return math.hypot(*np.linalg.lstsq(waves, run.torque[used], rcond=None)[0][:2])


def pair_over_step(damping):
    """Return the swing after a pair of steps over that after one step."""
    mechanism, pair = with_mode(damping), mechid.paired_steps(1, 4.0, MODE_HZ, damping)
    return swing(mechanism, pair, damping) / swing(mechanism, pair[:1], damping)


def pair_over_step_in_closed_form(damping):
    """Return 1 - exp(-pi zeta/sqrt(1 - zeta^2))."""
    return 1.0 - math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))
