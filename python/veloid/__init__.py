"""A bicycle's vertical stiffness and damping from a ride, and the physics that the model leaves out.

`identify`, `diagnose`, `study` and `simulate` run the engine in this process; `Client` talks to a server. See `docs/python.md`.
"""

from ._native import __version__
from .client import Client, Job
from .engine import Progress, diagnose, identify, study
from .errors import (
    BikeError,
    IdentificationError,
    JobError,
    OptionError,
    RideError,
    ServerError,
    VeloidError,
)
from .model import Comparison, Model
from .report import Diagnosis, Report, Study
from .simulation import Simulated, simulate

__all__ = [
    "BikeError",
    "Client",
    "Comparison",
    "Diagnosis",
    "IdentificationError",
    "Job",
    "JobError",
    "Model",
    "OptionError",
    "Progress",
    "Report",
    "RideError",
    "ServerError",
    "Simulated",
    "Study",
    "VeloidError",
    "__version__",
    "diagnose",
    "identify",
    "simulate",
    "study",
]
