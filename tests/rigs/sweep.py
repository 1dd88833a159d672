"""Verdicts on real recordings, whole and with parts cut off, with their reports kept, and what each costs.

usage: sweep.py VELOID REAL FOLDER [--only TEXT] [--whole] [--jobs N] [--cases cases_new.json] [--scores]

REAL holds cases.json and the recordings. Reports that FOLDER has already are not made again.
With --scores what every set of effects leaves of held-out windows is kept in the place of reports, for `cargo run --example judge`."""

import argparse
import concurrent.futures
import json
import pathlib
import re
import statistics
import subprocess
import time

CUTS = (0.05, 0.1, 0.15, 0.2)
PARTS = [(0, 1), *((c, 1) for c in CUTS), *((0, 1 - c) for c in CUTS)]


def rows(real, case):
    """The first data row that a case uses, and the one behind its last."""
    arguments = case.get("arguments", [])
    if "--rows" in arguments:
        return [int(x) for x in arguments[arguments.index("--rows") + 1].split(":")]
    lines = (real / case["file"]).read_text(errors="replace").splitlines()
    return 0, sum(1 for line in lines if re.match(r"\s*[-+.\d]", line))


def command(veloid, real, case, part, bike, output):
    first, last = rows(real, case)
    arguments = list(case.get("arguments", []))
    if "--rows" in arguments:
        at = arguments.index("--rows")
        del arguments[at : at + 2]
    count = last - first
    arguments += ["--rows", f"{first + int(part[0] * count)}:{first + int(part[1] * count)}"]
    for channel, column in case["map"].items():
        arguments += ["--map", f"{channel}={column}"]
    return [veloid, "identify", real / case["file"], "--bike", bike, *output, *arguments]


def scores(veloid, real, folder, case, part):
    name = case.get("name", case["file"])
    kept = folder / f"{re.sub(r'[^a-z0-9]+', '_', name.lower())}_{part[0]:.2f}_{part[1]:.2f}.json"
    if kept.exists():
        return
    bike = kept.with_suffix(".bike")
    bike.write_text(json.dumps({"bike": "bench", "mass_front_kg": case["mass"]}))
    made = kept.with_suffix(".scores")
    quick = ["--scores", made, "--trials", "1", "--iterations", "2", "--particles", "4"]
    done = subprocess.run(command(veloid, real, case, part, bike, quick), capture_output=True, text=True)
    found = json.loads(made.read_text()) if done.returncode == 0 else None
    asked = {key: case[key] for key in ("expected", "acceptable")}
    kept.write_text(json.dumps({"name": name, "part": part, **asked, "scores": found}))
    bike.unlink()
    made.unlink(missing_ok=True)


def ask(veloid, real, folder, case, part):
    name = case.get("name", case["file"])
    kept = folder / f"{re.sub(r'[^a-z0-9]+', '_', name.lower())}_{part[0]:.2f}_{part[1]:.2f}.json"
    if not kept.exists():
        bike = kept.with_suffix(".bike")
        bike.write_text(json.dumps({"bike": "bench", "mass_front_kg": case["mass"]}))
        begun = time.monotonic()
        done = subprocess.run(command(veloid, real, case, part, bike, ["--json", "-"]), capture_output=True, text=True)
        diagnosis = json.loads(done.stdout)["diagnosis"] if done.returncode == 0 else None
        kept.write_text(
            json.dumps(
                {
                    "name": name,
                    "part": part,
                    "expected": case["expected"],
                    "acceptable": case["acceptable"],
                    "seconds": time.monotonic() - begun,
                    "refused": done.returncode == 2,
                    "message": (done.stderr.strip().splitlines() or [""])[-1],
                    "diagnosis": diagnosis,
                }
            )
        )
        bike.unlink()
    return json.loads(kept.read_text())


def affirmed(diagnosis):
    if diagnosis["verdict"] not in ("named", "named_in_part", "ambiguous"):
        return set()
    return {e["id"] for e in diagnosis["effects"] if e["affirmed"]}


