"""Reports: tables, series, files, and how notebooks show them."""

import json
import xml.etree.ElementTree as xml

import numpy as np
import pandas
import polars
import pytest
import veloid
from conftest import QUICK


@pytest.fixture(scope="module")
def report(simulated):
    return veloid.identify(simulated.ride, simulated.bike, **QUICK)


@pytest.fixture(scope="module")
def diagnosed():
    """A front wheel with friction, which the diagnosis names."""
    effects = [("coulomb_friction", "front", {"friction": 40.0})]
    made = veloid.simulate(duration=30, road="C", noise=2e-5, effects=effects, only="front")
    return veloid.identify(made.ride, made.bike, **(QUICK | {"diagnosis": True}))


def test_parameters_come_as_the_frame_that_is_asked_for(report):
    frame = report.parameters()
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame.columns) == ["method", "axle", "name", "value", "std_error", "unit"]
    k = frame.query("method == 'result' and axle == 'front' and name == 'k_n_m'")
    assert k["value"].item() == report.result["front"]["k"]["value"]
    assert isinstance(report.parameters(frame="polars"), polars.DataFrame)
    assert set(report.parameters(frame="arrays")["method"]) == {
        "result", "least_squares", "instrumental", "swarm", "output_error",
    }  # fmt: skip


def test_series_hold_the_ride_and_what_the_models_make_of_it(report, simulated):
    series = report.series()
    assert np.array_equal(series["t"], simulated.ride["t"])
    assert np.array_equal(series["front_measured"], simulated.ride["z_f"])
    residual = (series["front_measured"] - series["front_plain"] - series["front_residual"]).abs()
    assert residual.max() < 1e-12 and series["front_residual"].std() < 1e-4
    assert np.isnan(report.series("velocity", frame="polars")["rear_measured"][0])
    with pytest.raises(veloid.OptionError):
        report.series("jerk")


def test_a_report_is_saved_and_loaded(report, tmp_path):
    report.save(tmp_path / "report.json")
    again = veloid.Report.load(tmp_path / "report.json")
    assert again.text.strip() == report.text and str(again) == str(report)
    with pytest.raises(veloid.VeloidError, match="has no ride"):
        again.series()


def test_named_physics_are_told(diagnosed):
    assert diagnosed.verdict == "named", diagnosed
    assert diagnosed.diagnosis.effects[0]["id"] == "coulomb_friction"
    names = set(diagnosed.parameters(frame="arrays")["name"])
    assert "coulomb_friction.friction" in names
    assert "coulomb_friction" in diagnosed._repr_html_() and "friction" in diagnosed.diagnosis._repr_html_()


def test_a_notebook_shows_well_formed_and_escaped_html(report, diagnosed):
    for shown in (report, diagnosed, diagnosed.diagnosis):
        tree = xml.fromstring(shown._repr_html_())
        assert tree.findall(".//table"), shown
    assert len(xml.fromstring(report._repr_html_()).findall(".//svg")) == 4
    assert len(xml.fromstring(diagnosed._repr_html_()).findall(".//svg")) == 2
    odd = dict(diagnosed.document, ride=diagnosed.document["ride"] | {"warnings": ["<script>a & b</script>"]})
    shown = veloid.Report(json.dumps(odd))._repr_html_()
    assert "<script>" not in shown and xml.fromstring(shown) is not None
    assert "not diagnosed" in repr(report) and "named" in repr(diagnosed)
