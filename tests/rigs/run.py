"""What veloid says of the benches that make.py wrote: a row each, and whether it is as an expert would."""

import json
import pathlib
import subprocess
import sys

FOLDER, VELOID = pathlib.Path(sys.argv[1]), sys.argv[2]
SHORT = ["--trials", "1", "--iterations", "2", "--particles", "4"]

right = 0
names = sorted(path.stem for path in FOLDER.glob("*.expected"))
for name in names:
    expected = json.loads((FOLDER / f"{name}.expected").read_text())
    ride, bike = FOLDER / f"{name}.csv", FOLDER / f"{name}.json"
    command = [VELOID, "identify", ride, "--bike", bike, "--json", "-", *SHORT]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        print(f"| {name} | {', '.join(expected)} | {done.stderr.strip().splitlines()[-1]} | |")
        continue
    found = json.loads(done.stdout)["diagnosis"]
    affirmed = [effect["id"] for effect in found["effects"] if effect["affirmed"]]
    if expected:
        is_right = bool(affirmed) and set(affirmed) <= set(expected)
    else:
        is_right = found["verdict"] == "nothing_missing"
    right += is_right
    print(f"| {name} | {', '.join(expected)} | `{found['verdict']}` {', '.join(affirmed)} | {'✓' if is_right else ''} |", flush=True)
print(f"{right} of {len(names)} as an expert")
