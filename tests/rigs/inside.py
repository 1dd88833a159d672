"""`dynamics` and `validation` of a report beside SciPy and Octave's control package on a ride, a shaker and a free decay:
python3 tests/rigs/inside.py VELOID FOLDER (needs NumPy, SciPy and Octave with its package control) prints the largest relative
differences"""
import json
import pathlib
import subprocess
import sys

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
from scipy.optimize import least_squares
from scipy.signal import csd, lfilter, lti, welch

RIDES = {
    "road": ["--duration", "60", "--noise", "2e-5"],
    "force": ["--duration", "60", "--noise", "2e-5", "--shaker", "60:1:15"],
    "free decay": ["--duration", "20", "--noise", "1e-5", "--release", "0.01", "--damping", "60"],
}
HELD_OUT = 0.4  # `held_out` of the settings
AFTER = 50  # samples after the fitted part, for the inputs' derivatives
MASSES = {"front": 23.0, "rear": 63.0}
WHAT = {
    "poles": "poles, of their size (Octave `pole`)",
    "damping": "natural frequency, damping ratio (Octave `damp`)",
    "step": "step response, of its largest value (SciPy `lti.step`)",
    "estimate": "k, B (own least squares)",
    "standard": "the same, in their standard deviations",
    "deviation": "their standard deviations",
    "correlation": "their correlation, absolute",
    "magnitude": "frequency response, magnitude (SciPy `csd`, `welch`)",
    "phase": "its phase (rad)",
    "coherence": "coherence, absolute",
    "model": "the plain model's frequency response (closed form)",
}


def record(veloid, folder, name, options):
    """Report and channels of a simulated ride at 200 Hz."""
    ends = (".csv", "_bike.json", ".json", "_read.csv")
    ride, bike, report, table = (folder / f"{name.replace(' ', '_')}{end}" for end in ends)
    subprocess.run([veloid, "simulate", ride, "--bike", bike, "--rate", "200", *options], check=True, capture_output=True)
    short = ["--no-diagnosis", "--trials", "1", "--iterations", "2", "--json", report, "--model", table]
    subprocess.run([veloid, "identify", ride, "--bike", bike, *short], check=True, capture_output=True)
    return json.loads(report.read_text()), np.genfromtxt(table, delimiter=",", names=True)


def lifted(values):
    """What docs/decisions/lifted-inputs.md says of inputs."""
    out, difference = values.copy(), values
    for order, weight in enumerate((0, 1 / 720, 17 / 30240, 23 / 151200), 1):
        difference = -np.diff(difference, 2)
        out[order : len(values) - order] += weight * difference
    return out


def moved(p, h, u, F, m):
    """Displacement by k, B, height, velocity and constant force; u and F are cubics with their derivatives at the samples."""
    k, B, z, v, c = p
    force = k * u + B * np.column_stack([u[:, 1:], np.zeros(len(u))]) + F
    force[:, 0] += c
    system = np.diag(np.ones(5), 1)
    system[1, :3] = -k / m, -B / m, 1 / m
    whole = expm(h * system)[:2]
    (a, b), (d, e) = whole[:, :2].tolist()
    out = [z]
    for p, q in (force[:-1] @ whole[:, 2:].T).tolist():
        z, v = a * z + b * v + p, d * z + e * v + q
        out.append(z)
    return np.array(out)


def derivatives(t, y):
    spline = CubicSpline(t, lifted(y))
    return np.array([spline(t, order) for order in range(4)]).T


def burg(x):
    """Coefficients and variance of an autoregressive model, its order up to 20 by Akaike's criterion."""
    forward, backward, variance, a = x.copy(), x.copy(), np.mean(x * x), np.zeros(0)
    tried = [(len(x) * np.log(variance), a, variance)]
    for order in range(1, 21):
        f, b = forward[order:], backward[order - 1 : -1]
        k = -2 * (f @ b) / (f @ f + b @ b)
        a = np.append(a + k * a[::-1], k)
        forward[order:], backward[order:] = f + k * b, b + k * f
        variance *= 1 - k * k
        tried.append((len(x) * np.log(variance) + 2 * order, a, variance))
    return min(tried, key=lambda model: model[0])[1:]