def answer(asked):
    """As ../shared/real/sweep.py counts: right, missed or wrong."""
    diagnosis, wanted, may = asked["diagnosis"], set(asked["expected"]), set(asked["acceptable"])
    if diagnosis is None:
        if not asked["refused"]:
            return "wrong"
        return "missed" if wanted else "right"
    if diagnosis["verdict"] == "nothing_missing" and "nothing_missing" in wanted:
        return "right"
    sets = [affirmed(diagnosis)]
    if diagnosis["verdict"] == "ambiguous":
        sets += [{e["id"] for e in other} for other in diagnosis["alternatives"]]
    sets = [s for s in sets if s] or [set()]
    fits = [not s - wanted - may and (bool(s & wanted) or not (wanted or s)) for s in sets]
    if len(sets) <= 3 and any(fits):
        return "right"
    return "wrong" if all(s - wanted - may for s in sets) else "missed"


def show(asked):
    diagnosis = asked["diagnosis"]
    if diagnosis is None:
        return asked["message"]
    return f"{diagnosis['verdict']} {' + '.join(sorted(affirmed(diagnosis)))}"


def table(all_asked):
    names = dict.fromkeys(a["name"] for a in all_asked)
    total = dict.fromkeys(("right", "missed", "wrong"), 0)
    print("| recording | right | missed | wrong | median s |\n|---|---|---|---|---|")
    for name in names:
        own = [a for a in all_asked if a["name"] == name]
        count = {said: sum(answer(a) == said for a in own) for said in total}
        total = {said: total[said] + count[said] for said in total}
        median = statistics.median(a["seconds"] for a in own)
        print(f"| {name} | {count['right']} | {count['missed']} | {count['wrong']} | {median:.1f} |")
    seconds = [a["seconds"] for a in all_asked]
    print(f"| all | {total['right']} | {total['missed']} | {total['wrong']} | {statistics.median(seconds):.1f}, worst {max(seconds):.0f} |\n")
    for a in all_asked:
        if answer(a) != "right":
            print(f"{answer(a):7} {a['name']} {a['part'][0]:.2f} to {a['part'][1]:.2f}: {show(a)}")


def figures(all_asked):
    """The table of docs/real.md: whole recordings with what is affirmed, its 95 % intervals, and the held-out error without and with it."""
    print("\n| recording | experts | veloid | plain -> extended | s | |\n|---|---|---|---|---|---|")
    for a in (a for a in all_asked if a["part"] == [0, 1]):
        said, error, d = "refused", "", a["diagnosis"]
        if d is not None:
            effects = [e for e in d["effects"] if e["affirmed"]]
            parameters = [(name, p) for e in effects for name, p in e["parameters"].items()]
            spread = lambda p: f" ± {1.96 * p['std_error']:.2g}" if p["std_error"] else ""
            numbers = (f"{name} {p['value']:.4g}{spread(p)} {p['unit']}" for name, p in parameters)
            said = f"`{d['verdict']}` " + ", ".join(e["id"] for e in effects) + (f" ({', '.join(numbers)})" if effects else "")
            held = d["held_out"]["front"] or {}
            errors = [held.get(k) for k in ("plain_rms_m", "extended_rms_m")]
            error = " -> ".join(f"{e:.3g}" for e in dict.fromkeys(errors) if e is not None)
        tick = "✓" if answer(a) == "right" else ""
        print(f"| {a['name']} | {', '.join(a['expected']) or 'refused'} | {said} | {error} | {a['seconds']:.0f} | {tick} |")


def main():
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("veloid")
    asked.add_argument("real", type=pathlib.Path)
    asked.add_argument("folder", type=pathlib.Path)
    asked.add_argument("--only", default="")
    asked.add_argument("--whole", action="store_true")
    asked.add_argument("--jobs", type=int, default=2)
    asked.add_argument("--cases", default="cases.json")
    asked.add_argument("--scores", action="store_true")
    asked = asked.parse_args()
    veloid, real, folder = asked.veloid, asked.real, asked.folder
    folder.mkdir(parents=True, exist_ok=True)
    cases = json.loads((real / asked.cases).read_text())["cases"]
    parts = PARTS[:1] if asked.whole else PARTS
    jobs = [(c, p) for c in cases if asked.only in c.get("name", c["file"]) for p in parts]
    if asked.scores:
        with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
            list(pool.map(lambda job: scores(veloid, real, folder, *job), jobs))
        return
    with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        all_asked = list(pool.map(lambda job: ask(veloid, real, folder, *job), jobs))
    table(all_asked)
    figures(all_asked)


main()
