"""The engine, without a server."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Unpack

from . import _native
from .errors import OptionError
from .frames import Doubles, columns, is_record
from .options import Options, split, text
from .report import Diagnosis, Report, Study

Bike = Mapping[str, Any] | str | os.PathLike[str]
"""A mapping with the keys of the bike file, or its path."""
Ride = Any
"""A file's path, a frame, a mapping of names to arrays; several loggers as a list of these, or as a mapping of names to frames or paths."""


class Progress(NamedTuple):
    """Progress of an identification."""

    stage: str
    """`observe`, `trials`, `conclude` or `diagnose`."""
    done: int
    """Swarm iterations of all trials, or steps of the search for missing physics."""
    total: int
    """Their total, or the most that it may take; 0 if unknown."""


def identify(
    ride: Ride,
    bike: Bike,
    *,
    progress: Callable[[Progress], object] | None = None,
    threads: int | None = None,
    **options: Unpack[Options],
) -> Report:
    """Stiffness and damping of `bike`, and the physics that the model leaves out, bit for bit as `veloid identify` reports them.

    `ride` is the path of a file, or its columns: a pandas or polars frame, or a mapping of names to arrays; names and units are
    those of files (`t`, `u_f`, `z_f [mm]`), NaN is a missing value. Several loggers are a list of these, or a mapping
    of names to frames. `bike` is a mapping with the keys of the bike file, or the path of one.

    `progress` is called on this thread; an exception that it raises ends the work, as Ctrl-C does. `threads` is the number of cores
    by default. Other Python threads continue to run.

    Raises RideError, BikeError, OptionError or IdentificationError, each with the place of the fault.
    """
    reading, settings = split(options)
    told = None if progress is None else lambda *step: progress(Progress(*step))
    report, record = _native.identify(sources(ride), bike_text(bike), reading, settings, told, threads)
    return Report(report, record)


def diagnose(
    ride: Ride,
    bike: Bike,
    *,
    progress: Callable[[Progress], object] | None = None,
    threads: int | None = None,
    **options: Unpack[Options],
) -> Diagnosis:
    """The physics that the plain model leaves out: the diagnosis of `identify`, with the same arguments."""
    if not options.setdefault("diagnosis", True):
        raise OptionError("diagnosis: False, expected True or nothing", key="diagnosis")
    found = identify(ride, bike, progress=progress, threads=threads, **options).diagnosis
    assert found is not None
    return found


def study(
    rides: Mapping[str, Ride] | Sequence[Ride],
    bike: Bike | Sequence[Bike],
    *,
    progress: Callable[[Progress], object] | None = None,
    threads: int | None = None,
    **options: Unpack[Options],
) -> Study:
    """Identifies 2 to 64 rides of one bicycle as one, bit for bit as `veloid study` does: effects too weak for one ride are found in several.

    `rides` are those of `identify`, in a sequence or by name; one `bike` serves all rides, or each has its own, in their order.
    The other arguments and the exceptions are those of `identify`.
    """
    named_rides = named(rides)
    bikes = [bike] if isinstance(bike, Mapping | str | os.PathLike) else list(bike)
    if len(bikes) not in (1, len(named_rides)):
        raise OptionError(f"bike: {len(bikes)} for {len(named_rides)} rides, expected one for all or one for each", key="bike")
    reading, settings = split(options)
    heard = None if progress is None else lambda *step: progress(Progress(*step))
    given = [
        (name, [(name, contents(ride))] if is_path(ride) else sources(ride), bike_text(bikes[i % len(bikes)]))
        for i, (name, ride) in enumerate(named_rides)
    ]
    return Study(_native.study(given, reading, settings, heard, threads))


def bike_text(bike: Bike) -> str:
    return text(bike) if isinstance(bike, Mapping) else Path(bike).read_text(encoding="utf-8")


def is_path(ride: Ride) -> bool:
    return isinstance(ride, str | os.PathLike)


def sources(ride: Ride) -> list[_native.Source]:
    """The engine's input: a name, and bytes or columns."""
    return [(name, contents(part)) for name, part in named(ride)]


def named(ride: Ride) -> list[tuple[str, Any]]:
    """Each logger's part with a name: files are named as on the command line."""
    if is_path(ride):
        return [(os.fspath(ride), ride)]
    if is_record(ride):
        return [("arrays", ride)]
    if isinstance(ride, Mapping):
        return [(str(name), part) for name, part in ride.items()]
    if not isinstance(ride, Sequence):
        raise TypeError(f"a ride is a path, a frame or a mapping of arrays, not {type(ride).__name__}")
    last = [Path(part).name if is_path(part) else f"arrays {i + 1}" for i, part in enumerate(ride)]
    alone = len(ride) == 1
    return [
        (os.fspath(part) if is_path(part) and (alone or last.count(name) > 1) else name, part)
        for name, part in zip(last, ride, strict=True)
    ]


def contents(part: Any) -> bytes | tuple[list[tuple[str, Doubles]], float | None]:
    return Path(part).read_bytes() if is_path(part) else columns(part)
