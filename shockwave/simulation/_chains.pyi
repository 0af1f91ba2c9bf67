from typing import Any

def run(
    method: Any,
    rows: Any,
    coefficients: Any,
    stops: Any,
    times: Any,
    settings: Any,
    chain: Any,
    x: Any,
    v: Any,
    scales: Any,
    peaks: Any,
    sums: Any,
    samples: Any,
    found: Any,
    expired: Any,
) -> None: ...
