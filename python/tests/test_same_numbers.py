"""The command line's numbers, bit for bit."""

import json
from pathlib import Path

import numpy as np
import pandas
import polars
import pytest
import veloid
from conftest import QUICK, QUICK_ARGS, ROOT, command


def read_csv(path):
    header, *lines = path.read_text().splitlines()
    rows = [[float(cell) for cell in line.split(",")] for line in lines]
    return dict(zip(header.split(","), np.array(rows).T, strict=True))


def without_files(document):
    """A report less what it says of the bytes that the ride came in."""
    document = json.loads(json.dumps(document))
    document["ride"].pop("sha256")
    for file in document["ride"].get("files", []):
        del file["sha256"], file["format"]
    return document


def test_simulations_are_those_of_the_command_line(folder, simulated):
    columns = read_csv(folder / "ride.csv")
    assert list(simulated.ride) == list(columns)
    for name, values in columns.items():
        assert np.array_equal(simulated.ride[name], values), name
    assert simulated.truth == json.loads((folder / "truth.json").read_text())
    written = json.loads((folder / "bike.json").read_text())
    assert simulated.bike == {key: value for key, value in written.items() if key in simulated.bike}


@pytest.mark.parametrize(
    ("arguments", "same"),
    [
        (["--shaker", "100:1:20", "--only", "front"], {"shaker": (100, 1, 20), "only": "front"}),
        (["--release", "0.01", "--mass", "20:50"], {"release": 0.01, "mass": (20, 50)}),
        (["--road", "flat", "--bump", "3:0.4:0.03"], {"road": "flat", "bumps": [(3, 0.4, 0.03)]}),
        (["--cadence", "80", "--speed-change", "0.3:15"], {"cadence": 80, "speed_change": (0.3, 15)}),
        (["--accelerometers", "0.03"], {"accelerometers": 0.03}),
        (
            ["--accelerometers", "0.03", "--track-offset", "0.02", "--road-to", "30", "--effect", "coulomb_friction:rear:friction=20"],
            {
                "accelerometers": 0.03,
                "track_offset": 0.02,
                "road_to": 30,
                "effects": [("coulomb_friction", "rear", {"friction": 20})],
            },
        ),
        (
            ["--effect", "coulomb_friction:front:friction=20"],
            {"effects": [("coulomb_friction", "front", {"friction": 20})]},
        ),
    ],
)
def test_every_kind_of_simulation(tmp_path, arguments, same):
    truth = tmp_path / "truth.json"
    command("simulate", tmp_path / "ride.csv", "--truth", truth, "--duration", 5, *arguments)
    made = veloid.simulate(duration=5, **same)
    for name, values in read_csv(tmp_path / "ride.csv").items():
        assert np.array_equal(made.ride[name], values), name
    assert made.truth == json.loads(truth.read_text())


@pytest.fixture(scope="session")
def written(folder):
    """The report that the command line writes, and what it prints."""
    report = folder / "report.json"
    files = [folder / "ride.csv", "--bike", folder / "bike.json", "--json", report]
    return report, command("identify", *files, *QUICK_ARGS, "--seed", 7)


def test_a_file_gives_the_same_report_byte_for_byte(folder, written, tmp_path):
    report = veloid.identify(folder / "ride.csv", folder / "bike.json", seed=7, **QUICK)
    report.save(tmp_path / "report.json")
    assert (tmp_path / "report.json").read_bytes() == written[0].read_bytes()
    assert str(report) == written[1]


def test_arrays_and_frames_give_the_same_numbers(bike, written, simulated):
    expected = without_files(json.loads(written[0].read_text()))
    ride = simulated.ride
    millimetres = {name: values * 1e3 if name == "z_f" else values for name, values in ride.items()}
    for given in [ride, pandas.DataFrame(ride), pandas.DataFrame(ride).set_index("t"), polars.DataFrame(ride)]:
        report = veloid.identify(given, bike, seed=7, threads=1, **QUICK)
        assert without_files(report.document) == expected
    scaled = {("z_f [mm]" if name == "z_f" else name): values for name, values in millimetres.items()}
    k = [veloid.identify(r, bike, **QUICK).document["output_error"]["front"]["k_n_m"] for r in (ride, scaled)]
    assert k[1] == pytest.approx(k[0], rel=1e-9)


def test_the_diagnosis_is_the_same(folder, tmp_path):
    files = [folder / "ride.csv", "--bike", folder / "bike.json", "--json", tmp_path / "report.json"]
    command("identify", *files, *QUICK_ARGS[:-1])
    found = veloid.diagnose(folder / "ride.csv", folder / "bike.json", **(QUICK | {"diagnosis": True}))
    assert found.document == json.loads((tmp_path / "report.json").read_text())["diagnosis"]
    assert found.verdict == "nothing_missing" and found.sentence in repr(found)


def test_several_loggers_are_one_ride(tmp_path):
    made = ["--duration", 30, "--accelerometers", 0.03, "--laser", "rear:2e-4:20", "--split"]
    names = command("simulate", tmp_path / "ride.csv", "--bike", tmp_path / "bike.json", *made).split()
    command("identify", *names, "--bike", tmp_path / "bike.json", "--json", tmp_path / "report.json", *QUICK_ARGS)
    text = (tmp_path / "report.json").read_text()
    by_path = veloid.identify(names, tmp_path / "bike.json", **QUICK)
    assert by_path.text + "\n" == text
    named = veloid.identify({Path(name).name: name for name in names}, tmp_path / "bike.json", **QUICK)
    assert named.text == by_path.text
    frames = {Path(name).name: read_csv(Path(name)) for name in names}
    by_frame = veloid.identify(frames, tmp_path / "bike.json", **QUICK)
    assert without_files(by_frame.document) == without_files(json.loads(text))


def test_a_study_is_that_of_the_command_line(tmp_path):
    rides = [tmp_path / f"ride{seed}.csv" for seed in (1, 2)]
    bike = tmp_path / "bike.json"
    for seed, ride in enumerate(rides, start=1):
        command("simulate", ride, "--bike", bike, "--seed", seed, "--duration", 10, "--noise", 5e-5, "--only", "front")
    own = veloid.study(rides, bike)
    own.save(tmp_path / "own.json")
    summary = command("study", *rides, "--bike", bike, "--json", tmp_path / "theirs.json")
    assert (tmp_path / "own.json").read_bytes() == (tmp_path / "theirs.json").read_bytes()
    assert str(own) == summary and own.verdict == "nothing_missing" and own.effects == []
    assert own.axles["front"]["estimate"]["k_n_m"] > 0
    named = veloid.study(dict(zip(["out", "back"], rides, strict=True)), [bike, bike])
    assert [ride["name"] for ride in named.document["rides"]] == ["out", "back"]
    with pytest.raises(veloid.OptionError, match="3 for 2 rides"):
        veloid.study(rides, [bike] * 3)
    with pytest.raises(veloid.OptionError, match="2"):
        veloid.study(rides[:1], bike)
