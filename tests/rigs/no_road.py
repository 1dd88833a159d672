"""Rides without a road by the simulator of ../shared/research/no_road (numba, SciPy), whose rear wheel runs beside the front's track on an
isotropic road, and what veloid says of them: python3 tests/rigs/no_road.py VELOID FOLDER SEED LOW_M HIGH_M EACH CLEAN"""
import collections
import json
import pathlib
import subprocess
import sys

import numpy as np

RESEARCH = pathlib.Path(__file__).resolve().parents[3] / "shared/research/no_road"
EFFECTS = ["coulomb_friction", "cubic_stiffness", "quadratic_damping", "asymmetric_damping", "sprung_mass", "bump_stop",
           "wheel_out_of_round", "pedalling_force", "sensor_delay"]
BIKE = {"bike": "simulated", "mass_front_kg": 23, "mass_rear_kg": 63, "l_front_m": 0.808, "l_rear_m": 0.293,
        "wheel_radius_front_m": 0.34, "wheel_radius_rear_m": 0.34}
# The coherence of two tracks at a distance s on an isotropic road is (x K1(x))^2, x = 2 pi n s.
TRACKS = '''    at = np.arange(len(sl)) * dx; sr = sl; off = cfg.get("offset", 0.0)
    if off > 0:
        from scipy.special import k1
        own, _ = profile(rng, x[-1] + 20, LEVEL[cfg["road"]], cfg["patch"])
        xx = np.minimum(2 * np.pi * np.fft.rfftfreq(len(sl), dx) * off, 600); g = np.ones(len(xx)); g[1:] = xx[1:] * k1(xx[1:])
        sr = np.fft.irfft(np.fft.rfft(sl) * g + np.fft.rfft(own) * np.sqrt(np.maximum(1 - g * g, 0)), len(sl))
'''


def simulator(folder):
    source = (RESEARCH / "sim.py").read_text()
    source = source.replace("    at = np.arange(len(sl)) * dx; sr = sl\n", TRACKS)
    (folder / "tracks.py").write_text(source.replace("np.fft.rfft(sl) / np.where", "np.fft.rfft(sr) / np.where"))
    sys.path.insert(0, str(folder))
    import tracks
    return tracks


def ride(sim, folder, name, c):
    made, facts, _ = sim.simulate(c)
    rate, count = c["rate"], len(made["a_f"])
    t = np.arange(count) / rate
    speed = np.interp(t, np.arange(len(made["v_1hz"])), made["v_1hz"])
    crank = np.interp(t, np.arange(len(made["crank"])) / 50, made["crank"])
    table = np.column_stack((t, made["a_f"], made["a_r"], speed, np.gradient(crank, 1 / rate) * 60 / 2 / np.pi))
    np.savetxt(folder / f"{name}.csv", table, delimiter=",", header="t,a_f,a_r,v,cadence", comments="", fmt="%.6g")


def main():
    veloid, folder, seed, low, high, each, clean = sys.argv[1:]
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "bike.json").write_text(json.dumps(BIKE))
    sim, rng = simulator(folder), np.random.default_rng(int(seed))
    jobs = [e for e in EFFECTS for _ in range(int(each))] + [None] * int(clean)
    rng.shuffle(jobs)
    verdicts, covered, axle = collections.Counter(), collections.Counter(), {}
    for n, effect in enumerate(jobs):
        axle[effect] = "rear" if axle.get(effect, rng.choice(["front", "rear"])) == "front" else "front"
        c = sim.draw(int(rng.integers(1 << 30)), effect, axle[effect] if effect else None)
        c.update(offset=float(rng.uniform(float(low), float(high))), incoherent=0.0,
                 T=int(rng.choice([20, 60, 120, 300], p=[0.1, 0.7, 0.15, 0.05])), rate=int(rng.choice([100, 200, 250, 500], p=[0.35, 0.35, 0.2, 0.1])))
        if rng.random() < 0.33:
            c.update(speed_noise=float(rng.uniform(0.05, 0.1)), patch=float(rng.uniform(0.06, 0.1)), patch_r=float(rng.uniform(0.06, 0.1)))
        name = f"r{n:03d}"
        ride(sim, folder, name, c)
        files = [str(folder / f"{name}.csv"), "--bike", str(folder / "bike.json"), "--json", str(folder / f"{name}.json")]
        subprocess.run([veloid, "identify", *files, "--trials", "1"], check=True, capture_output=True)
        report = json.loads((folder / f"{name}.json").read_text())
        verdict = report["diagnosis"]["verdict"]
        named = [(e["id"], e["axle"]) for e in report["diagnosis"]["effects"] if e["affirmed"]]
        right = named == [(effect, c["axle"])] if effect else verdict == "nothing_missing"
        said = "right" if right else "WRONG" if named else verdict
        verdicts[effect or "nothing", said] += 1
        if verdict in ("named", "nothing_missing"):
            for a in ("front", "rear"):
                for q in ("k", "B"):
                    interval = report["result"][a][q]["interval"]
                    if interval:
                        covered[q, interval[0] <= c[a][q] <= interval[1]] += 1
        print(name, effect, c.get("axle"), said, named, flush=True)
    for (effect, said), count in sorted(verdicts.items()):
        print(effect, said, count)
    print({q: f"{covered[q, True]} of {covered[q, True] + covered[q, False]}" for q in ("k", "B")})


main()
