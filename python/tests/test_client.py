"""A server, by its API: the same numbers as in this process."""

import pandas
import pytest
import veloid
from conftest import QUICK


@pytest.fixture(scope="module")
def client(url):
    with veloid.Client(url) as client:
        yield client


@pytest.fixture(scope="module")
def job(client, simulated):
    facts = {"ridden_at": "2026-05-01", "pressure_front_bar": 2.2}
    return client.upload(pandas.DataFrame(simulated.ride), simulated.bike, facts=facts, seed=7, **QUICK).wait(300)


def test_a_report_of_a_server_has_the_same_numbers(client, job, simulated):
    own = veloid.identify(simulated.ride, simulated.bike, seed=7, **QUICK)
    served = job.report()
    there, here = served.document, own.document
    assert there["ride"].pop("sha256") != here["ride"].pop("sha256")
    assert there == here
    assert served.parameters(frame="arrays").keys() == own.parameters(frame="arrays").keys()
    assert job.state == "succeeded" and job.progress == 1.0 and job.page.endswith(job.id)


def test_a_file_is_the_same_upload_as_by_curl(client, folder):
    sent = [client.upload(folder / "ride.csv", folder / "bike.json", **QUICK) for _ in range(2)]
    assert sent[0].id == sent[1].id
    seen = []
    job = client.job(sent[0].id).wait(300, progress=seen.append)
    assert job.report().document == veloid.identify(folder / "ride.csv", folder / "bike.json", **QUICK).document
    assert all(isinstance(one, veloid.Job) for one in seen)
    assert client.upload(folder / "ride.csv", folder / "bike.json", again=True, **QUICK).id != job.id


def test_parameters_are_those_of_the_report(client, job):
    listed = client.parameters(job=job.id)
    assert set(listed["pressure_front_bar"]) == {2.2}
    keys = ["method", "axle", "name", "value", "std_error", "unit"]
    listed_rows, own_rows = (
        {tuple(row) for row in frame[keys].astype(object).where(frame[keys].notna(), None).to_numpy()}
        for frame in (listed, job.report().parameters())
    )
    assert listed_rows == own_rows
    assert len(client.parameters(job=job.id, limit=3, frame="arrays")["value"]) == len(listed)
    assert client.parameters(bike="no such bike").empty


def test_series_are_those_of_the_ride(job, simulated):
    part = job.series("velocity", t0=5.0, t1=6.0)
    own = veloid.identify(simulated.ride, simulated.bike, seed=7, **QUICK).series("velocity")
    own = own[(own["t"] >= 5.0 - 1e-6) & (own["t"] <= 6.0 + 1e-6)]
    for name in part.columns:
        assert list(part[name]) == list(own[name]), name
    assert len(job.series(points=100)) < 300


def test_jobs_are_listed(client, job):
    assert job.id in {one.id for one in client.jobs(limit=1)}
    assert next(client.jobs(bike="simulated")).document["bike"] == "simulated"


def test_refusals_have_their_place(client, simulated):
    wrong = dict(simulated.ride, **{"z_f [furlong]": simulated.ride["z_f"]})
    with pytest.raises(veloid.ServerError) as caught:
        client.upload(wrong, simulated.bike, **QUICK)
    fault = caught.value
    assert fault.status == 422 and fault.kind.endswith("unreadable-ride") and fault.place["column"] == 7
    with pytest.raises(veloid.ServerError, match="sead"):
        client.upload(simulated.ride, simulated.bike, sead=1)
    with pytest.raises(veloid.ServerError) as caught:
        client.job("no-such-job")
    assert caught.value.status in (400, 404)


def test_a_cancelled_job_has_no_report(client, simulated):
    job = client.upload(simulated.ride, simulated.bike, trials=100, particles=1000, iterations=20)
    job.cancel()
    with pytest.raises(veloid.JobError) as caught:
        job.wait(300)
    assert caught.value.state == "cancelled"
    with pytest.raises(TimeoutError):
        client.upload(simulated.ride, simulated.bike, trials=100, particles=999, iterations=20).wait(0.0)


def test_a_server_that_is_not_there():
    with veloid.Client("http://127.0.0.1:9", timeout=5) as client, pytest.raises(veloid.VeloidError, match="127.0.0.1:9"):
        client.job("x")


def test_a_study_is_a_job_of_its_rides(client):
    rides = [veloid.simulate(duration=10, noise=5e-5, seed=seed, only="front") for seed in (1, 2)]
    options = {"trials": 1, "iterations": 5}
    jobs = [client.upload(ride.ride, {**ride.bike, "bike": "studied"}, name=f"ride{i}", **options) for i, ride in enumerate(rides)]
    jobs = [job.wait(300) for job in jobs]
    study = client.study(jobs).wait(300).study()
    assert study.verdict == "nothing_missing" and len(study.document["rides"]) == 2
    assert client.study(bike="studied", last=2).wait(300).study().verdict == study.verdict
    assert repr(study) == "<Study of 2 rides, nothing_missing>"
