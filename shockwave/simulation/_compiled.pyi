from typing import Any

def primary(
    method: Any, jobs: Any, rows: Any, coefficients: Any, stops: Any, wanted: Any, found: Any, lanes: int
) -> None: ...
def attempt(
    method: Any,
    rows: Any,
    coefficients: Any,
    state: Any,
    after: Any,
    time: float,
    size: float,
    rise_time: float,
    force: float,
) -> float: ...
