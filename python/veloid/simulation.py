"""Simulated rides, as `veloid simulate` makes them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypedDict, Unpack

import numpy as np

from . import _native
from .errors import OptionError
from .frames import Doubles
from .options import text

Pair = float | tuple[float, float]
"""One number for both axles, or front and rear."""
Triple = tuple[float, float, float]
Effect = tuple[str, str, Mapping[str, float]]
"""Id, axle (front, rear or both) and parameters, by the names that the diagnosis gives them."""


class Outing(TypedDict, total=False):
    """Parameters of a simulation, with the names and defaults of `veloid simulate`."""

    duration: float
    """Length of the ride (60 s)."""
    rate: float
    """Sampling rate (100 Hz)."""
    speed: float
    """Riding speed (5 m/s)."""
    speed_change: tuple[float, float] | None
    """A speed that oscillates around its mean: relative amplitude and period (s)."""
    cadence: float | None
    """Steady cadence (revolutions per minute)."""
    road: str
    """Roughness, a class of ISO 8608 (`B`), or `flat`."""
    bumps: Sequence[Triple]
    """Rounded bumps: start, length and height of each (m; negative for a hole)."""
    shaker: Triple | None
    """A sine force on each axle (N) instead of a road, its frequency rising linearly from and to (Hz)."""
    release: float | None
    """A free decay from this displacement (m) instead of a road."""
    mass: Pair
    """Mass on the wheels (23 and 63 kg)."""
    stiffness: Pair
    """Vertical stiffness (110 000 N/m)."""
    damping: Pair
    """Vertical damping (1150 N s/m)."""
    lengths: Pair
    """From the centre of gravity to the wheels (0.808 and 0.293 m)."""
    wheel_radius: Pair | None
    """Radius of the wheels (m), for the bike."""
    effects: Sequence[Effect]
    """Up to three effects that the plain model leaves out: `("coulomb_friction", "front", {"friction": 20})`."""
    only: Literal["front", "rear"] | None
    """Record only one axle."""
    road_to: float | None
    """Highest frequency of the road (Hz; 0.45 of the rate with accelerometers, else a fifth and at most 4 cycles a metre)."""
    track_offset: float
    """By how much the rear wheel runs to the side of the front one's track (m), on an isotropic road."""
    noise: float
    """Standard deviation of the white noise on the displacement (m)."""
    road_noise: float
    """Standard deviation of the white noise on the road (m)."""
    accelerometers: float | None
    """Accelerometers on the axles with this noise (m/s^2) instead of road and displacement."""
    seed: int
    """Seed of the road and the noise (1)."""


FULL_BAND = 0.45
"""Share of the rate up to which a road can reach."""

PLAIN = Outing(
    duration=60.0,
    rate=100.0,
    speed=5.0,
    speed_change=None,
    cadence=None,
    road="B",
    bumps=(),
    shaker=None,
    release=None,
    mass=(23.0, 63.0),
    stiffness=110e3,
    damping=1150.0,
    lengths=(0.808, 0.293),
    wheel_radius=None,
    effects=(),
    only=None,
    road_to=None,
    track_offset=0.0,
    noise=0.0,
    road_noise=0.0,
    accelerometers=None,
    seed=1,
)


@dataclass(frozen=True)
class Simulated:
    """A simulated ride, its bicycle, and the true parameters."""

    ride: dict[str, Doubles]
    bike: dict[str, Any]
    truth: dict[str, Any]


