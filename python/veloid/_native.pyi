from collections.abc import Callable, Sequence

from .frames import Doubles

__version__: str

Source = tuple[str, bytes | tuple[Sequence[tuple[str, Doubles]], float | None]]

class Record: ...

def identify(
    sources: Sequence[Source],
    bike: str,
    reading: str,
    settings: str,
    progress: Callable[[str, int, int], object] | None,
    threads: int | None,
) -> tuple[str, Record]: ...
def simulate(
    outing: str, bike: str, effects: str, accelerometers: float | None
) -> tuple[list[tuple[str, bytearray]], str]: ...
def series(record: Record, report: str, quantity: str) -> list[tuple[str, bytearray]]: ...
def summary(report: str) -> str: ...
def measured(value: float, std_error: float | None) -> str: ...
