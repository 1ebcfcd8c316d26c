"""The library's blocks typed by hand from their references, without SymPy: what kernel and twin are held against."""

import numpy as np


def friction_torque(law, direction, omega, T_rg, z, q):
    """Return T_fr while sliding in a direction (or LuGre's at any speed), and what is held at rest either way."""
    if law == "stribeck":
        level = q["T_frd"] + (q["T_frs"] - q["T_frd"]) * np.exp(-((omega / q["omega_s"]) ** 2))
        return level * direction + q["T_visc"] * omega, (q["T_frs"], q["T_frs"])
    if law == "directional":
        up, down = 1 + q["a_fr"], 1 - q["a_fr"]
        dry = q["T_frd"] * up if direction > 0 else -q["T_frd"] * down
        damp = q["T_visc"] * (1 + q["a_visc"] if direction > 0 else 1 - q["a_visc"])
        return dry + damp * omega, (q["T_frs"] * up, q["T_frs"] * down)
    if law == "load_dependent":
        extra = q["mu_fr"] * abs(T_rg)
        held = q["T_frs"] + extra
        return direction * (q["T_frd"] + extra) + q["T_visc"] * omega, (held, held)
    if law == "lugre":
        g = q["T_frd"] + (q["T_frs"] - q["T_frd"]) * np.exp(-((omega / q["omega_s"]) ** 2))
        slip = omega - q["s_0"] * abs(omega) * z / g
        return q["s_0"] * z + q["s_1"] * slip + q["T_visc"] * omega, slip
    return q["T_frd"] * direction + q["T_visc"] * omega, (q["T_frs"], q["T_frs"])


def varied_friction(orders, output_orders, of_direction, alpha, alpha_gear, direction, q):
    """Return the parameters with static and Coulomb friction as they are at some angles of rotor and output.

    `of_direction` are the orders forward and backward: of these, those of the direction count.
    """
    level, (forward, backward) = 1.0, of_direction
    own = ("p", alpha, forward) if direction > 0 else ("q", alpha, backward)
    for letter, angle, some in (("f", alpha, orders), ("g", alpha_gear, output_orders), own):
        for j, n in enumerate(some, start=1):
            c, s = q[f"c_{letter}{j}"], q[f"s_{letter}{j}"]
            level += np.hypot(c, s) * np.sin(n * angle + np.arctan2(s, c))
    return {**q, "T_frs": level * q["T_frs"], "T_frd": level * q["T_frd"]}


def output_torque(law, twist, twist_rate, q):
    """Return the gear's torque at the output: the catalogue's broken line, or nothing in the backlash's gap."""
    if law == "piecewise_linear":
        bends = np.cumsum([q["T_s1"] / q["K_s1"], (q["T_s2"] - q["T_s1"]) / q["K_s2"]])
        beyond = abs(twist) - bends[1]
        if beyond > 0:
            size = q["T_s2"] + q["K_s3"] * beyond
        else:
            size = np.interp(abs(twist), [0, *bends], [0, q["T_s1"], q["T_s2"]])
        return np.sign(twist) * size + q["D"] * twist_rate
    if law == "backlash":
        free = abs(twist) < q["b_gap"] / 2
        return 0.0 if free else q["K_s"] * (twist - np.sign(twist) * q["b_gap"] / 2) + q["D"] * twist_rate
    return q["K_s"] * twist + q["D"] * twist_rate


def kinematics(alpha, omega, alpha_gear, omega_gear, orders, q):
    """Return twist, its rate, and the lever 1/G + e'(alpha), with e = sum E sin(k alpha + phi)."""
    error, slope = 0.0, 0.0
    for j, k in enumerate(orders, start=1):
        E, phi = np.hypot(q[f"e_c{j}"], q[f"e_s{j}"]), np.arctan2(q[f"e_s{j}"], q[f"e_c{j}"])
        error += E * np.sin(k * alpha + phi)
        slope += E * k * np.cos(k * alpha + phi)
    lever = 1 / q["G"] + slope
    return alpha / q["G"] + error - alpha_gear, lever * omega - omega_gear, lever


def stiffness_variation(alpha, orders, q):
    """Return the variation of the stiffness over its mean, sum V sin(k alpha + phi), and its slope."""
    variation, slope = 0.0, 0.0
    for j, k in enumerate(orders, start=1):
        V, phi = np.hypot(q[f"v_c{j}"], q[f"v_s{j}"]), np.arctan2(q[f"v_s{j}"], q[f"v_c{j}"])
        variation += V * np.sin(k * alpha + phi)
        slope += V * k * np.cos(k * alpha + phi)
    return variation, slope


def driven(e, orders, q):
    """Return the waveforms of a driver whose microstep table is off, from those commanded."""
    theta, delta = np.arctan2(e[1], -e[0]), 0.0
    for j, n in enumerate(orders, start=1):
        A, phi = np.hypot(q[f"c_m{j}"], q[f"s_m{j}"]), np.arctan2(q[f"s_m{j}"], q[f"c_m{j}"])
        delta += A * np.sin(n * theta + phi)
    turned, longer = theta + np.arctan(delta), np.hypot(1.0, delta)
    return longer * np.array([-np.cos(turned), np.sin(turned)])