def simulate(**outing: Unpack[Outing]) -> Simulated:
    """A ride as a logger would record it, with the arguments and the numbers of `veloid simulate`.

    `duration` (s), `rate` (Hz), `speed` (m/s), `speed_change`, `cadence`; `road`, `bumps`, `shaker`, `release`; `mass` (kg),
    `stiffness` (N/m), `damping` (N s/m), `lengths`, `wheel_radius` (m), each one number or (front, rear); `effects`, `only`;
    `road_to` (Hz), `track_offset` (m); `noise`, `road_noise` (m), `accelerometers` (m/s^2), `seed`. `veloid.simulation.Outing` describes each.
    """
    check(outing)
    o = PLAIN | outing
    columns, truth = _native.simulate(
        text(document(o)), text(bicycle(o)), text(o["effects"]), o["accelerometers"]
    )
    return Simulated(
        ride={name: np.frombuffer(values) for name, values in columns},
        bike=bicycle(o),
        truth={
            **json.loads(truth),
            "effects": [named(("id", "axle", "parameters"), effect) for effect in o["effects"]],
            "lasers": [],
        },
    )


def check(outing: Outing) -> None:
    """Rejects unknown and conflicting arguments."""
    for key in outing.keys() - PLAIN.keys():
        raise OptionError(f"{key}: unknown, expected one of {', '.join(PLAIN)}", key=key)
    if outing.get("only") not in (None, "front", "rear"):
        raise OptionError(f"only: {outing['only']!r}, expected 'front' or 'rear'", key="only")
    alone = {key for key in ("bumps", "shaker", "release") if outing.get(key) not in (None, ())}
    if len(alone) > 1:
        raise OptionError(f"{', '.join(sorted(alone))}: expected one of them", key=min(alone))
    if outing.get("accelerometers") is not None:
        for key in ("shaker", "release", "noise", "road_noise"):
            if outing.get(key):
                raise OptionError(f"{key}: not allowed with accelerometers", key=key)


def document(o: Outing) -> dict[str, Any]:
    """The outing in the engine's form."""
    springs = zip(pair(o["mass"]), pair(o["stiffness"]), pair(o["damping"]), strict=True)
    front, rear = [named(("mass_kg", "k_n_m", "b_n_s_m"), spring) for spring in springs]
    swing = o["speed_change"]
    return {
        "duration_s": o["duration"],
        "rate_hz": o["rate"],
        "speed_m_s": o["speed"],
        "speed_change": None if swing is None else named(("share", "period_s"), swing),
        "cadence_rpm": o["cadence"],
        "wheelbase_m": sum(pair(o["lengths"])),
        "front": None if o["only"] == "rear" else front,
        "rear": None if o["only"] == "front" else rear,
        "excitation": excitation(o),
        "road_to_hz": road_to(o),
        "track_offset_m": o["track_offset"],
        "noise_displacement_m": o["noise"],
        "noise_road_m": o["road_noise"],
        "seed": o["seed"],
    }


def road_to(o: Outing) -> float | None:
    """Accelerometers measure as far as their rate goes."""
    if o["road_to"] is None and o["accelerometers"] is not None:
        return FULL_BAND * o["rate"]
    return o["road_to"]


def excitation(o: Outing) -> dict[str, dict[str, Any]]:
    if o["shaker"] is not None:
        return {"shaker": named(("amplitude_n", "from_hz", "to_hz"), o["shaker"])}
    if o["release"] is not None:
        return {"release": {"displacement_m": o["release"]}}
    road = o["road"].lower()
    bumps = [named(("at_m", "length_m", "height_m"), bump) for bump in o["bumps"]]
    return {"road": {"roughness": None if road == "flat" else road, "bumps": bumps}}


def bicycle(o: Outing) -> dict[str, Any]:
    """The bike file's keys."""
    pairs = {"mass_{}_kg": o["mass"], "l_{}_m": o["lengths"], "wheel_radius_{}_m": o["wheel_radius"]}
    known = {
        key.format(end): value
        for key, both in pairs.items()
        if both is not None
        for end, value in zip(("front", "rear"), pair(both), strict=True)
    }
    return {"bike": "simulated", **known}


def pair(value: Pair) -> tuple[float, float]:
    return (value[0], value[1]) if isinstance(value, Sequence) else (value, value)


def named(names: Sequence[str], values: Sequence[Any]) -> dict[str, Any]:
    return dict(zip(names, values, strict=True))
