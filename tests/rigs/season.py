"""Seasons of simulated bicycles through a server: which parameter changes, and from which ride on that is reported.

    python3 tests/rigs/season.py VELOID [--address URL] [--rides 30] [--only TEXT]

VELOID simulates the rides; without an address it also serves, in a folder of its own. Each ride lasts 60 s, with noise of 0.1 mm on road and displacement, on another road, four rides a
week. After each ride the bicycle's course is asked for, as a dashboard does.
"""

import argparse
import datetime
import json
import random
import socket
import subprocess
import tempfile
import time
import urllib.parse
import urllib.request
from pathlib import Path

MASS_KG, K_N_M, B_N_S_M = 23.0, 110e3, 1150.0
# Change of k with temperature (1/K) and day-to-day scatter of k that is no change (share).
PER_K, SCATTER = 2e-3, 0.002


def ridden(kind, i, rides, luck):
    """Stiffness, mass, friction and facts of ride i."""
    k = K_N_M * (1 + SCATTER * luck.gauss(0, 1))
    mass, friction, facts = MASS_KG, 0.0, {}
    if kind == "leak":
        k *= 0.99 ** (i / 4)
    elif kind == "service" and i >= rides // 2:
        k *= 0.97
    elif kind == "friction":
        friction = 20.0 * i / (rides - 1)
    elif kind == "temperature":
        celsius = 25 - 20 * i / (rides - 1) + luck.gauss(0, 3)
        k *= 1 - PER_K * (celsius - 15)
        facts["temperature_c"] = round(celsius, 1)
    elif kind == "riders":
        facts["rider"] = luck.choice(["ada", "ben"])
        if facts["rider"] == "ben":
            mass, k = 27.0, 1.02 * k
    return k, mass, friction, facts


def simulated(veloid, folder, kind, i, rides):
    luck = random.Random(f"{kind} {i}")
    k, mass, friction, facts = ridden(kind, i, rides, luck)
    ride, bike = Path(folder) / f"{kind}-{i:03}.csv", Path(folder) / "bike.json"
    command = [veloid, "simulate", str(ride), "--bike", str(bike), "--only", "front", "--stiffness", f"{k}", "--damping", f"{B_N_S_M}"]
    command += ["--mass", f"{mass}:63", "--noise", "1e-4", "--road-noise", "1e-4", "--seed", str(1000 * sum(map(ord, kind)) + i)]
    if friction > 0:
        command += ["--effect", f"coulomb_friction:front:friction={friction}"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    document = json.loads(bike.read_text())
    document["bike"] = kind
    day = datetime.date(2026, 1, 5) + datetime.timedelta(days=7 * i / 4)
    return ride, document, {**facts, "ridden_at": f"{day}T10:00:00Z"}


def asked(address, path, body=None, headers=None):
    request = urllib.request.Request(address + path, data=body, headers=headers or {})
    with urllib.request.urlopen(request, timeout=120) as answer:
        return json.load(answer)


def sent(address, ride, bike, facts):
    query = urllib.parse.urlencode({"name": ride.name, "bike": json.dumps(bike), "facts": json.dumps(facts), "trials": 1})
    job = asked(address, f"/v1/rides?{query}", ride.read_bytes(), {"Content-Type": "text/csv"})
    while job["state"] in ("queued", "running"):
        time.sleep(0.1)
        job = asked(address, job["links"]["job"])
    return job


def course(address, bike, rides):
    """The courses once the latest ride and those that are fitted again are in them."""
    before = None
    while True:
        found = asked(address, f"/v1/bikes/{bike}/course")["courses"]
        if found == before:
            return found
        before = found
        time.sleep(0.5)


def season(veloid, address, folder, kind, rides):
    reported = {}
    named, verdicts, found = [], [], []
    for i in range(rides):
        job = sent(address, *simulated(veloid, folder, kind, i, rides))
        verdicts.append(job["verdict"])
        if job["verdict"] == "named":
            named.append(i + 1)
        found = course(address, kind, i)
        for one in found:
            development = one["development"]
            if development and development["kind"] != "none":
                reported.setdefault((one["name"], development["kind"]), i + 1)
    said = ", ".join(f"{name}: {what} from ride {ride}" for (name, what), ride in reported.items()) or "none"
    at_last = [f"{one['name']} {one['development']['kind']}" for one in found if one["development"] and one["development"]["kind"] != "none"]
    print(f"| {kind} | {said} | {', '.join(at_last) or 'none'} | {', '.join(map(str, named)) or 'none'} |", flush=True)


def served(veloid, folder):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
    process = subprocess.Popen([veloid, "serve", "--listen", address, "--data", f"{folder}/data"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    for _ in range(100):
        try:
            asked(f"http://{address}", "/healthz")
            break
        except (OSError, ValueError):
            time.sleep(0.1)
    return process, f"http://{address}"


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("veloid")
    options.add_argument("--address")
    options.add_argument("--rides", type=int, default=30)
    options.add_argument("--only", default="")
    given = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        process, address = (None, given.address) if given.address else served(given.veloid, folder)
        try:
            print("| season | reported | after the last ride | rides on which an effect was named |\n|---|---|---|---|", flush=True)
            for kind in ("unchanged", "leak", "service", "friction", "temperature", "riders"):
                if given.only in kind:
                    season(given.veloid, address, folder, kind, given.rides)
        finally:
            if process:
                process.terminate()
                process.wait()


if __name__ == "__main__":
    main()
