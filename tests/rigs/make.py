"""Benches and decays that no bicycle makes, integrated here apart from veloid's own laws: drives with friction, pendulums,
masses with hidden masses on shakers, decays of several modes, rigs for dampers. Each with what an expert would find.

    python3 tests/rigs/make.py FOLDER      # needs NumPy and SciPy
    python3 tests/rigs/run.py FOLDER target/release/veloid
"""

import json
import pathlib
import sys

import numpy as np
from scipy.interpolate import CubicSpline

FOLDER = pathlib.Path(sys.argv[1])
UNKNOWN = {"bike": "bench", "mass_front_kg": None}
ONE = {"bike": "bench", "mass_front_kg": 1.0}


def random(seed):
    return np.random.default_rng(seed)


def integrated(rates, start, step, samples, substeps):
    """Runge-Kutta of fourth order; one row a sample."""
    rows, x, t, h = np.empty((samples, len(start))), np.array(start, float), 0.0, step / substeps
    for i in range(samples):
        rows[i] = x
        for _ in range(substeps):
            k1 = rates(t, x)
            k2 = rates(t + h / 2, x + h / 2 * k1)
            k3 = rates(t + h / 2, x + h / 2 * k2)
            k4 = rates(t + h, x + h * k3)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            t += h
    return rows


