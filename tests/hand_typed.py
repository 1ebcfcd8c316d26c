"""The paper's mechanism typed by hand from the paper, without SymPy; what both kernel and twin are held against.

Everything is written so that it also takes complex numbers: with a step of 1e-30 along the imaginary axis
the imaginary part of a result is its derivative, to rounding.
"""

import numpy as np

MODES = {"stuck": 0, "forward": 1, "backward": 2}
STATES = ("i_A", "i_B", "alpha", "omega", "alpha_gear", "omega_gear")


def right_hand_side(x, z, u, mode, q, housing, detent_orders):
    """Return (dx/dt, dz/dt, y) of the mechanism.

    Parameters
    ----------
    x : (6,) currents A, rotor rad and rad/s, output rad and rad/s
    z : (2,) housing: z in N m and z_dot / omega_0; () where it is rigid
    u : (2,) normalised voltages
    mode : "stuck", "forward" or "backward"
    q : mapping, the kernel's parameters by name
    """
    i_A, i_B, alpha, omega, _, omega_gear = x
    T_mot = motor_torque(x, q, detent_orders)
    angle = q["p"] / 2 * alpha
    di_A = (q["U"] * u[0] - q["R"] * i_A - q["k_v"] * omega * np.sin(angle)) / q["L"]
    di_B = (q["U"] * u[1] - q["R"] * i_B - q["k_v"] * omega * np.sin(angle + q["shift_B"])) / q["L"]
    T_rg = gear_torque(x, q)
    direction = {"stuck": 0.0, "forward": 1.0, "backward": -1.0}[mode]
    T_fr = q["T_frd"] * direction + q["T_visc"] * omega
    T_res = 0.0 * omega if mode == "stuck" else T_mot - T_fr - T_rg
    T_applied = q["G"] * T_rg
    dx = np.array([di_A, di_B, omega, T_res / q["J_rot"], omega_gear, T_applied / q["J_m"]])
    if housing is None:
        return dx, np.array([]), -(T_res + T_applied)
    w, zeta, K = q["omega_0"], q["zeta"], q["K_res"]
    zz, zz_dot = z[0], w * z[1]
    gain = K if housing == "paper" else 1.0
    zz_ddot = gain * w**2 * T_res - 2 * zeta * w * zz_dot - w**2 * zz
    # unit_dc: K s^2/(s^2 + 2 zeta w s + w^2) on T_res is K zz_ddot / w^2 of the filter of gain 1
    seen = zz if housing == "paper" else T_res + K * zz_ddot / w**2
    return dx, np.array([zz_dot, zz_ddot / w]), -(seen + T_applied)


def motor_torque(x, q, detent_orders):
    """Return T_A + T_B - T_D; the detents by amplitude and phase, K sin(2 pi alpha / alpha_det + phi)."""
    i_A, i_B, alpha = x[0], x[1], x[2]
    angle = q["p"] / 2 * alpha
    T = q["k_m"] * i_A * np.sin(angle) + q["k_m"] * i_B * np.sin(angle + q["shift_B"])
    for k, order in enumerate(detent_orders, start=1):
        a, b = q[f"a_{k}"], q[f"b_{k}"]
        K = np.sqrt(a * a + b * b)
        phi = 2 * np.arctan(b / (K + a))
        period = 2 * np.pi / (order * q["p"] / 2) if order else np.deg2rad(1.0) * q[f"alpha_det{k}"]
        T = T - K * np.sin(2 * np.pi * alpha / period + phi)
    return T


def gear_torque(x, q):
    """Return T_rg, the gear's torque at the rotor."""
    _, _, alpha, omega, alpha_gear, omega_gear = x
    twist, twist_rate = alpha - q["G"] * alpha_gear, omega - q["G"] * omega_gear
    return q["K_s"] / q["G"] ** 2 * twist + q["D"] / q["G"] ** 2 * twist_rate


def random_state(seed):
    """Return (x, z, u) of the size a run meets, seeded."""
    r = np.random.default_rng(seed)
    x = r.normal(size=6) * [0.5, 0.5, 2.0, 10.0, 0.04, 0.2]
    angle = r.uniform(0, 2 * np.pi)
    return x, r.normal(size=2) * 0.3, np.array([-np.cos(angle), np.sin(angle)])


def differentiated(x, z, u, mode, q, housing, detent_orders, names):
    """Return the derivatives of (dx/dt, dz/dt, y) to x, z and the named parameters, (k, 6 + len(z) + n)."""
    columns = []
    for j in range(len(x) + len(z)):
        s = np.concatenate([x, z]).astype(complex)
        s[j] += 1e-30j
        columns.append(_imaginary(s[: len(x)], s[len(x) :], u, mode, q, housing, detent_orders))
    for name in names:
        shifted = {**q, name: q[name] + 1e-30j}
        columns.append(_imaginary(x, z, u, mode, shifted, housing, detent_orders))
    return np.array(columns).T


def _imaginary(*arguments):
    dx, dz, y = right_hand_side(*arguments)
    return np.array([*dx, *dz, y], dtype=complex).imag / 1e-30
