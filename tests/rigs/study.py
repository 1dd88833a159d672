#!/usr/bin/env python3
"""Whether ten rides together show what one cannot: study.py VELOID FOLDER [SETS]

For each effect SETS sets of ten simulated rides (a minute, class B, 20 um of noise on z) with the effect at 0.4 of the size that
`identify` says one such ride shows, and as many sets without any effect. A set is found if exactly that effect is affirmed, or
stands among sets said to explain the rides as well; a clean set if nothing is missing. Prints a line for each effect.
"""
import json
import subprocess
import sys
from pathlib import Path

SHARE = 0.4
RIDES = 10
NOISE = ["--noise", "2e-5"]
# Effect, axle, parameter.
EFFECTS = [
    ("cubic_stiffness", "front", "k3"),
    ("cubic_stiffness", "rear", "k3"),
    ("progressive_stiffness", "front", "k2"),
    ("quadratic_damping", "front", "c2"),
    ("quadratic_damping", "rear", "c2"),
    ("asymmetric_damping", "front", "asymmetry"),
    ("coulomb_friction", "front", "friction"),
    ("coulomb_friction", "rear", "friction"),
    ("guide_friction", "front", "friction"),
    ("ground_damping", "rear", "damping"),
    ("sensor_delay", "front", "delay"),
    ("tyre_enveloping", "front", "patch_length"),
]


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{command}: {done.stderr.strip().splitlines()[-1]}")
    return done.stdout


def main():
    veloid, folder = sys.argv[1], Path(sys.argv[2])
    sets = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    folder.mkdir(parents=True, exist_ok=True)
    bike = folder / "bike.json"

    def ride(name, seed, effect=()):
        path = folder / f"{name}_{seed}.csv"
        run(veloid, "simulate", path, "--seed", seed, "--bike", bike, *NOISE, *effect)
        return path

    def study(name, first, effect=()):
        rides = [ride(name, first + i, effect) for i in range(RIDES)]
        report = json.loads(run(veloid, "study", *rides, "--bike", bike, "--json", "-"))
        for path in rides:
            path.unlink()
        return report

    single = ride("single", 7)
    report = json.loads(run(veloid, "identify", single, "--bike", bike, "--trials", "1", "--iterations", "2", "--json", "-"))
    sizes = {(d["id"], d["axle"]): d["smallest_detectable"] for d in report["diagnosis"]["detectable"]}

    clean = sum(study("clean", 100 * n + 1)["verdict"] == "nothing_missing" for n in range(sets * len(EFFECTS)))
    print(f"{'clean':40}{clean} of {sets * len(EFFECTS)}", flush=True)
    total = [0, 0, 0]
    for effect, axle, parameter in EFFECTS:
        size = SHARE * sizes[effect, axle]
        found, tied, missed = 0, 0, []
        for n in range(sets):
            told = study(effect, 10_000 + 100 * n, ["--effect", f"{effect}:{axle}:{parameter}={size}"])
            sets_told = [[e["effect"] for e in told["effects"]], *told["alternatives"]]
            names = [[(e["id"], e["axle"]) for e in one] for one in sets_told]
            if told["verdict"] == "named" and names[0] == [(effect, axle)]:
                found += 1
            elif told["verdict"] == "ambiguous" and [(effect, axle)] in names:
                tied += 1
            else:
                missed.append(f"{told['verdict']} {names[0]}")
        total = [total[0] + found, total[1] + tied, total[2] + sets]
        print(f"{effect + ' ' + axle:30}{size:10.3g}  named {found}, among ties {tied}, of {sets}  {'; '.join(missed)}", flush=True)
    print(f"{'effects':40}named {total[0]}, among ties {total[1]}, of {total[2]}")


main()
