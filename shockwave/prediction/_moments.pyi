from typing import Any

def gauss(times: Any, impulses: Any, instants: Any, parts: Any, rows: int) -> bool: ...
def law(
    times: Any,
    impulses: Any,
    log_force: Any,
    columns: Any,
    rows: int,
    width: float,
    reach: float,
    peak: float,
    step_limit: float,
    similar: bool,
) -> None: ...
