"""Client of a veloid server's API."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any, Unpack

import httpx
import numpy as np

from .engine import Bike, Ride, bike_text, is_path, named
from .errors import JobError, ServerError, VeloidError
from .frames import FrameKind, csv, table
from .frames import frame as as_frame
from .options import Options, split
from .report import PARAMETERS, Report, Study

WAIT_S = 30
"""Longest time that the server waits for a job to change before it answers."""


class Client:
    """A client of the server at `server`, with `key` if it requires one. Closes its connections at the end of a `with`."""

    def __init__(self, server: str = "http://127.0.0.1:8080", key: str | None = None, timeout: float = 60.0) -> None:
        headers = {} if key is None else {"Authorization": f"Bearer {key}"}
        self._http = httpx.Client(base_url=server, headers=headers, timeout=timeout)

    def upload(
        self,
        ride: Ride,
        bike: Bike,
        *,
        name: str = "ride",
        facts: Mapping[str, Any] | None = None,
        again: bool = False,
        **options: Unpack[Options],
    ) -> Job:
        """Sends a ride, in any of the forms that `veloid.identify` accepts, and queues its identification.

        If the same was sent before, returns the existing job, unless `again`. Frames are sent as CSV with all digits, under
        the name `name`. `facts` describe the ride: `{"ridden_at": "2026-05-01"}`.
        """
        reading, settings = split(options)
        fields = {"bike": bike_text(bike), "options": json.dumps(json.loads(reading) | json.loads(settings))}
        if facts is not None:
            fields["facts"] = json.dumps(dict(facts))
        if again:
            fields["again"] = "true"
        parts = named(ride)
        alone = name + ".csv"
        files = [
            ("file", (Path(part).name, Path(part).open("rb")))
            if is_path(part)
            else ("file", (alone if len(parts) == 1 else called, BytesIO(csv(part))))
            for called, part in parts
        ]
        try:
            return Job(self, self._json("POST", "/v1/rides", files=files, data=fields))
        finally:
            for _, (_, file) in files:
                file.close()

    def study(self, rides: Sequence[Job | str] | None = None, *, bike: str | None = None, last: int | None = None) -> Job:
        """Queues the study of several rides of one bicycle: of these jobs' rides (or ids of rides), or of the `last` rides of `bike`
        (12). The same rides return the existing job; its report is that of `Job.study`."""
        ids = None if rides is None else [ride.document["ride"]["id"] if isinstance(ride, Job) else ride for ride in rides]
        asked = {"rides": ids, "bike": bike, "last": last}
        return Job(self, self._json("POST", "/v1/studies", json={key: of for key, of in asked.items() if of is not None}))

    def job(self, id: str) -> Job:
        return Job(self, self._json("GET", f"/v1/jobs/{id}"))

    def jobs(self, **filters: Any) -> Iterator[Job]:
        """Jobs, newest first; filters are those of `/v1/jobs`: `bike`, `verdict`, `state`, `tag` and others."""
        return (Job(self, item) for item in self._items("/v1/jobs", filters))

    def parameters(self, frame: FrameKind = "pandas", **filters: Any) -> Any:
        """Every identified parameter of every ride, newest first, with the ride's facts; filters are those of `/v1/parameters`:
        `bike`, `method`, `axle`, `name`, `verdict` and others."""
        rows = []
        for item in self._items("/v1/parameters", {"limit": 10_000, **filters}):
            rows.append(item | item.pop("facts"))
        names = list(dict.fromkeys(["job", "bike", "identified_at", *PARAMETERS, *(key for row in rows for key in row)]))
        return table(rows, names, frame)

    def close(self) -> None:
        self._http.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _items(self, path: str, filters: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
        cursor: dict[str, str] = {}
        while True:
            page = self._json("GET", path, params={**filters, **cursor})
            yield from page["items"]
            if page["next"] is None:
                return
            cursor = {"cursor": page["next"]}

    def _json(self, method: str, path: str, **request: Any) -> dict[str, Any]:
        answer = self._send(method, path, **request).json()
        assert isinstance(answer, dict)
        return answer

    def _send(self, method: str, path: str, **request: Any) -> httpx.Response:
        try:
            response = self._http.request(method, path, **request)
        except httpx.HTTPError as error:
            raise VeloidError(f"{self._http.base_url}: {error}") from error
        if response.is_error:
            raise refused(response)
        return response


def refused(response: httpx.Response) -> ServerError:
    try:
        problem = response.json()
    except ValueError:
        problem = {}
    title, detail = problem.get("title", response.reason_phrase), problem.get("detail", "")
    return ServerError(
        f"{title}: {detail}" if detail else title,
        status=response.status_code,
        kind=problem.get("type", ""),
        detail=detail,
        place=problem.get("place"),
    )


class Job:
    """An identification on a server; `document` is the response of `/v1/jobs/{id}`."""

    def __init__(self, client: Client, document: dict[str, Any]) -> None:
        self._client = client
        self.document = document

    @property
    def id(self) -> str:
        return str(self.document["id"])

    @property
    def state(self) -> str:
        return str(self.document["state"])

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        return float(self.document["progress"])

    @property
    def page(self) -> str:
        """Address of the result page."""
        return str(self._client._http.base_url.join(self.document["links"]["page"]))

    def wait(self, timeout: float | None = None, progress: Callable[[Job], object] | None = None) -> Job:
        """Waits for the end, at most `timeout` seconds (TimeoutError). `progress` is called with the job whenever it
        changes. Raises JobError if it ends without a report."""
        ends = None if timeout is None else time.monotonic() + timeout
        while self.document["finished_at"] is None:
            left = WAIT_S if ends is None else ends - time.monotonic()
            if left <= 0:
                raise TimeoutError(f"job {self.id} is {self.state} after {timeout} s")
            step = 1.0 if progress is not None else WAIT_S
            self.refresh(wait=max(1, round(min(left, step))))
            if progress is not None:
                progress(self)
        failure = self.document["failure"]
        if failure is not None or self.state != "succeeded":
            detail = failure["detail"] if failure and "detail" in failure else json.dumps(failure)
            raise JobError(f"job {self.id} {self.state}: {detail}", state=self.state)
        return self

    def refresh(self, wait: int = 0) -> Job:
        """Updates the job's state; with `wait`, once it has ended or after this many seconds."""
        self.document = self._client._json("GET", self.document["links"]["job"], params={"wait": wait} if wait else {})
        return self

    def report(self) -> Report:
        """The report, with the same numbers as that of `veloid.identify`."""
        return Report(self._client._send("GET", self.document["links"]["report"]).text)

    def study(self) -> Study:
        """The report of a study."""
        return Study(self._client._send("GET", self.document["links"]["report"]).text)

    def series(
        self,
        quantity: str = "displacement",
        *,
        t0: float | None = None,
        t1: float | None = None,
        points: int = 2000,
        frame: FrameKind = "pandas",
    ) -> Any:
        """Measured and simulated motion from `t0` to `t1` (s), thinned to about `points` values; columns as in `Report.series`."""
        asked = {"quantity": quantity, "points": points, "t0": t0, "t1": t1}
        params = {key: value for key, value in asked.items() if value is not None}
        window = self._client._json("GET", self.document["links"]["series"], params=params)
        columns = {"t": window["t_s"]}
        for axle, curves in window["axles"].items():
            columns |= {f"{axle}_{name}": values for name, values in (curves or {}).items()}
        return as_frame({name: np.array(values, dtype=np.float64) for name, values in columns.items()}, frame)

    def cancel(self) -> Job:
        self.document = self._client._json("DELETE", self.document["links"]["job"])
        return self

    def __repr__(self) -> str:
        return f"<Job {self.id}: {self.state}, {100 * self.progress:.0f} %>"
