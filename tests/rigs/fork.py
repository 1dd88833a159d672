"""Simulated fork: travel and the acceleration above it, read as they are and as a rig's force (mass x acceleration):
python3 tests/rigs/fork.py VELOID FOLDER SEEDS (needs NumPy, SciPy and numba)"""
import json
import pathlib
import subprocess
import sys

import numpy as np
from numba import njit
from scipy.signal import butter, sosfiltfilt

HALF = 1 / 8000
MASS, K, B = 25.0, 9000.0, 350.0
# Name, (friction N, cubic N/m^3, quadratic N s^2/m^2, share of B by which compression is harder, gap m, stop N/m)
EFFECTS = {
    None: (0, 0, 0, 0, 1, 0),
    "coulomb_friction": (60, 0, 0, 0, 1, 0),
    "cubic_stiffness": (0, 6e6, 0, 0, 1, 0),
    "quadratic_damping": (0, 0, 400, 0, 1, 0),
    "asymmetric_damping": (0, 0, 0, 0.4, 1, 0),
    "bump_stop": (0, 0, 0, 0, 0.02, 40e3),
}


@njit
def acceleration(d, w, friction, cubic, quadratic, asymmetry, gap, stop):
    force = K * d + B * (1 + asymmetry * np.sign(w)) * w + cubic * d ** 3 + quadratic * abs(w) * w
    return (force + friction * np.tanh(w / 2e-3) + stop * max(d - gap, 0.0)) / MASS


@njit
def ridden(road, rate, effect):
    """Deflection and acceleration at every second point of the road, by Runge-Kutta steps over two of them."""
    z, v, h = 0.0, 0.0, 2 * HALF
    count = len(road) // 2
    d, a = np.empty(count), np.empty(count)
    for i in range(count):
        at = 2 * i
        d[i] = road[at] - z
        a1 = acceleration(d[i], rate[at] - v, *effect)
        a[i] = a1
        if i + 1 == count:
            break
        v2 = v + 0.5 * h * a1
        a2 = acceleration(road[at + 1] - (z + 0.5 * h * v), rate[at + 1] - v2, *effect)
        v3 = v + 0.5 * h * a2
        a3 = acceleration(road[at + 1] - (z + 0.5 * h * v2), rate[at + 1] - v3, *effect)
        v4 = v + h * a3
        a4 = acceleration(road[at + 2] - (z + h * v3), rate[at + 2] - v4, *effect)
        z += h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return d, a


def trail(rng, seconds):
    """Height (m) and its rate at 5 m/s on a road of ISO 8608 class E from 0.04 to 5 cycles/m."""
    t = np.arange(int(seconds / HALF)) * HALF
    height, rate = np.zeros_like(t), np.zeros_like(t)
    hz = np.geomspace(0.2, 25, 400)
    for f, width in zip(hz, np.gradient(hz)):
        amplitude = np.sqrt(2 * 4096e-6 * 0.01 * 5 / f**2 * width)
        angle = 2 * np.pi * f * t + rng.uniform(0, 2 * np.pi)
        height += amplitude * np.sin(angle)
        rate += amplitude * 2 * np.pi * f * np.cos(angle)
    return height, rate


def logged(rng, effect, rate_hz):
    d, a = ridden(*trail(rng, 64), tuple(float(x) for x in EFFECTS[effect]))
    low_pass = butter(4, 0.4 * rate_hz, fs=4000, output="sos")
    d, a = (sosfiltfilt(low_pass, x)[2 * 4000:62 * 4000:4000 // rate_hz] for x in (d, a))
    t = np.arange(len(d)) / rate_hz
    return t, d + 1e-4 * rng.standard_normal(len(d)), a + 0.1 * rng.standard_normal(len(d))


def main():
    veloid, folder, seeds = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "bike.json").write_text(json.dumps({"bike": "fork", "mass_front_kg": MASS}))
    (folder / "rig.json").write_text(json.dumps({"bike": "fork on a rig"}))
    for effect in EFFECTS:
        for way in ("travel", "rig"):
            row, said = [], []
            for seed in range(seeds):
                t, d, a = logged(np.random.default_rng(seed), effect, [200, 500][seed % 2])
                columns, header = (d, a), "t,d_f,a_f"
                if way == "rig":
                    columns, header = (d, MASS * a), "t,z_f,force_f"
                ride = folder / "ride.csv"
                np.savetxt(ride, np.column_stack((t, *columns)), delimiter=",", header=header, comments="", fmt="%.7g")
                bike = folder / ("rig.json" if way == "rig" else "bike.json")
                report = folder / "report.json"
                subprocess.run([veloid, "identify", ride, "--bike", bike, "--json", report, "--trials", "1"], check=True, capture_output=True)
                found = json.loads(report.read_text())
                diagnosis, result = found["diagnosis"], found["result"]["front"]
                names = "+".join(e["id"] for e in diagnosis["effects"] if e["affirmed"])
                said.append(f"{diagnosis['verdict']} {names}".strip())
                row.append([100 * (result[q]["value"] / truth - 1) if result[q]["value"] else np.nan for q, truth in (("k", K), ("B", B))])
            k, b = np.median(np.abs(row), axis=0)
            print(f"| {effect or 'nothing'} | {way} | {'; '.join(f'{said.count(s)} {s}' for s in dict.fromkeys(said))} | {k:.2f} | {b:.2f} |", flush=True)


main()
