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
def study(
    rides: Sequence[tuple[str, Sequence[Source], str]],
    reading: str,
    settings: str,
    progress: Callable[[str, int, int], object] | None,
    threads: int | None,
) -> str: ...
def study_summary(report: str) -> str: ...
def simulate(
    outing: str, bike: str, effects: str, accelerometers: float | None
) -> tuple[list[tuple[str, bytearray]], str]: ...
def series(record: Record, report: str, quantity: str) -> list[tuple[str, bytearray]]: ...
def model(text: str) -> str: ...
def compare(model: str, sources: Sequence[Source], bike: str | None, reading: str, alpha: float) -> str: ...
def predict(
    model: str, sources: Sequence[Source], bike: str | None, reading: str, at_rest: bool
) -> list[tuple[str, bytearray]]: ...
def summary(report: str) -> str: ...
def measured(value: float, std_error: float | None) -> str: ...
