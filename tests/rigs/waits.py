#!/usr/bin/env python3
"""How long a diagnosis takes, one `veloid` after the other: waits.py VELOID FOLDER [--rides RIDES]

Rides of a minute at 100 Hz, two axles, by `veloid simulate`: nothing, one and three effects left out; five minutes with one; ten
rides as one study beside the ten alone. RIDES is a folder of `veloid-truth make` (with RIDES_key.json), whose first ten rides
that tests/truth/expert.py has a law for are identified on all cores and on one. Prints a Markdown table: wall time, processor time.
"""
import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "truth"))

NOISE = ["--noise", "2e-5"]
FRICTION = ["--effect", "coulomb_friction:front:friction=20"]
SLIGHT = ["--effect", "coulomb_friction:front:friction=10"]
THREE = [*FRICTION, "--effect", "cubic_stiffness:rear:k3=2e8", "--effect", "sensor_delay:front:delay=0.004"]


def timed(command, **env):
    """Wall time and processor time (s)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun = time.perf_counter()
    subprocess.run([str(c) for c in command], check=True, capture_output=True, env={**os.environ, **env})
    wall = time.perf_counter() - begun
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def row(what, times):
    walls, processor = zip(*times)
    wall, each = statistics.median(walls), statistics.median(processor)
    print(f"| {what} | {len(times)} | {wall:.2f} s | {max(walls):.2f} s | {each:.2f} s |", flush=True)
    return sum(walls), sum(processor)


class Rides:
    def __init__(self, veloid, folder):
        self.veloid, self.folder = veloid, folder
        folder.mkdir(parents=True, exist_ok=True)

    def identify(self, ride, bike, **env):
        report = self.folder / f"report_{ride.stem.removeprefix('ride_')}.json"
        return timed([self.veloid, "identify", ride, "--bike", bike, "--json", report], **env)

    def simulated(self, count, first, *arguments):
        bike = self.folder / "bike.json"
        rides = [self.folder / f"{first + i}.csv" for i in range(count)]
        for i, ride in enumerate(rides):
            timed([self.veloid, "simulate", ride, "--bike", bike, "--seed", first + i, *NOISE, *arguments])
        return rides, bike

    def alone(self, what, rides, bike):
        return row(what, [self.identify(ride, bike) for ride in rides])

    def together(self, what, first, *arguments):
        rides, bike = self.simulated(10, first, *arguments)
        wall, processor = self.alone(f"{what}, each of ten", rides, bike)
        study = timed([self.veloid, "study", *rides, "--bike", bike, "--json", self.folder / "study.json"])
        row(f"{what}, the ten as one study: {study[0] / wall:.2f} and {study[1] / processor:.2f} times their sum", [study])

    def on_cores(self, folder):
        from expert import EFFECTS

        key = json.loads(Path(f"{folder}_key.json").read_text())["rides"]
        known = [r["ride"] for r in key if [e["id"] in EFFECTS for e in r["effects"]] == [True] and not r.get("outside")]
        pairs = [(folder / f"ride_{name}.csv", folder / f"bike_{name}.json") for name in known[:10]]
        every = row("one effect, `veloid-truth`", [self.identify(*pair) for pair in pairs])
        one = row("the same on one core", [self.identify(*pair, RAYON_NUM_THREADS="1") for pair in pairs])
        print(f"| all cores are so many times one | | {one[0] / every[0]:.2f} | | |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("veloid", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rides", type=Path)
    asked = parser.parse_args()
    rides = Rides(asked.veloid, asked.folder)
    print("| what | rides | median | worst | processor time, median |\n|---|---|---|---|---|")
    if asked.rides:
        rides.on_cores(asked.rides)
    rides.alone("nothing", *rides.simulated(5, 40))
    rides.alone("three effects", *rides.simulated(3, 50, *THREE))
    rides.alone("one effect, 300 s", *rides.simulated(3, 60, "--duration", 300, *FRICTION))
    rides.together("nothing", 70)
    rides.together("friction", 80, *SLIGHT)


if __name__ == "__main__":
    main()