def fitted(t, u, F, z, m, guess, has_constant):
    """k, B of the part that is fitted, and their covariance under noise of the residual's colour."""
    end = round((1 - HELD_OUT) * len(t)) - int(0.03 * len(t))
    t, u, F, z = (None if x is None else x[: end + AFTER] for x in (t, u, F, z))
    h, zeros = t[1] - t[0], np.zeros((len(t), 4))
    u, F = (zeros if x is None else derivatives(t, x) for x in (u, F))
    sizes = np.array([*guess, 1e-3, 0.1, 10.0])
    free = 5 if has_constant else 4

    def left(x):
        p = np.append(x, np.zeros(5 - free)) * sizes
        return (moved(p, h, u, F, m) - z)[:end] * 1e5

    start = np.array([1.0, 1.0, z[0] / 1e-3, 0.0, 0.0])[:free]
    found = least_squares(left, start, jac="3-point", x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    a, variance = burg(found.fun)
    columns = lfilter([1.0], np.append(1.0, a), found.jac[::-1], axis=0)
    bread = np.linalg.inv(found.jac.T @ found.jac)
    covariance = variance * bread @ (columns.T @ columns) @ bread
    scale = np.diag(sizes[:2])
    return found.x[:2] * sizes[:2], scale @ covariance[:2, :2] @ scale


def by_octave(cases):
    """Poles, natural frequency (Hz) and damping ratio of each m, k, B."""
    lines = [f"G = tf({k!r}, [{m!r}, {B!r}, {k!r}]); [w, z] = damp(G); p = pole(G); "
             "printf('%.17g %.17g %.17g %.17g\\n', real(p(1)), abs(imag(p(1))), w(1) / (2 * pi), z(1));" for m, k, B in cases]
    code = "pkg load control; " + " ".join(lines)
    done = subprocess.run(["octave", "--no-gui", "--quiet", "--eval", code], capture_output=True, text=True)
    return [[float(x) for x in line.split()] for line in done.stdout.splitlines()]


def relative(own, other):
    own, other = np.asarray(own, float), np.asarray(other, float)
    return np.max(np.abs(own - other) / np.abs(other))


def measured(response, h, x, y):
    """Magnitude, phase and coherence at the report's frequencies (nearest of Welch's)."""
    n = round(response["segment_s"] / h)
    detrend = "linear" if "linear" in response["detrend"] or "line" in response["detrend"] else "constant"
    how = dict(fs=1 / h, window="hann", nperseg=n, noverlap=round(n * response["overlap"]), detrend=detrend)
    hz, cross = csd(x, y, **how)
    (_, xx), (_, yy) = welch(x, **how), welch(y, **how)
    at = [np.argmin(np.abs(hz - f)) for f in response["frequency_hz"]]
    ratio = cross[at] / xx[at]
    return np.abs(ratio), np.angle(ratio), np.abs(cross[at]) ** 2 / (xx[at] * yy[at])


def compared(name, report, table):
    """Largest differences of both axles, by what is compared."""
    found = {}

    def add(what, value):
        found[what] = max(found.get(what, 0.0), float(value))

    cases = []
    for axle, m in MASSES.items():
        channel = lambda kind: table[f"{kind}_{axle[0]}"] if f"{kind}_{axle[0]}" in table.dtype.names else None
        t, z, u, F = table["t"], channel("z"), channel("u"), channel("force")
        h = (t[-1] - t[0]) / (len(t) - 1)
        plain = report["output_error"][axle]
        k, B = plain["k_n_m"], plain["b_n_s_m"]
        dynamics, validation = report["dynamics"][axle], report["validation"][axle]
        (k_fit, B_fit), covariance = fitted(t, u, F, z, m, (k, B), u is None or F is not None)
        add("estimate", relative([k, B], [k_fit, B_fit]))
        deviations = np.sqrt(np.diag(covariance))
        add("standard", np.max(np.abs([k - k_fit, B - B_fit]) / deviations))
        own = np.array(dynamics["parameters"]["covariance"])[:2, :2]
        add("deviation", relative(np.sqrt(np.diag(own)), deviations))
        correlation = lambda c: c[0, 1] / np.sqrt(c[0, 0] * c[1, 1])
        add("correlation", abs(correlation(own) - correlation(covariance)))
        cases.append((axle, m, k, B))
        step, response = dynamics["step_response"], validation["response"]
        over = [B, k] if step["input"] == "road" else [1.0]
        if step:
            at = np.array(step["t_s"])
            _, curve = lti(over, [m, B, k]).step(T=at)
            add("step", np.max(np.abs(curve - step["displacement_m"])) / np.max(np.abs(curve)))
        if response:
            magnitude, phase, coherence = measured(response, h, F if u is None else u, z)
            seen = np.array(response["coherence"]) > response["coherent_above"]
            add("magnitude", relative(np.array(response["magnitude"])[seen], magnitude[seen]))
            turned = np.angle(np.exp(1j * (np.array(response["phase_rad"]) - phase)))
            add("phase", np.max(np.abs(turned[seen])))
            add("coherence", np.max(np.abs(coherence - response["coherence"])[seen]))
            s = 2j * np.pi * np.array(response["frequency_hz"])
            exact = np.polyval(over, s) / np.polyval([m, B, k], s)
            models = np.array(response["plain"]["magnitude"]) * np.exp(1j * np.array(response["plain"]["phase_rad"]))
            add("model", np.max(np.abs(models - exact) / np.abs(exact)))
    for (axle, *_), (re, im, hz, ratio) in zip(cases, by_octave([case[1:] for case in cases])):
        pole = max(report["dynamics"][axle]["poles"], key=lambda pole: pole["im_rad_s"])
        add("poles", abs(complex(pole["re_1_s"], pole["im_rad_s"]) - complex(re, im)) / abs(complex(re, im)))
        result = report["result"][axle]
        add("damping", relative([result[x]["value"] for x in ("natural_frequency", "damping_ratio")], [hz, ratio]))
    return found


def main():
    veloid, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    found = {name: compared(name, *record(veloid, folder, name, options)) for name, options in RIDES.items()}
    print("| largest relative difference | " + " | ".join(found) + " |")
    print("|---|" + "---|" * len(found))
    for what, words in WHAT.items():
        cells = (f"{of[what]:.1e}" if what in of else "" for of in found.values())
        print(f"| {words} | " + " | ".join(cells) + " |")


main()