def write(name, columns, bike, expected):
    FOLDER.mkdir(parents=True, exist_ok=True)
    table = np.column_stack(list(columns.values()))
    np.savetxt(FOLDER / f"{name}.csv", table, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    (FOLDER / f"{name}.json").write_text(json.dumps(bike))
    (FOLDER / f"{name}.expected").write_text(json.dumps(expected))


def multisine(rng, low, high, count, rms):
    hz, phases = np.linspace(low, high, count), rng.uniform(0, 2 * np.pi, count)
    return lambda t: rms * np.sqrt(2 / count) * np.sum(np.sin(2 * np.pi * hz * t + phases))


def drives():
    """A motor pushes a sled on guides: z'' = 13 u - 7 z' - 4.8 sign z' - 0.25, the encoder has steps of 0.1 mm."""
    step, samples, friction = 1 / 200, 4000, 4.8
    t = np.arange(samples) * step
    levels = random(1).uniform(-0.5, 0.5, 200)
    sines = multisine(random(2), 0.2, 4, 40, 0.45)

    def level(s):
        return 2 * levels[min(int(s / 0.25), 199)]

    inputs = {
        "chirp": lambda s: 0.5 * np.sin(2 * np.pi * (0.2 + 0.12 * s) * s),
        "square": lambda s: 0.5 * np.sign(np.sin(2 * np.pi * 0.35 * s) + 1e-12),
        "levels": level,
        "multisine": sines,
        "cogging": sines,
        "viscous": sines,
    }
    for name, push in inputs.items():

        def rates(s, x):
            dry = 0.0 if name == "viscous" else friction * np.tanh(x[1] / 0.002)
            cogging = 0.5 * np.sin(2 * np.pi * x[0] / 0.05) if name == "cogging" else 0.0
            return np.array([x[1], 13.0 * push(s) - 7.0 * x[1] - dry - 0.25 - cogging])

        z = integrated(rates, [0, 0], step, samples, 10)[:, 0] + random(3).normal(0, 2e-4, samples)
        columns = {"t": t, "force_f": np.array([push(s) for s in t]), "z_f": np.round(z / 1e-4) * 1e-4}
        write(f"drive_{name}", columns, UNKNOWN, [] if name == "viscous" else ["coulomb_friction"])


def pendulums():
    """Decays with dry friction, drag and the softening of the sine, told from noise of 0.2 % of the swing and an offset."""
    table = [
        ("friction", 1.6, 0.35, 0.01, 0.05, 0, 40, ["coulomb_friction", "cubic_stiffness", "hysteresis"]),
        ("wide", 1.2, 1.2, 0.02, 0.03, 0, 30, ["cubic_stiffness", "coulomb_friction"]),
        ("drag", 2.0, 0.8, 0.004, 0, 0.06, 60, ["cubic_stiffness", "quadratic_damping"]),
        ("small", 1.5, 0.08, 0.03, 0, 0, 40, ["cubic_stiffness"]),
        ("slow", 7.0, 0.5, 0.002, 0.002, 0, 300, ["coulomb_friction", "cubic_stiffness", "hysteresis"]),
    ]
    for name, period, swing, viscous, dry, drag, seconds, expected in table:
        step = 1 / 250 if period < 5 else 1 / 20
        samples, square = int(seconds / step), (2 * np.pi / period) ** 2

        def rates(_, x):
            loss = viscous * x[1] + dry * np.tanh(x[1] / 0.003) + drag * x[1] * abs(x[1])
            return np.array([x[1], -square * np.sin(x[0]) - loss])

        z = integrated(rates, [swing, 0], step, samples, 4)[:, 0] + random(4).normal(0, 2e-3 * swing, samples) + 0.01
        write(f"pendulum_{name}", {"t": np.arange(samples) * step, "z_f": z}, ONE, expected)


def shaken():
    """2 kg on a spring under a shaker, with a hidden mass, a cubic spring, friction, or nothing besides."""
    step, samples, mass = 1 / 500, 10_000, 2.0
    t = np.arange(samples) * step
    sines = multisine(random(7), 1, 40, 200, 6.0)
    force = np.array([sines(s) for s in t])
    fine = CubicSpline(t, force)(np.arange(16 * samples + 2) * step / 16)
    table = [
        ("hidden_small", 2500.0, 0.15, 1.2, 0, 0, ["sprung_mass"]),
        ("hidden_big", 4000.0, 0.5, 0.7, 0, 0, ["sprung_mass"]),
        ("hidden_stiff", 3000.0, 0.3, 2.2, 0, 0, ["sprung_mass"]),
        ("cubic", 3000.0, 0, 1, 4e7, 0, ["cubic_stiffness"]),
        ("cubic_friction", 3000.0, 0, 1, 4e7, 0.6, ["cubic_stiffness", "coulomb_friction"]),
        ("linear", 3000.0, 0, 1, 0, 0, []),
    ]
    for name, stiffness, share, ratio, cubic, dry, expected in table:
        damping = 0.06 * np.sqrt(stiffness * mass)
        second = share * mass
        spring = second * ratio**2 * stiffness / mass
        damper = 0.08 * np.sqrt(spring * second)

        def rates(s, x):
            pull = spring * (x[0] - x[2]) + damper * (x[1] - x[3])
            push = fine[round(s * 16 / step)] - stiffness * x[0] - damping * x[1] - cubic * x[0] ** 3
            push -= dry * np.tanh(x[1] / 0.001) + pull
            return np.array([x[1], push / mass, x[3], pull / second if second else 0.0])

        z = integrated(rates, [0, 0, 0, 0], step, samples, 8)[:, 0]
        z = z + random(8).normal(0, 3e-3 * z.std(), samples) + 1e-4
        noisy = force + random(9).normal(0, 3e-3 * force.std(), samples)
        write(f"shaken_{name}", {"t": t, "force_f": noisy, "z_f": z}, UNKNOWN, expected)


def modes():
    """A structure that was struck: sizes, frequencies (Hz) and damping ratios of its modes."""
    step, samples = 1 / 1000, 6000
    t = np.arange(samples) * step
    table = {
        "one": [(1, 9, 0.006)],
        "two": [(1, 7, 0.008), (0.35, 19, 0.006)],
        "three": [(1, 11, 0.006), (0.5, 31, 0.005), (0.2, 58, 0.004)],
    }
    for name, known in table.items():
        parts = (
            size * np.exp(-2 * np.pi * hz * zeta * t) * np.cos(2 * np.pi * hz * t + i)
            for i, (size, hz, zeta) in enumerate(known)
        )
        z = sum(parts) + random(5).normal(0, 2e-3, samples)
        write(f"modes_{name}", {"t": t, "z_f": z}, ONE, ["sprung_mass", "unsprung_mass"] if len(known) > 1 else [])


def rigs():
    """Motion is prescribed, the force that answers is measured, with a gain that wanders by 1 %."""
    step, samples = 1 / 200, 4000
    t = np.arange(samples) * step
    d = 0.01 * np.sin(2 * np.pi * 1.1 * t) + 0.004 * np.sin(2 * np.pi * 2.7 * t + 1)
    w = 2 * np.pi * (0.011 * np.cos(2 * np.pi * 1.1 * t) + 0.0108 * np.cos(2 * np.pi * 2.7 * t + 1))
    slip, stuck = 0.0, []
    for rate in w:
        slip += step * (rate - abs(rate) * slip / 0.0015)
        stuck.append(slip / 0.0015)
    table = {
        "linear": (500 * w + 3000 * d, []),
        "bilinear": (np.where(w > 0, 300, 900) * w + 2000 * d, ["asymmetric_damping"]),
        "friction": (400 * w + 40 * np.tanh(w / 0.003) + 1000 * d, ["coulomb_friction", "hysteresis"]),
        "power": (120 * np.sign(w) * abs(w) ** 0.4 + 500 * d, ["coulomb_friction"]),
        "hysteresis": (250 * w + 40 * np.array(stuck), ["hysteresis"]),
        "tyre": (2e4 * d + 3e8 * d**3 + 30 * w, ["cubic_stiffness"]),
    }
    for name, (force, expected) in table.items():
        force = force * (1 + 0.01 * np.sin(0.3 * t)) + random(6).normal(0, 4e-3 * force.std(), samples) + 2
        columns = {"t": t, "d_f": d + random(11).normal(0, 5e-6, samples), "force_f": force}
        write(f"rig_{name}", columns, UNKNOWN, expected)


for bench in (drives, pendulums, shaken, modes, rigs):
    bench()
