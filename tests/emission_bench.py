"""A small bench of six components with known lines in known noise, as files."""

import numpy as np

FS, SECONDS = 2000.0, 8.0
QUANTITIES = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "torque")
NOISE = 0.01
CHANNELS = ", ".join(
    f'{{ quantity = "{q}", column = {k}, unit = "{"N" if q.startswith("f") else "N*m"}" }}'
    for k, q in enumerate(QUANTITIES)
)


def samples(seed, lines=(), seconds=SECONDS, noise=NOISE, fs=FS):
    """Return six channels of white noise, (N, 6), with sines (frequency in Hz, peak) in all of them."""
    time = np.arange(round(seconds * fs)) / fs
    made = noise * np.random.default_rng(seed).normal(size=(time.size, 6))
    for k, (frequency, peak) in enumerate(lines):
        made += peak * np.sin(2.0 * np.pi * frequency * time + k)[:, None]
    return made


def record(name, rate, fs=FS):
    return (
        f'[[record]]\nname = "{name}"\nfile = "{name}.npy"\nsample_rate_hz = {fs}\nchannels = [{CHANNELS}]\n'
        f'command = {{ stepping = "micro", microsteps = 16, rate = {rate} }}\n'
    )


def background(name="off", state="off", fs=FS):
    return f'[[background]]\nname = "{name}"\nfile = "{name}.npy"\nstate = "{state}"\nsample_rate_hz = {fs}\n'


def requirement(name="r", direction="fx", kind="amplitude", unit="N", mask=((20.0, 0.1), (500.0, 0.1)), more=""):
    points = ", ".join(f"[{f}, {limit}]" for f, limit in mask)
    return (
        f'[[requirement]]\nname = "{name}"\ndirection = "{direction}"\nkind = "{kind}"\nunit = "{unit}"\n'
        f"mask = [{points}]\n{more}\n"
    )


def write_campaign(folder, runs, *parts):
    """Write arrays by name and campaign.toml; return the folder."""
    for name, array in runs.items():
        np.save(folder / f"{name}.npy", array)
    head = 'mechanism = "none.toml"\n[bench]\ndrive_axis = "z"\nmounting_point_m = [0.0, 0.0, 0.0]\n'
    (folder / "campaign.toml").write_text(head + "\n".join(parts))
    return folder
