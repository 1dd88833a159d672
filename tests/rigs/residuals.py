"""Whitened residuals of simulated rides that the plain model explains, and how many of their correlations leave the 99 % bounds:
python3 tests/rigs/residuals.py VELOID FOLDER RIDES"""

import json
import pathlib
import random
import subprocess
import sys

VELOID, FOLDER, RIDES = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3])
SHORT = ["--trials", "1", "--iterations", "2", "--particles", "4", "--no-diagnosis"]
TESTS = ["autocorrelation", "cross_correlation"]

FOLDER.mkdir(parents=True, exist_ok=True)
ride, bike = FOLDER / "ride.csv", FOLDER / "bike.json"
outside, lags = dict.fromkeys(TESTS, 0), dict.fromkeys(TESTS, 0)
many, axles, largest = dict.fromkeys(TESTS, 0), 0, 0
for seed in range(1, RIDES + 1):
    draw = random.Random(seed)
    made = {
        "duration": draw.choice([20, 60, 120]), "rate": draw.choice([100, 200]), "speed": draw.uniform(3, 8), "road": draw.choice("ABC"),
        "noise": draw.choice([2e-5, 5e-5, 1e-4]), "stiffness": f"{draw.uniform(4e4, 1.4e5)}:{draw.uniform(6e4, 2e5)}",
        "damping": f"{draw.uniform(300, 1500)}:{draw.uniform(500, 2500)}", "seed": seed,
    }
    options = [text for name, value in made.items() for text in (f"--{name}", str(value))]
    subprocess.run([VELOID, "simulate", ride, "--bike", bike, *options], check=True, capture_output=True)
    done = subprocess.run([VELOID, "identify", ride, "--bike", bike, "--json", "-", *SHORT], capture_output=True, text=True)
    if done.returncode:
        print(f"{made}: {done.stderr.strip().splitlines()[-1]}")
        continue
    for axle in json.loads(done.stdout)["validation"].values():
        axles += 1
        largest = max(largest, len(json.dumps(axle, separators=(",", ":"))))
        for test in TESTS:
            found = axle["residual"][test]
            outside[test] += found["outside"]
            lags[test] += found["lags"]
            many[test] += "as white noise would" not in found["sentence"]
for test in TESTS:
    print(f"{test}: {100 * outside[test] / lags[test]:.2f} % of {lags[test]} lags outside; said to be no white noise: {many[test]} of {axles}")
print(f"largest validation: {largest} bytes")
