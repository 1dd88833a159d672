#!/usr/bin/env python3
"""`veloid study` as colleagues use it, over HTTP: over_http.py study RIDE... --bike BIKE --json -

Sends the rides to the server at VELOID_SERVER (http://127.0.0.1:8080), posts a study of them and prints its report; any other command is passed on
to the program that VELOID names. For `veloid-truth studies --binary tests/rigs/over_http.py --seed N`.
"""
import json
import os
import subprocess
import sys
import urllib.error
import urllib.parse
from pathlib import Path

import season

SERVER = os.environ.get("VELOID_SERVER", "http://127.0.0.1:8080")


def asked(path, body=None, kind="application/json"):
    return season.asked(SERVER, path, body, {"Content-Type": kind})


def finished(job):
    while job["state"] in ("queued", "running"):
        job = asked(job["links"]["job"] + "?wait=30")
    return job


def ended(message):
    print(message, file=sys.stderr)
    raise SystemExit(2)


def study(rides, bike):
    # A bicycle of its own for each set, so that no other set's rides are among its latest.
    bike["bike"] = rides[0].stem.rsplit("_", 1)[0]
    jobs = []
    for ride in rides:
        query = urllib.parse.urlencode({"name": ride.name, "bike": json.dumps(bike), "trials": 1, "iterations": 2})
        jobs.append(asked(f"/v1/rides?{query}", ride.read_bytes(), "text/csv"))
    jobs = [finished(job) for job in jobs]
    try:
        job = finished(asked("/v1/studies", json.dumps({"rides": [job["ride"]["id"] for job in jobs]}).encode()))
    except urllib.error.HTTPError as error:
        ended(json.load(error)["detail"])
    if job["state"] != "succeeded":
        ended(job["failure"]["detail"])
    return asked(job["links"]["report"])


def main():
    if sys.argv[1:2] != ["study"]:
        raise SystemExit(subprocess.run([os.environ["VELOID"], *sys.argv[1:]]).returncode)
    at = sys.argv.index("--bike")
    print(json.dumps(study([Path(ride) for ride in sys.argv[2:at]], json.loads(Path(sys.argv[at + 1]).read_text()))))


main()
