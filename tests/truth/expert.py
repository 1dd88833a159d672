"""What an expert reaches who knows the structure of each ride, as the ceiling of the diagnosis.

    veloid-truth make --out rides --seed N
    expert.py --rides rides --key rides_key.json --reports REPORTS [--only N]

Of rides with one effect on one axle it refits k, B and the effect on the first 60 %, from the plain fit and a coarse grid, by
SciPy's least squares through a Runge-Kutta of fourth order (compiled where numba is at hand). It prints a Markdown table beside
what `veloid identify` reported (report_XXX.json).
"""

import argparse
import csv
import json
import math
import time
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

try:
    from numba import njit
except ImportError:
    njit = None

SLIP = 1.5e-3  # m/s over which dry friction builds up
SETTLE, FITTED, GAP = 1.0, 0.6, 2.0
STEP = 1e-3 if njit else 2.5e-3
PRIOR = 0.05  # holds the first state near the first samples

# Parameters of each effect, how the law is chosen in `force`, and start values in units of what the ride suggests.
EFFECTS = {
    "cubic_stiffness": (["k3"], 1, [[-0.3, 0.1, 0.5, 2.0]]),
    "progressive_stiffness": (["k2"], 2, [[-0.3, -0.1, 0.1, 0.3]]),
    "quadratic_damping": (["c2"], 3, [[0.1, 0.5, 2.0]]),
    "asymmetric_damping": (["asymmetry"], 4, [[-0.4, -0.1, 0.1, 0.4]]),
    "coulomb_friction": (["friction"], 5, [[0.02, 0.1, 0.3]]),
    "hysteresis": (["stiffness", "yield_force"], 6, [[0.1, 0.5], [0.1, 0.3]]),
    "viscoelastic_tyre": (["branch_stiffness", "relaxation_time"], 7, [[0.1, 0.4], [0.01, 0.03, 0.1]]),
    "bump_stop": (["gap", "stop_stiffness"], 8, [[0.8, 1.2, 1.6, 2.0], [0.5, 2.0, 6.0]]),
    "sensor_gain": (["gain"], 0, [[0.9, 1.1]]),
    "sensor_offset": (["offset"], 0, [[0.0]]),
    "sensor_delay": (["delay"], 0, [[-0.005, 0.005]]),
}


def force(law, p, side, d, w, s):
    """Force that the effect adds to k d + B w, and the rate of its state; p holds k, B, then the effect's parameters."""
    k, b, e, g = p[3], p[4], p[5], p[6]
    f, rate = 0.0 * d, 0.0 * d
    if law == 1:
        f = e * d * d * d
    elif law == 2:
        turn = -k / (2.0 * e)
        # Numba's `where` makes arrays of numbers.
        past = 1.0 * ((d - turn) * e < 0.0)
        f = past * (e * turn * turn + k * (turn - d)) + (1.0 - past) * e * d * d
    elif law == 3:
        f = e * w * np.abs(w)
    elif law == 4:
        f = b * e * np.abs(w)
    elif law == 5:
        f = e * np.tanh(w / SLIP)
    elif law == 6:
        f, rate = s, e * (w - np.abs(w) * s / g)
    elif law == 7:
        f, rate = s, e * w - s / g
    elif law == 8:
        if side >= 0.0:
            f = f + g * np.maximum(d - e, 0.0)
        if side <= 0.0:
            f = f + g * np.minimum(d + e, 0.0)
    return f, rate


def derivative(law, p, side, mass, drive, at, z, v, s):
    d, w = drive[0, at] - z, drive[1, at] - v
    f, rate = force(law, p, side, d, w, s)
    return v, (p[3] * d + p[4] * w + f + drive[2, at] + p[2]) / mass, rate


def integrate(law, p, side, mass, drive, h, out):
    """Fills `out` with z; p holds z, v, rest force, k, B and the effect's parameters."""
    z, v, s = p[0], p[1], 0.0 * p[0]
    for i in range(out.shape[0]):
        out[i] = z
        if i + 1 == out.shape[0]:
            break
        a1, b1, c1 = derivative(law, p, side, mass, drive, 2 * i, z, v, s)
        a2, b2, c2 = derivative(law, p, side, mass, drive, 2 * i + 1, z + h / 2 * a1, v + h / 2 * b1, s + h / 2 * c1)
        a3, b3, c3 = derivative(law, p, side, mass, drive, 2 * i + 1, z + h / 2 * a2, v + h / 2 * b2, s + h / 2 * c2)
        a4, b4, c4 = derivative(law, p, side, mass, drive, 2 * i + 2, z + h * a3, v + h * b3, s + h * c3)
        z = z + h / 6 * (a1 + 2 * (a2 + a3) + a4)
        v = v + h / 6 * (b1 + 2 * (b2 + b3) + b4)
        s = s + h / 6 * (c1 + 2 * (c2 + c3) + c4)


