"""An identified model, to simulate and to compare with other rides."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from . import _native
from .engine import Bike, Ride, bike_text, sources
from .frames import FrameKind, table
from .frames import frame as to_frame
from .options import Reading, text
from .report import Report


class Comparison:
    """How well a model predicts a ride; `document` is what `POST /v1/validations` answers."""

    def __init__(self, document: dict[str, Any]) -> None:
        self.document = document

    @property
    def sentence(self) -> str:
        """The answer in plain words."""
        return str(self.document["sentence"])

    @property
    def fit(self) -> dict[str, float]:
        """100 (1 - |y - predicted| / |y - mean of y|) (%) by axle, as MATLAB's `compare`."""
        return {name: axle["model"]["fit_percent"] for name, axle in self.document["axles"].items() if axle}

    @property
    def differs(self) -> dict[str, bool | None]:
        """Whether any number differs by more than the intervals allow, by axle; None without intervals."""
        return {name: axle["differs"] for name, axle in self.document["axles"].items() if axle}

    def parameters(self, frame: FrameKind = "pandas") -> Any:
        """A row for each number: axle, name, unit, model, model_std_error, ride, ride_std_error, difference_in_errors, differs."""
        rows = [
            {"axle": name, **number}
            for name, axle in self.document["axles"].items()
            if axle
            for number in axle["parameters"]
        ]
        names = list(rows[0]) if rows else ["axle", "name"]
        return table(rows, names, frame)

    def __repr__(self) -> str:
        return f"<Comparison {self.sentence}>"


class Model:
    """The model of a report, or one that `veloid identify --model model.json` or a server wrote."""

    def __init__(self, source: Report | str | dict[str, Any]) -> None:
        given = source.text if isinstance(source, Report) else source if isinstance(source, str) else text(source)
        self._text = _native.model(given)
        self.document: dict[str, Any] = json.loads(self._text)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Model:
        """Reads a report or a model from its file."""
        return cls(Path(path).read_text(encoding="utf-8"))

    def to_json(self) -> str:
        """The document that `veloid validate` reads."""
        return self._text

    def compare(
        self, ride: Ride, bike: Bike | None = None, *, alpha: float = 0.01, **reading: Unpack[Reading]
    ) -> Comparison:
        """How well the model predicts `ride`, as `veloid validate`. `bike` is the bicycle as it was ridden there, by default as the
        model's ride. Numbers differ where chance would do so less often than `alpha`."""
        found = _native.compare(self._text, sources(ride), as_text(bike), text(reading), alpha)
        return Comparison(json.loads(found))

    def simulate(
        self,
        ride: Ride,
        bike: Bike | None = None,
        *,
        at_rest: bool = False,
        frame: FrameKind = "pandas",
        **reading: Unpack[Reading],
    ) -> Any:
        """The displacement (m), or the force (N) on a rig, that the model predicts along `ride`: columns `t`, `front_predicted` and
        `rear_predicted`. It starts as suits the ride's measurement best, or at rest on the road; an input without a
        measurement needs a column of zeros for `z_f` or `z_r`, and `at_rest`."""
        columns = _native.predict(self._text, sources(ride), as_text(bike), text(reading), at_rest)
        return to_frame({name: np.frombuffer(values) for name, values in columns}, frame)

    def __repr__(self) -> str:
        effects = ", ".join(f"{e['id']} ({e['axle']})" for e in self.document["effects"]) or "no effects"
        return f"<Model of {self.document['bike'] or 'a bicycle'}: {effects}>"


def as_text(bike: Bike | None) -> str | None:
    return None if bike is None else bike_text(bike)
