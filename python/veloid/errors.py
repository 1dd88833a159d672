"""Errors, each with the place of the fault. The messages are those of the command line and the server."""

from __future__ import annotations

from typing import Any


class VeloidError(Exception):
    """An error of veloid. The place of the fault is given by attributes, which are None where unknown."""

    def __init__(self, message: str, **place: Any) -> None:
        super().__init__(message)
        vars(self).update(place)


class RideError(VeloidError, ValueError):
    """The ride cannot be used."""

    file: str | None = None
    """Its name; `arrays` for arrays."""
    kind: str | None = None
    """Kind of fault, as a stable word."""
    column: str | None = None
    """The column's header."""
    column_number: int | None = None
    """The column's number, counted from 1."""
    row: int | None = None
    """The row, counted from 0, of arrays and of files without lines."""
    line: int | None = None
    """The line, counted from 1, of files with lines."""


class BikeError(VeloidError, ValueError):
    """The bike cannot be used."""

    key: str | None = None


class OptionError(VeloidError, ValueError):
    """An option is not allowed."""

    key: str | None = None


class IdentificationError(VeloidError):
    """Nothing could be identified."""

    axle: str | None = None
    """The axle with too little data."""
    stage: str | None = None
    """The stage that failed."""


class ServerError(VeloidError):
    """The server rejected a request, with a problem of RFC 9457."""

    status: int
    kind: str
    """A stable word, `urn:veloid:problem:...`."""
    detail: str
    place: dict[str, Any] | None = None
    """Of a ride's fault: file, line and column."""


class JobError(VeloidError):
    """A job of a server ended without a report."""

    state: str