if njit:
    force = njit(cache=True)(force)
    derivative = njit(cache=True)(derivative)
    integrate = njit(cache=True)(integrate)


class Axle:
    """One axle of a logged ride."""

    def __init__(self, folder, name, axle):
        with open(folder / f"ride_{name}.csv") as file:
            rows = list(csv.DictReader(file))
        column = lambda c: np.array([float(row[c]) for row in rows]) if c in rows[0] else None
        bike = json.loads((folder / f"bike_{name}.json").read_text())
        mark = axle[0]
        self.mass = bike[f"mass_{axle}_kg"]
        self.t, self.z = column("t"), column(f"z_{mark}")
        self.rests = column(f"u_{mark}") is None
        per_sample = math.ceil((self.t[1] - self.t[0]) / STEP - 1e-9)
        self.h = (self.t[1] - self.t[0]) / per_sample
        steps = round((self.t[-1] - self.t[0]) / self.h) + 1
        self.grid = self.t[0] + self.h * np.arange(steps)
        self.drive = self.driven(column(f"u_{mark}"), column(f"force_{mark}"), 2 * steps)
        settle = 0.0 if self.rests and column(f"force_{mark}") is None else SETTLE
        end = self.t[-1]
        self.fitted = (self.t >= settle) & (self.t < FITTED * end)
        self.held_out = self.t >= FITTED * end + GAP

    def driven(self, road, pushed, count):
        half = self.t[0] + self.h / 2 * np.arange(count)
        drive = np.zeros((3, count))
        if road is not None:
            spline = CubicSpline(self.t, road)
            drive[0], drive[1] = spline(half), spline(half, 1)
        if pushed is not None:
            drive[2] = CubicSpline(self.t, pushed)(half)
        return drive

    def logged(self, effect, side, columns, until):
        """What the logger would have written at the samples before `until`, one column per set of parameters."""
        law = EFFECTS[effect][1] if effect else 0
        steps = min(len(self.grid), math.ceil((until - self.t[0]) / self.h) + 50)
        motion = np.empty((steps, columns.shape[1]))
        if njit:
            for i in range(columns.shape[1]):
                one = np.empty(steps)
                integrate(law, columns[:, i].copy(), side, self.mass, self.drive, self.h, one)
                motion[:, i] = one
        else:
            integrate(law, columns, side, self.mass, self.drive, self.h, motion)
        at = self.t[self.t < until]
        motion = np.nan_to_num(np.clip(motion, -10.0, 10.0), nan=10.0)
        if effect == "sensor_delay":
            shifted = zip(motion.T, columns[5])
            return np.array([CubicSpline(self.grid[:steps], m)(at - delay) for m, delay in shifted]).T
        z = motion[np.rint((at - self.t[0]) / self.h).astype(int)]
        if effect == "sensor_gain":
            z = z * columns[5]
        return z + (columns[5] if effect == "sensor_offset" else 0.0)


class Problem:
    """Unknowns of a fit: z, v, rest force, ln k, ln B, then the effect's parameters in units of their start."""

    def __init__(self, axle, effect, side, k, b, start):
        self.axle, self.effect, self.side = axle, effect, side
        v = (axle.z[2] - axle.z[0]) / (axle.t[2] - axle.t[0])
        self.first = np.array([axle.z[0], v])
        self.k, self.b, self.start = k, b, np.array(start)
        self.until = axle.t[axle.fitted][-1] + 1e-6
        self.mask = axle.fitted[axle.t < self.until]

    def columns(self, x):
        p = np.ones((7, x.shape[1]))
        p[0:2] = self.first[:, None] + x[0:2] * np.array([[1e-3], [0.1]])
        p[2] = 1e-3 * self.k * x[2] if self.axle.rests else 0.0
        p[3], p[4] = self.k * np.exp(np.clip(x[3], -4, 4)), self.b * np.exp(np.clip(x[4], -6, 6))
        for i, (start, scale) in enumerate(zip(self.start, self.scales())):
            p[5 + i] = start + scale * x[5 + i]
        return p

    def scales(self):
        return np.maximum(np.abs(self.start), 1e-3 if self.effect == "sensor_offset" else 1e-12)

    def residuals(self, x):
        """One column per column of x, in mm."""
        z = self.axle.logged(self.effect, self.side, self.columns(x), self.until)
        errors = 1e3 * (z[self.mask] - self.axle.z[self.axle.t < self.until][self.mask][:, None])
        return np.vstack([errors, PRIOR * x[:3]])

    def jacobian(self, x):
        step = 1e-5
        moved = x[:, None] + step * np.hstack([np.eye(len(x)), -np.eye(len(x))])
        both = self.residuals(moved)
        return (both[:, : len(x)] - both[:, len(x) :]) / (2 * step)

    def fit(self):
        start = np.zeros(5 + len(self.start))
        solved = least_squares(lambda x: self.residuals(x[:, None])[:, 0], start, self.jacobian, max_nfev=40)
        return solved.cost, self.columns(solved.x[:, None])


