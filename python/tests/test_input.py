"""What is taken, and what is refused with its place."""

import numpy as np
import pandas
import polars
import pytest
import veloid
from conftest import QUICK


@pytest.fixture
def ride(simulated):
    return {name: values.copy() for name, values in simulated.ride.items()}


def refused(kind, ride, bike, **options):
    with pytest.raises(kind) as caught:
        veloid.identify(ride, bike, **(QUICK | options))
    assert isinstance(caught.value, veloid.VeloidError) and isinstance(caught.value, ValueError)
    return caught.value


def test_a_wrong_value_is_told_by_column_and_row(ride, bike):
    ride["z_f"][7] = np.inf
    fault = refused(veloid.RideError, ride, bike)
    assert str(fault) == "arrays, sample 8, column 3 (z_f): 'inf' is not finite, expected a number or a blank cell"
    assert (fault.row, fault.column, fault.column_number, fault.line, fault.kind) == (7, "z_f", 3, None, "not-finite")
    fault = refused(veloid.RideError, ride | {"z_f": ride["z_f"][:-1]}, bike)
    assert fault.column == "z_f" and fault.kind == "ragged-row"
    fault = refused(veloid.RideError, {"u_f": ride["u_f"]}, bike)
    assert fault.kind == "time-missing" and fault.file == "arrays"
    fault = refused(veloid.RideError, ride | {"z_f": np.zeros((2, 3))}, bike)
    assert "dimensions" in str(fault) and fault.column == "z_f"
    texts = [*map(str, ride["z_f"][:-1]), "x"]
    fault = refused(veloid.RideError, ride | {"z_f": texts}, bike)
    assert (fault.row, fault.kind) == (1500, "not-a-number")


def test_a_wrong_file_is_told_by_line(tmp_path, bike):
    path = tmp_path / "ride.csv"
    path.write_text("t,z_f,u_f\n0,0,0\n0.01,x,0\n0.02,0,0\n")
    fault = refused(veloid.RideError, path, bike)
    assert (fault.line, fault.column, fault.row, fault.file) == (3, "z_f", None, str(path))
    with pytest.raises(FileNotFoundError):
        veloid.identify(tmp_path / "none.csv", bike)


def test_a_wrong_bike_and_a_wrong_option_are_told_by_key(ride, bike):
    for wrong, key in [
        ({"mass_front_kg": 1e9}, "mass_front_kg"),
        ({"mass_front_kg": "23"}, "mass_front_kg"),
        ({"mass_frnt_kg": 23}, "mass_frnt_kg"),
        ({"mass_rear_kg": None}, "mass_rear_kg"),
        ({"roll": {"front_part_mass_kg": "x"}}, "roll.front_part_mass_kg"),
    ]:
        assert refused(veloid.BikeError, ride, bike | wrong).key == key
    for wrong, key in [
        ({"trials": 0}, "trials"),
        ({"trials": "x"}, "trials"),
        ({"sead": 1}, "sead"),
        ({"rate_hz": -1.0}, "rate_hz"),
        ({"rows": (5, 5)}, "rows"),
    ]:
        assert refused(veloid.OptionError, ride, bike, **wrong).key == key
    for wrong, key in [
        ({"accelerometers": 0.1, "noise": 1e-5}, "noise"),
        ({"shaker": (1, 1, 2), "release": 0.1}, "release"),
        ({"only": "both"}, "only"),
        ({"rate": 1e9}, "rate"),
        ({"sped": 4}, "sped"),
        ({"road": "Z"}, "excitation.road.roughness"),
    ]:
        with pytest.raises(veloid.OptionError) as caught:
            veloid.simulate(**wrong)
        assert caught.value.key == key, caught.value


def test_what_holds_too_little_is_no_fault_of_the_input(ride, bike):
    with pytest.raises(veloid.IdentificationError, match="does not determine") as caught:
        veloid.identify(ride | {"z_f": ride["u_f"]}, bike, **QUICK)
    assert caught.value.axle == "front" and not isinstance(caught.value, ValueError)


def test_missing_values_are_bridged_alike(ride, bike):
    ride["z_f"][[300, 301, 900]] = np.nan
    objects = [None if np.isnan(z) else z for z in ride["z_f"]]
    arrays, pandas_frame, polars_frame = (
        veloid.identify(given, bike, **QUICK)
        for given in (ride, pandas.DataFrame(ride | {"z_f": objects}), polars.DataFrame(ride | {"z_f": objects}))
    )
    assert any("3 sample(s) missing" in warning for warning in arrays.warnings), arrays.warnings
    assert arrays.text == pandas_frame.text == polars_frame.text


def test_times_may_be_dates_or_durations(ride, bike):
    plain = veloid.identify(ride, bike, **QUICK)
    ticks = np.round(ride["t"] * 1e9).astype("timedelta64[ns]")
    frame = pandas.DataFrame(ride).drop(columns="t")
    for t in (ticks, np.datetime64("2026-05-01T10:00:00") + ticks):
        found = veloid.identify(frame.set_index(pandas.Index(t, name="t")), bike, **QUICK)
        assert found.document["output_error"] == plain.document["output_error"]
    epoch = np.datetime64("2026-05-01T10:00:00")
    halves = {
        "one": {"t": epoch + ticks, "u_f": ride["u_f"], "z_f": ride["z_f"]},
        "two": {"t": epoch + np.timedelta64(2, "s") + ticks, "z_r": ride["z_r"], "u_r": ride["u_r"]},
    }
    files = veloid.identify(halves, bike, **QUICK).document["ride"]["files"]
    assert [file["dated"] for file in files] == [True, True]
    assert files[1]["from_s"] - files[0]["from_s"] == pytest.approx(2.0, abs=1e-9)


def test_columns_by_any_name_and_of_any_type(ride, bike):
    renamed = {"clock": ride["t"], "V1": ride["u_f"], "V2": ride["z_f"].astype(np.float32), "note": ["x"] * 1501}
    report = veloid.identify(renamed, bike, map={"t": "clock", "u_f": "V1", "z_f": "V2"}, rows=(0, 1000), **QUICK)
    assert report.document["ride"]["rows"] == 1000
    assert report.document["ride"]["ignored"] == ["note"]
    half = report.document["output_error"]["front"]["k_n_m"]
    assert half == pytest.approx(110e3, rel=0.1)
    rate = {name: ride[name][::1] for name in ("u_f", "z_f")}
    assert veloid.identify(rate, bike, rate_hz=100, **QUICK).document["ride"]["rate_hz"] == pytest.approx(100)
