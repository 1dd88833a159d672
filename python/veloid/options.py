"""Options of an identification: the keys of the API's `options`, with the engine's defaults."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, Literal, TypedDict

import numpy as np


class FileOptions(TypedDict, total=False):
    """How one of several files is read; absent options are those of the ride."""

    map: Mapping[str, str]
    rate_hz: float
    rows: tuple[int, int]
    offset_s: float


class Reading(TypedDict, total=False):
    """How a ride is read: `docs/ride-format.md`."""

    map: Mapping[str, str]
    """Channel name to column: a header text or a number counted from 1."""
    rate_hz: float
    """Sampling rate of a file without a time column (Hz)."""
    rows: tuple[int, int]
    """Data rows to use, counted from 0, the second exclusive."""
    deflection_sign: float
    """+1: d is the deflection u - z; -1: d is a sensor's distance to the road."""
    band_hz: tuple[float, float]
    """Band (Hz) to which z and u are filtered where z is computed from acceleration."""
    missing: list[str]
    """Words for a missing value, in addition to a blank cell."""
    files: Mapping[str, FileOptions]
    """Options for single files of several, by file name."""


class Settings(TypedDict, total=False):
    """How a ride is identified."""

    seed: int
    """Seed of the first swarm trial (1)."""
    trials: int
    """Swarm trials (10)."""
    particles: int
    """Particles of a swarm (30)."""
    iterations: int
    """Iterations of a swarm (20)."""
    objective: Literal["consistent", "paper", "gradient"]
    cognitive: float
    social: float
    inertia_min: float
    inertia_max: float
    ratio_min: float
    ratio_max: float
    weights: tuple[float, float, float]
    search_factor: float
    jerk_bound_m_s3: float | None
    diagnosis: bool
    """Whether to search for missing physics (True)."""
    alpha: float
    """Family-wise false-alarm rate of the diagnosis (0.01)."""
    held_out: float
    """Share of the ride, at its end, on which nothing is fitted (0.4)."""
    materiality: float
    search_budget: float
    law: str | None
    """A custom law (TOML): `docs/own-law.md`."""


class Options(Reading, Settings, total=False):
    """Both together."""


def text(document: object) -> str:
    """JSON of a document, including NumPy numbers."""
    return json.dumps(document, default=plain)


def plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


def split(options: Options) -> tuple[str, str]:
    """Documents of reading and of settings; unknown keys go to the settings, which reject them."""
    reading = {key: value for key, value in options.items() if key in Reading.__annotations__}
    settings = {key: value for key, value in options.items() if key not in Reading.__annotations__}
    return text(reading), text(settings)
