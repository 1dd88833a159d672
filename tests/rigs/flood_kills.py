"""Kills a server on SQLite at random moments beside a flood of three groups, while a fourth sends one ride a minute.

    python3 tests/rigs/flood_kills.py target/debug/veloid --kills 500 --seed 1

Prints what became of every acknowledged ride, the longest wait of the fourth group, and exits with 1 if a ride was lost,
counted twice or given up. Needs `requests`.
"""

import argparse
import random
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time

import requests

FLOOD = ["flood-a", "flood-b", "flood-c"]
# Unfinished rides that each group of the flood keeps.
WAITING = 12


class Server:
    def __init__(self, binary, folder):
        self.binary, self.folder = binary, folder
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"

    def key(self, group):
        made = subprocess.run(
            [self.binary, "key", "create", "--data", self.folder, "--group", group], capture_output=True, text=True, check=True
        )
        return next(word for word in made.stdout.split() if word.startswith("veloid"))

    def start(self):
        log = open(f"{self.folder}/log", "a")
        arguments = ["serve", "--data", self.folder, "--listen", f"127.0.0.1:{self.port}", "--keys", "--workers", "2"]
        self.process = subprocess.Popen([self.binary, *arguments], stdout=log, stderr=log)

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


class Group(threading.Thread):
    """Sends rides and notes those that were acknowledged."""

    def __init__(self, server, name, ride, bike, pause, most):
        super().__init__(daemon=True)
        self.server, self.name_of_group, self.pause, self.most = server, name, pause, most
        self.headers = {"Authorization": "Bearer " + server.key(name)}
        self.files = {"file": ("ride.csv", ride), "bike": ("bike.json", bike)}
        self.acknowledged, self.open, self.longest, self.over = {}, {}, 0.0, threading.Event()

    def ask(self, method, path, **more):
        """The answer, once a server gives one."""
        while True:
            try:
                answer = requests.request(method, self.server.url + path, headers=self.headers | more.pop("headers", {}), timeout=30, **more)
                if answer.status_code < 500:
                    return answer
            except requests.RequestException:
                pass
            time.sleep(0.05)

    def send(self, number):
        data = {"seed": str(number), "trials": "3", "iterations": "10"}
        more = {"data": data, "files": self.files, "headers": {"Idempotency-Key": f"{self.name_of_group}-{number}"}}
        begin = time.monotonic()
        while True:
            try:
                answer = requests.post(self.server.url + "/v1/rides", timeout=30, **(more | {"headers": self.headers | more["headers"]}))
                if answer.status_code == 202:
                    break
                if answer.status_code < 429:
                    sys.exit(f"{answer.status_code}: {answer.text}")
            except requests.RequestException:
                pass
            time.sleep(0.05)
        location = answer.headers["Location"]
        self.acknowledged[number] = location
        self.open[location] = begin

    def look(self):
        for location, begin in list(self.open.items()):
            view = self.ask("GET", location).json()
            if view["state"] not in ("queued", "running"):
                del self.open[location]
                self.longest = max(self.longest, time.monotonic() - begin)

    def run(self):
        number, due = 0, 0.0
        while not self.over.is_set():
            self.look()
            if len(self.open) < self.most and time.monotonic() >= due:
                self.send(number)
                number, due = number + 1, time.monotonic() + self.pause
            else:
                time.sleep(0.1)
        while self.open:
            self.look()
            time.sleep(0.1)


def most_losses(folder):
    """Most kills in a row that one ride has met without progress."""
    database = sqlite3.connect(f"file:{folder}/veloid.db?mode=ro", uri=True)
    return database.execute("SELECT max(lost) FROM job").fetchone()[0] or 0


def outcome(folder, groups):
    """Acknowledged rides that are not there, jobs with other than one report, jobs that did not succeed."""
    database = sqlite3.connect(f"file:{folder}/veloid.db?mode=ro", uri=True)
    states = dict(database.execute("SELECT lower(hex(id)), state FROM job"))
    reports = dict(database.execute("SELECT lower(hex(job_id)), count(*) FROM result WHERE name = 'report' GROUP BY 1"))
    ids = [location.rsplit("/", 1)[1].replace("-", "") for group in groups for location in group.acknowledged.values()]
    lost = sum(id not in states for id in ids)
    twice = len(ids) - len(set(ids)) + len(states) - len(set(ids)) + sum(count > 1 for count in reports.values())
    given_up = sum(states.get(id) != "succeeded" or reports.get(id) != 1 for id in ids) - lost
    return len(ids), lost, twice, given_up


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("binary")
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--between", type=float, default=2.5, help="longest time between a start and its kill (s)")
    asked = parser.parse_args()
    folder = tempfile.mkdtemp(prefix="veloid-flood-kills-")
    server = Server(asked.binary, folder)
    simulate = [asked.binary, "simulate", f"{folder}/ride.csv", "--bike", f"{folder}/bike.json", "--duration", "15", "--noise", "3e-5"]
    subprocess.run(simulate, check=True, capture_output=True)
    ride, bike = (open(f"{folder}/{name}", "rb").read() for name in ("ride.csv", "bike.json"))
    groups = [Group(server, name, ride, bike, 0.0, WAITING) for name in FLOOD]
    quiet = Group(server, "quiet", ride, bike, 60.0, 1)
    server.start()
    for group in [*groups, quiet]:
        group.start()
    chance, begin, losses = random.Random(asked.seed), time.monotonic(), 0
    for kill in range(asked.kills):
        time.sleep(chance.uniform(0.1, asked.between))
        server.kill()
        losses = max(losses, most_losses(folder))
        server.start()
        if kill % 50 == 49:
            done = sum(len(group.acknowledged) for group in groups)
            print(f"{kill + 1} kills, {done} rides of the flood acknowledged, quiet: {len(quiet.acknowledged)}, longest {quiet.longest:.1f} s", flush=True)
    for group in [*groups, quiet]:
        group.over.set()
    for group in [*groups, quiet]:
        group.join()
    server.kill()
    rides, lost, twice, given_up = outcome(folder, [*groups, quiet])
    print(
        f"{asked.kills} kills in {time.monotonic() - begin:.0f} s, seed {asked.seed}: {rides} rides acknowledged, {lost} lost, {twice} double, "
        f"{given_up} given up; the group of one ride a minute ({len(quiet.acknowledged)} rides) waited at most {quiet.longest:.1f} s; a ride met at most {losses} kills without progress"
    )
    shutil.rmtree(folder)
    sys.exit(lost + twice + given_up > 0)


main()
