from typing import Any

def run(
    method: Any,
    rows: Any,
    coefficients: Any,
    stops: Any,
    times: Any,
    settings: Any,
    table: Any,
    samples: Any,
    expired: Any,
) -> None: ...
