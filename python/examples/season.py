#!/usr/bin/env python3
"""Uploads a season of several bicycles to a server: simulated rides over 180 days, sent through the API.

    veloid serve &
    python3 python/examples/season.py --server http://127.0.0.1:8080 --bikes 3 --rides 12

needs only Python and the program `veloid`, which simulates the rides. The front tyre of the first bicycle leaks, the rear tyre
of the second one is changed at midsummer, the others stay the same; k changes by 15 % per bar. Each ride is sent with its facts:
date, pressures, temperature, rider, tyres.
"""
import argparse
import datetime
import json
import random
import subprocess
import time
import urllib.error
import urllib.request
import uuid

DAYS = 180
STIFFNESS = 110e3
PER_BAR = 0.15
USUAL_BAR = 2.3
BOUNDARY = uuid.uuid4().hex


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    parser.add_argument("--key", help="if the server requires one")
    parser.add_argument("--veloid", default="veloid", help="the program")
    parser.add_argument("--bikes", type=int, default=3)
    parser.add_argument("--rides", type=int, default=12, help="of each bicycle")
    parser.add_argument("--duration", type=float, default=30, help="of a ride (s)")
    return parser.parse_args()


def ridden(bike, passed, draw):
    """Facts of a ride at this fraction of the season, and its front and rear stiffness (N/m)."""
    leak = 1.2 * passed - 0.6 if bike == 0 else 0.0
    pressures = [round(USUAL_BAR - lost + draw.gauss(0, 0.05), 2) for lost in (leak, 0.0)]
    changed = bike == 1 and passed > 0.5
    day = datetime.date.today() - datetime.timedelta(days=DAYS * (1 - passed))
    facts = {
        "ridden_at": day.isoformat(),
        "pressure_front_bar": pressures[0],
        "pressure_rear_bar": pressures[1],
        "temperature_c": round(18 + 6 * draw.gauss(0, 1), 1),
        "rider": f"rider {bike + 1}",
        "tyres": "new rear tyre" if changed else "as delivered",
    }
    stiffness = [STIFFNESS * (1 + PER_BAR * (bar - USUAL_BAR)) for bar in pressures]
    stiffness[1] *= 1.15 if changed else 1.0
    return facts, stiffness


def simulated(args, stiffness, seed):
    command = [args.veloid, "simulate", "-", "--road", "C", "--noise", "5e-5"]
    command += ["--duration", str(args.duration), "--seed", str(seed)]
    command += ["--stiffness", "{:.0f}:{:.0f}".format(*stiffness)]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout


def form(file, fields):
    """The body of a form with a file, `multipart/form-data`."""
    head = '--{}\r\nContent-Disposition: form-data; name="{}"{}\r\n\r\n'
    body = head.format(BOUNDARY, "file", '; filename="ride.csv"').encode() + file
    for name, value in fields.items():
        body += ("\r\n" + head.format(BOUNDARY, name, "") + str(value)).encode()
    return body + f"\r\n--{BOUNDARY}--\r\n".encode()


def send(args, body):
    """Sends a ride, retrying while the server is busy, and returns the address of its job."""
    headers = {"Content-Type": f"multipart/form-data; boundary={BOUNDARY}"}
    if args.key:
        headers["Authorization"] = f"Bearer {args.key}"
    request = urllib.request.Request(args.server.rstrip("/") + "/v1/rides", body, headers)
    while True:
        try:
            with urllib.request.urlopen(request) as answer:
                return json.load(answer)["links"]["job"]
        except urllib.error.HTTPError as refused:
            if refused.code not in (429, 503):
                raise SystemExit(f"{refused}: {refused.read().decode()}") from None
            time.sleep(float(refused.headers.get("Retry-After", 1)))


def main():
    args = arguments()
    draw = random.Random(1)
    for ride in range(args.rides):
        passed = (ride + 0.5) / args.rides
        for bike in range(args.bikes):
            name = f"season-{bike + 1}"
            facts, stiffness = ridden(bike, passed, draw)
            file = simulated(args, stiffness, 1 + ride * args.bikes + bike)
            masses = {"bike": name, "mass_front_kg": 23.0, "mass_rear_kg": 63.0, "l_front_m": 0.808, "l_rear_m": 0.293}
            fields = {"bike": json.dumps(masses), "name": f"{name} {facts['ridden_at']}.csv", **facts}
            job = send(args, form(file, fields))
            print(f"{facts['ridden_at']}  {name}  {job}", flush=True)


if __name__ == "__main__":
    main()
