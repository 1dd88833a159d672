"""Results of an identification."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native, drawing
from .errors import VeloidError
from .frames import FrameKind, table
from .frames import frame as to_frame

if TYPE_CHECKING:
    from .model import Model

PARAMETERS = ["method", "axle", "name", "value", "std_error", "unit"]
NAMES = {"k": "k_n_m", "B": "b_n_s_m", "mass": "mass_kg"}
"""Names in `/v1/parameters` of the quantities of `result`."""
METHODS = ["least_squares", "instrumental", "swarm", "output_error", "latent_road"]


class Diagnosis:
    """The physics that the model leaves out: the report's section `diagnosis`, which is `document`."""

    def __init__(self, document: dict[str, Any]) -> None:
        self.document = document

    @property
    def verdict(self) -> str:
        """`nothing_missing`, `named`, `named_in_part`, `ambiguous`, `unnamed` or `cannot_tell`."""
        return str(self.document["verdict"])

    @property
    def sentence(self) -> str:
        """The verdict in plain words."""
        return str(self.document["sentence"])

    @property
    def effects(self) -> list[dict[str, Any]]:
        """The effects that were found, those that the verdict affirms first."""
        return list(self.document["effects"])

    def __repr__(self) -> str:
        return f"<Diagnosis {self.verdict}: {self.sentence}>"

    def _repr_html_(self) -> str:
        return drawing.page(drawing.diagnosis(self.document))


class Stored:
    """A document and its text, as `--json` writes it or a server returns it."""

    def __init__(self, text: str) -> None:
        self.text = text

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the file; what was identified here, byte for byte that of `--json`."""
        Path(path).write_text(self.text + "\n", encoding="utf-8")

    @cached_property
    def document(self) -> dict[str, Any]:
        read = json.loads(self.text)
        assert isinstance(read, dict)
        return read


class Report(Stored):
    """The complete result of one identification.

    `text` is the JSON that `veloid identify --json` writes or a server returns; `document` is the same as
    dictionaries. `str()` is the command line's summary.
    """

    def __init__(self, text: str, record: _native.Record | None = None) -> None:
        super().__init__(text)
        self._record = record

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Report:
        """Reads a report from its file."""
        return cls(Path(path).read_text(encoding="utf-8"))

    @property
    def diagnosis(self) -> Diagnosis | None:
        """None if it was not requested."""
        found = self.document["diagnosis"]
        return None if found is None else Diagnosis(found)

    @property
    def verdict(self) -> str | None:
        return None if self.diagnosis is None else self.diagnosis.verdict

    @property
    def sentence(self) -> str | None:
        return None if self.diagnosis is None else self.diagnosis.sentence

    @property
    def result(self) -> dict[str, Any]:
        """The answer by axle and quantity (`k`, `B`, `mass`, `natural_frequency`, `damping_ratio`): `value`, `std_error`,
        `interval` (95 %), `unit`, `method`; `value` is None where it is withheld, with the reason in `why`."""
        return dict(self.document.get("result", {}))

    @property
    def warnings(self) -> list[str]:
        """Warnings of the reader, apparent mistakes, and warnings of the diagnosis."""
        found = [*self.document["ride"]["warnings"], *(m["sentence"] for m in self.document["mistakes"])]
        found += self.document["diagnosis"]["warnings"] if self.diagnosis else []
        return list(dict.fromkeys(found))

    def parameters(self, frame: FrameKind = "pandas") -> Any:
        """A row for each identified parameter: method, axle, name, value, std_error, unit, as in `/v1/parameters`."""
        return table(list(self._parameters()), PARAMETERS, frame)

    def series(self, quantity: str = "displacement", frame: FrameKind = "pandas") -> Any:
        """Measured and simulated motion at every sample: `displacement`, `velocity`, `acceleration` or `force`. Columns are
        `t` and, of each axle, `front_measured`, `front_least_squares`, `front_swarm`, `front_plain` (output error),
        `front_residual` (measured - plain) and `front_observer`; NaN where there is no value."""
        if self._record is None:
            raise VeloidError("this report has no ride: identify the ride, or use the series of a server's job")
        columns = _native.series(self._record, self.text, quantity)
        return to_frame({name: np.frombuffer(values) for name, values in columns}, frame)

    def model(self) -> Model:
        """The identified model, to simulate and to compare with other rides."""
        from .model import Model

        return Model(self)

    def _parameters(self) -> Iterator[dict[str, Any]]:
        diagnosis = self.document["diagnosis"]
        yield from of_result(self.document.get("result", {}))
        for method in METHODS:
            yield from of_estimates(method, self.document[method] or {})
        if diagnosis is None:
            return
        yield from of_estimates("extended", diagnosis["extended"])
        in_part = diagnosis["verdict"] == "named_in_part"
        for effect in diagnosis["effects"]:
            if in_part and not effect["affirmed"]:
                continue
            for name, parameter in effect["parameters"].items():
                told = {key: parameter[key] for key in ("value", "std_error", "unit")}
                yield {"method": "extended", "axle": effect["axle"], "name": f"{effect['id']}.{name}", **told}

    def __str__(self) -> str:
        return _native.summary(self.text)

    def __repr__(self) -> str:
        ride, bike = self.document["ride"], self.document["bike"]["bike"]
        of = f" of {bike}" if bike else ""
        return f"<Report{of}: {ride['duration_s']:.4g} s at {ride['rate_hz']:.5g} Hz, {self.verdict or 'not diagnosed'}>"

    def _repr_html_(self) -> str:
        return drawing.page(drawing.report(self.document))


class Study(Stored):
    """Several rides as one; `text` and `document` are what `veloid study --json` writes or a server returns (docs/studies.md)."""

    @property
    def verdict(self) -> str:
        """`nothing_missing`, `named`, `named_in_part`, `ambiguous` or `unnamed`."""
        return str(self.document["verdict"])

    @property
    def sentence(self) -> str:
        """The verdict in plain words."""
        return str(self.document["sentence"])

    @property
    def effects(self) -> list[dict[str, Any]]:
        """Effects that the rides have in common: `effect`, `by_ride`, `differs_p_value`, `acts_in`."""
        return list(self.document["effects"])

    @property
    def axles(self) -> dict[str, Any]:
        """k and B over all rides by axle (`estimate`), None where the rides differ."""
        return dict(self.document["axles"])

    def __str__(self) -> str:
        return _native.study_summary(self.text)

    def __repr__(self) -> str:
        return f"<Study of {len(self.document['rides'])} rides, {self.verdict}>"


def of_result(result: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for axle, quantities in result.items():
        for name, found in (quantities or {}).items():
            given = name == "mass" and found["std_error"] is None
            if found["value"] is not None and not given:
                value = {key: found[key] for key in ("value", "std_error", "unit")}
                yield {"method": "result", "axle": axle, "name": NAMES.get(name, name), **value}


def of_estimates(method: str, estimates: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for axle in ("front", "rear"):
        found = estimates.get(axle)
        if found is None:
            continue
        kinds = [("k_n_m", "k_std_n_m", "N/m"), ("b_n_s_m", "b_std_n_s_m", "N s/m")]
        if found.get("mass_std_kg") is not None:
            kinds.append(("mass_kg", "mass_std_kg", "kg"))
        for name, error, unit in kinds:
            value = {"value": found[name], "std_error": found[error], "unit": unit}
            yield {"method": method, "axle": axle, "name": name, **value}
