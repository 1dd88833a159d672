"""What the tests share: the program `veloid` that was built beside the package, and quick rides."""

import json
import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BINARY = Path(os.environ.get("VELOID", ROOT / "target/debug/veloid"))
QUICK = {"trials": 2, "particles": 8, "iterations": 5, "diagnosis": False}
QUICK_ARGS = ["--trials", "2", "--particles", "8", "--iterations", "5", "--no-diagnosis"]


def command(*args):
    """Runs the program; what it says on stdout."""
    run = subprocess.run([BINARY, *map(str, args)], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    return run.stdout


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """A ride of 15 s, its bike and its truth, as the command line simulates them."""
    path = tmp_path_factory.mktemp("ride")
    made = ["--bike", path / "bike.json", "--truth", path / "truth.json"]
    command("simulate", path / "ride.csv", *made, "--duration", 15, "--noise", 5e-5, "--seed", 3)
    return path


@pytest.fixture(scope="session")
def bike(folder):
    return json.loads((folder / "bike.json").read_text())


@pytest.fixture(scope="session")
def simulated():
    import veloid

    return veloid.simulate(duration=15, noise=5e-5, seed=3)


@pytest.fixture(scope="session")
def url(tmp_path_factory):
    """A server of its own."""
    data = tmp_path_factory.mktemp("data")
    args = [BINARY, "serve", "--listen", "127.0.0.1:0", "--data", data, "--workers", "1"]
    with (data / "log").open("w") as log:
        server = subprocess.Popen(args, stdout=subprocess.PIPE, stderr=log, text=True)
    for line in server.stdout:
        if line.startswith("veloid listens on "):
            break
    yield line.split()[-1]
    server.terminate()
    server.wait(timeout=60)