def naive(axle, effect, k, b):
    """Starts on a coarse grid, in units of what the plain fit and the size of the motion suggest."""
    u = axle.drive[0, ::2][: len(axle.grid)]
    road = np.interp(axle.t, axle.grid, u)
    d = np.std((road - axle.z)[axle.fitted])
    w = np.std(np.gradient(road - axle.z, axle.t)[axle.fitted])
    units = {
        "k3": k / d**2, "k2": k / d, "c2": b / w, "friction": k * d, "stiffness": k, "yield_force": k * d,
        "branch_stiffness": k, "gap": d, "stop_stiffness": k,
    }
    names, _, grid = EFFECTS[effect]
    starts = [np.array(values) * units.get(name, 1.0) for name, values in zip(names, grid)]
    return np.stack(np.meshgrid(*starts, indexing="ij"), -1).reshape(-1, len(names))


def refit(axle, effect, side):
    """k, B, parameters and held-out RMS (m) of the structure that acts."""
    _, plain = Problem(axle, None, 0.0, 1e5, 300.0, []).fit()
    k, b = plain[3, 0], plain[4, 0]
    problems = [Problem(axle, effect, side, k, b, start) for start in naive(axle, effect, k, b)]
    cost = lambda p: np.sum(p.residuals(np.zeros((5 + len(p.start), 1))) ** 2)
    nearest = sorted(problems, key=cost)[:2]
    _, p = min((problem.fit() for problem in nearest), key=lambda found: found[0])
    z = axle.logged(effect, side, p, axle.t[-1] + 1.0)[:, 0]
    rms = np.sqrt(np.mean((z - axle.z)[axle.held_out] ** 2))
    return p[3, 0], p[4, 0], p[5 : 5 + len(EFFECTS[effect][0]), 0], rms


def off(value, truth, name=""):
    """Relative error in percent; a gain's of its departure from 1."""
    if value is None:
        return "-"
    return f"{100 * abs((value - truth) / (truth - 1 if name == 'gain' else truth)):.2f}"


def reported(path, effect, axle, names):
    """k, B, parameters, held-out RMS and verdict of veloid's report; `None` for what it does not have."""
    if not path.exists():
        return None, None, [None] * len(names), None, "-"
    said = json.loads(path.read_text())["diagnosis"]
    of = (said.get("extended") or {}).get(axle) or {}
    found = [e for e in said["effects"] if (e["id"], e["axle"]) == (effect, axle)]
    values = [found[0]["parameters"].get(n, {}).get("value") if found else None for n in names]
    rms = ((said.get("held_out") or {}).get(axle) or {}).get("extended_rms_m")
    return of.get("k_n_m"), of.get("b_n_s_m"), values, rms, said["verdict"]


def row(ride, folder, reports):
    effect, name = ride["effects"][0], ride["ride"]
    identity, side = effect["id"], effect["axle"]
    names = EFFECTS[identity][0]
    truth = [effect["parameters"][n] for n in names]
    sides = {"compression": 1.0, "rebound": -1.0}
    begun = time.perf_counter()
    expert = refit(Axle(folder, name, side), identity, sides.get(effect["parameters"].get("side"), 0.0))
    seconds = time.perf_counter() - begun
    veloid = reported(reports / f"report_{name}.json", identity, side, names)
    at = 0 if side == "front" else 1
    both = []
    for k, b, values, rms, *_ in (expert, veloid):
        errors = ", ".join(off(v, t, n) for v, t, n in zip(values, truth, names))
        held_out = "-" if rms is None else f"{1e6 * rms:.1f}"
        both.append([held_out, off(k, ride["stiffness_n_m"][at]), off(b, ride["damping_n_s_m"][at]), errors])
    pairs = [f"{e} / {v}" for e, v in zip(*both)]
    return f"| {name} | `{identity}` {side} | {' | '.join(pairs)} | {veloid[4]} | {seconds:.1f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("--rides", "--key", "--reports"):
        parser.add_argument(name, type=Path, required=True)
    parser.add_argument("--only", type=int, help="at most so many rides")
    asked = parser.parse_args()
    rides = json.loads(asked.key.read_text())["rides"]
    known = [r for r in rides if len(r["effects"]) == 1 and r["effects"][0]["id"] in EFFECTS and not r.get("outside")]
    print("Expert / veloid, errors in percent.\n")
    print("| ride | concealed | held-out RMS (um) | k | B | parameters | verdict | expert's time (s) |")
    print("|---|---|---|---|---|---|---|---|")
    for ride in known[: asked.only]:
        print(row(ride, asked.rides, asked.reports), flush=True)


if __name__ == "__main__":
    main()