def supplied(e, i, q):
    """Return the voltages of both bridges: the power that they take is what the source gives at its lower voltage."""
    drawn = e[0] * i[0] + e[1] * i[1]
    return (q["U"] - q.get("R_s", 0.0) * drawn) * e


def winding_rates(i, u, alpha, omega, q, harmonics=()):
    """Return (di_A/dt, di_B/dt, torque) of two phases apart: A is (1 + r), B is (1 - r) times the mean."""
    rates, torque = [], 0.0
    for sign, x, shift in ((1, 0, 0.0), (-1, 1, q["shift_B"])):
        angle = q["p"] / 2 * alpha + shift
        shape = np.sin(angle)
        for j, h in enumerate(harmonics, start=1):
            C, phi = np.hypot(q[f"c_h{j}"], q[f"s_h{j}"]), np.arctan2(q[f"s_h{j}"], q[f"c_h{j}"])
            shape += C * np.sin(h * angle + phi)
        r = {name: 1 + sign * q.get(f"r_{name}", 0.0) for name in "RLk"}
        offset = q.get("u_0A" if sign > 0 else "u_0B", 0.0)
        emf = q["k_v"] * r["k"] * omega * shape
        # L (1 + s cos 2 angle): by the chain rule dL/dt = dL/dangle p/2 omega, and the torque is dL/dalpha i^2/2
        inductance = q["L"] * r["L"] * (1 + q.get("s_L", 0.0) * np.cos(2 * angle))
        slope = q["L"] * r["L"] * q.get("s_L", 0.0) * -2 * np.sin(2 * angle) * q["p"] / 2
        rates.append((u[x] + offset - q["R"] * r["R"] * i[x] - emf - slope * omega * i[x]) / inductance)
        torque += q["k_m"] * r["k"] * i[x] * shape + slope * i[x] ** 2 / 2
    return *rates, torque


def detents_over_temperature(q):
    """Return the factor of the detents: 0.2 % less for each kelvin has to be -0.002 a kelvin."""
    return 1.0 + q.get("c_detent", 0.0) * q.get("dT_motor", 0.0)


def detent_lag(omega, h, q):
    """Return the torque of the detents' hysteresis, and the rate of its share h over p/2 times the rotor's way."""
    if "T_hd" not in q:
        return 0.0, 0.0
    return q["T_hd"] * h, (q["p"] / 2 * omega - h * np.abs(q["p"] / 2 * omega)) / np.radians(q["theta_hd"])


def load_torques(law, alpha_gear, omega_gear, h, q):
    """Return the torque of the cables, the rate of their hysteresis, and the torque of the load's weight."""
    cable = q["K_c"] * (alpha_gear - q["alpha_c"]) if law.startswith("cable") else 0.0
    if law == "cable":
        cable += q["T_h"] * h
        h_rate = omega_gear * (1 - np.sign(omega_gear) * h) / q["theta_h"]
    else:
        h_rate = 0.0
    weight = 0.0
    if law == "unbalance":
        weight = np.hypot(q["W_c"], q["W_s"]) * np.sin(alpha_gear + np.arctan2(q["W_s"], q["W_c"]))
    return cable, h_rate, weight


def flexible_load(T_applied, x_modes, q):
    """Return the accelerations of hub and modes, from the equations of motion as one linear system.

    Unknowns a, q_1'', ...: J_m a + sum J_k q_k'' = T_applied (momentum of the whole), q_k'' + a = -2 z w q' - w^2 q.
    """
    n = len(x_modes)
    M, f = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
    M[0, 0], f[0] = q["J_m"], T_applied
    for k, (deflection, rate) in enumerate(x_modes, start=1):
        w, zeta = q[f"omega_{k}"], q[f"zeta_{k}"]
        M[0, k] = q[f"J_{k}"]
        M[k, 0] = M[k, k] = 1.0
        f[k] = -2 * zeta * w * rate - w**2 * deflection
    return np.linalg.solve(M, f)


def housing_response(s, T_res, form, modes):
    """Return what a transducer sees at s = j w of a torque behind a housing of modes (gain, frequency, damping)."""
    if form == "paper":
        return sum(K * w**2 / (s**2 + 2 * zeta * w * s + w**2) for K, w, zeta in modes) * T_res
    return (1 + sum(K * s**2 / (s**2 + 2 * zeta * w * s + w**2) for K, w, zeta in modes)) * T_res


def stand_response(s, T, q, order):
    """Return the response at s = j w of transducer, charge amplifier and Butterworth low-pass to a torque T."""
    w_t = q["omega_t"]
    y = q["g_y"] * w_t**2 / (s**2 + 2 * q["zeta_t"] * w_t * s + w_t**2) * T
    y = y * q["tau_q"] * s / (q["tau_q"] * s + 1)
    poles = q["omega_c"] * np.exp(1j * np.pi * (2 * np.arange(1, order + 1) + order - 1) / (2 * order))
    return y * np.prod(-poles) / np.prod(s - poles)
