#!/usr/bin/env python3
"""Whether the ride that `identify` recommends settles a tie: next.py VELOID FOLDER [RIDES]

Simulates, for each effect, rides (a minute, class B, 20 um of noise on z) with the effect at one and a half times the size that `identify` says such a ride
shows. Where the truth is among sets that explain the ride equally, the next ride is ridden (other road, other noise, the same effect): the one that is
recommended, and one drawn from all that were compared. `veloid study` of both rides either settles the tie (the truth alone), or it does not. Prints a line
for each effect.
"""
import json
import random
import subprocess
import sys
from pathlib import Path

FACTOR = 1.5
# Effect, axle, parameter.
EFFECTS = [
    ("cubic_stiffness", "front", "k3"),
    ("progressive_stiffness", "front", "k2"),
    ("quadratic_damping", "front", "c2"),
    ("asymmetric_damping", "front", "asymmetry"),
    ("coulomb_friction", "front", "friction"),
    ("coulomb_friction", "rear", "friction"),
    ("guide_friction", "front", "friction"),
    ("ground_damping", "rear", "damping"),
    ("sensor_delay", "front", "delay"),
    ("speed_dependent_stiffness", "front", "slope"),
    ("tyre_enveloping", "front", "patch_length"),
]
# What is recommended, as `simulate` has it; the time is that of one pass (s).
PLANS = {
    "ride the same road again": ([], 60),
    "ride the same road a quarter slower": (["--speed", "3.75"], 80),
    "ride the same road a quarter faster": (["--speed", "6.25"], 48),
    "ride the same road at one and a half times the speed": (["--speed", "7.5"], 40),
    "ride the same road at a speed that varies by ±30 % with a period of 20 s": (["--speed-change", "0.3:20"], 60),
    "ride a road half as rough": (["--road", "A"], 60),
    "ride a road twice as rough": (["--road", "C"], 60),
    "ride a road four times as rough": (["--road", "D"], 60),
}


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{command}: {done.stderr.strip().splitlines()[-1]}")
    return done.stdout


def told(report):
    sets = [[e for e in report["effects"]], *report["alternatives"]]
    return [sorted((e.get("effect", e)["id"], e.get("effect", e)["axle"]) for e in one) for one in sets]


def main():
    veloid, folder = sys.argv[1], Path(sys.argv[2])
    rides = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    folder.mkdir(parents=True, exist_ok=True)
    bike = folder / "bike.json"
    draw = random.Random(1)

    def ride(name, seed, *more):
        path = folder / f"{name}_{seed}.csv"
        run(veloid, "simulate", path, "--seed", seed, "--bike", bike, "--noise", "2e-5", *more)
        return path

    def identify(path):
        return json.loads(run(veloid, "identify", path, "--bike", bike, "--trials", "1", "--iterations", "2", "--json", "-"))["diagnosis"]

    sizes = {(d["id"], d["axle"]): d["smallest_detectable"] for d in identify(ride("single", 7))["detectable"]}
    total = {"tied": 0, "advised": 0, "drawn": 0}
    for effect, axle, parameter in EFFECTS:
        if (effect, axle) not in sizes:
            print(effect, axle, "no size")
            continue
        acts = ["--effect", f"{effect}:{axle}:{parameter}={FACTOR * sizes[effect, axle]}"]
        for n in range(rides):
            first = ride(effect, 20_000 + n, *acts)
            d = identify(first)
            line = f"{effect} {axle} {n}: {d['verdict']}"
            if d["verdict"] == "ambiguous" and [(effect, axle)] in told(d):
                total["tied"] += 1
                line += f" {len(told(d))} sets"
                plan, *more = ((d["next_ride"] or {}).get("what") or "").split(", ")
                times = next((int(part.split()[0]) for part in more if part.endswith(" times")), 1)
                line += f"; {plan} {times} {(d['next_ride'] or {}).get('predicted_separation', 0):.0f}"
                seconds = times * PLANS[plan][1] if plan else 60
                ways = {"advised": plan and PLANS[plan][0], "drawn": draw.choice(list(PLANS.values()))[0]}
                ways = {way: None if args == "" else [*args, "--duration", seconds] for way, args in ways.items()}
                for way, args in ways.items():
                    if args is None:
                        line += f"; {way}: none"
                        continue
                    second = ride(effect, 30_000 + n, *acts, *args)
                    study = json.loads(run(veloid, "study", first, second, "--bike", bike, "--json", "-"))
                    settled = study["verdict"] == "named" and told(study)[0] == [(effect, axle)]
                    total[way] += settled
                    line += f"; {way} ({' '.join(map(str, args))}): " + ("settled" if settled else f"{study['verdict']} {told(study)}")
            print(line, flush=True)
    print(total)


main()
