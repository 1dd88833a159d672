#!/usr/bin/env python3
"""What the diagnosis says of the paper's bench, accelerometers and a 30 Hz laser: bench.py VELOID FOLDER [RIDES]

A ride of a minute is simulated at 1 kHz, with or without an effect on the rear axle; accelerometers (100 Hz, 0.03 m/s^2 of noise) and a laser at the rear
(30 Hz, 0.2 mm, without a low-pass) log it, and `veloid identify` reads the log. Prints a row of the table in docs/latent-road.md for each effect and road: how
often the effect is named alone, something is left without a name, no verdict is given, nothing is missing, or something else is named. Needs numpy.
"""
import collections
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

ROADS = [("C", 3), ("D", 3), ("C", 5)]
EFFECTS = [
    None,
    ("coulomb_friction", "friction=20"),
    ("coulomb_friction", "friction=60"),
    ("cubic_stiffness", "k3=3e8"),
    ("quadratic_damping", "c2=1000"),
    ("quadratic_damping", "c2=2000"),
    ("asymmetric_damping", "asymmetry=0.2"),
    ("hysteresis", "stiffness=20000,yield_force=30"),
]
KEPT, LASER_HZ, LASER_M, ACCELEROMETER = 10, 30, 2e-4, 0.03


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{command}: {done.stderr.strip().splitlines()[-1]}")


def log(veloid, folder, effect, road, speed, seed):
    fine, ride = folder / "fine.csv", folder / "ride.csv"
    acts = ["--effect", f"{effect[0]}:rear:{effect[1]}"] if effect else []
    run(veloid, "simulate", fine, "--bike", folder / "bike.json", "--road", road, "--speed", speed, "--seed", seed, "--rate", 1000, *acts)
    r = np.genfromtxt(fine, delimiter=",", names=True)
    noise = np.random.default_rng(seed)
    front, rear = (np.gradient(np.gradient(r[z], r["t"]), r["t"]) for z in ("z_f", "z_r"))
    rows = collections.defaultdict(lambda: ["", "", "", ""])
    for i in range(0, len(r), KEPT):
        noisy = (a[i] + ACCELEROMETER * noise.standard_normal() for a in (front, rear))
        rows[round(r["t"][i], 6)][:3] = [*(f"{a:.6f}" for a in noisy), str(speed)]
    times = np.arange(0, r["t"][-1], 1 / LASER_HZ)
    deflections = np.interp(times, r["t"], r["u_r"] - r["z_r"])
    for t, d in zip(times, deflections):
        rows[round(t, 6)][3] = f"{d + 0.35 + LASER_M * noise.standard_normal():.7f}"
    lines = [f"{t}," + ",".join(rows[t]) for t in sorted(rows)]
    ride.write_text("\n".join(["t,a_f,a_r,v,d_r", *lines]) + "\n")
    return ride


def main():
    veloid, folder = sys.argv[1], Path(sys.argv[2])
    rides = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    folder.mkdir(parents=True, exist_ok=True)
    print("| rear axle | road, speed | named alone | unnamed | no verdict | nothing missing | other names |\n|---|---|---|---|---|---|---|")
    for effect in EFFECTS:
        for road, speed in ROADS:
            count = collections.Counter()
            for seed in range(1, rides + 1):
                ride = log(veloid, folder, effect, road, speed, seed)
                run(veloid, "identify", ride, "--bike", folder / "bike.json", "--trials", 1, "--iterations", 2, "--json", folder / "report.json")
                d = json.loads((folder / "report.json").read_text())["diagnosis"]
                found = [e["id"] for e in d["effects"]]
                right = effect and d["verdict"] == "named" and found == [effect[0]]
                count["right" if right else d["verdict"] if not found else "other"] += 1
            cells = [count[c] or "" for c in ("right", "unnamed", "cannot_tell", "nothing_missing", "other")]
            name = f"{effect[0]}, {effect[1]}" if effect else "nothing"
            print(f"| {name} | {road}, {speed} m/s | " + " | ".join(map(str, cells)) + " |", flush=True)


main()
