"""Forces at the contacts of chains beyond equal spheres, compared with an independent integration.

    python research/check/check_chains.py

simulates the 300 random chains of ``tests/support/random_chains.py``: 2 to 200 granules in segments, tapers and cells
of seven materials, walls, movable ends, gaps, precompression, gravity, three dampings, contact exponents, shocks and
strikers. The reference is ``tests/support/chain_reference.py``. Collisions amplify its errors, too: if an error exceeds
the tolerance or its estimate, the reference is repeated with twice its tolerance, and only what exceeds their
difference is counted. The table, at three tolerances, is written into ``docs/chains.md``. It takes about an hour on one
core; all cores are used. ``--count`` changes the number of chains.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

import shockwave as sw

sys.path.append(str(Path(__file__).parents[2] / "tests"))
from support.chain_reference import Reference
from support.random_chains import scene

PAGE = Path(__file__).parents[2] / "docs" / "chains.md"
END = "<!-- end of table -->"
COUNT = 300
# Chains after which the table so far is printed.
PROGRESS = 50
TOLERANCES = (1e-4, 1e-6, 1e-8)
# Ratio of the tolerance of the repeated reference to that of the first.
LOOSER = 2.0
# Forces below this share of the greatest dynamic part are not compared.
LEAST = 1e-9


def checked(number: int) -> list[tuple[float, ...]]:
    """A chain at each tolerance.

    Each row has the tolerance, the largest relative error of a force for which it holds, the share of their contacts
    whose errors are below the tolerance, and of all contacts whose errors are below their estimates, the largest error
    over the largest estimate, whether there is a warning, the largest error of a time over the characteristic time, and
    the number of granules.
    """
    excitation, chain = scene(number)
    rows: list[tuple[float, ...]] = []
    known, end, repeated = None, None, False
    for rtol in sorted(TOLERANCES):
        result = sw.simulate(excitation, chain, rtol=rtol, until=end)
        if result.wave is not None:
            return []  # equal granules with free ends
        if known is None:
            end = result.end
            reference = Reference(excitation, chain, result.characteristic_time)
            known = reference.greatest(end)
            uncertain = np.zeros_like(known[0])
        dynamic, times = known
        compared = [peak.contact for peak in result.contacts if dynamic[peak.contact] > LEAST * dynamic.max()]
        peaks = [result.contacts[contact] for contact in compared]
        own = np.array([peak.peak_force - peak.static_force for peak in peaks])
        errors = np.abs(own - dynamic[compared]) / dynamic[compared]
        estimates = np.array([peak.error_estimate for peak in peaks])
        # rtol holds for the greatest force and at the last contact
        judged = np.isin(compared, [result.greatest_force.contact, result.contacts[-1].contact])
        if np.any(errors > np.minimum(estimates, rtol)) and not repeated:
            repeated, uncertain = True, np.abs(reference.greatest(end, LOOSER)[0] - dynamic)
        errors = np.maximum(errors - uncertain[compared] / dynamic[compared], 0.0)
        late = np.abs([peak.time for peak in peaks] - times[compared]) / result.characteristic_time
        same = late < 0.5  # not another maximum of about the same force
        rows.append(
            (
                rtol,
                errors[judged].max(),
                np.mean(errors[judged] <= rtol),
                np.mean(errors <= estimates),
                errors.max() / estimates.max(),
                bool(result.warnings),
                late[same].max(initial=0.0),
                len(result.velocities),
            )
        )
    return rows


def attempt(number: int) -> list[tuple[float, ...]] | str:
    """`checked`, or the error."""
    try:
        return checked(number)
    except sw.ShockwaveError as error:
        return f"chain {number}: {error}"


def table(found: list[list[tuple[float, ...]]]) -> Iterator[str]:
    """A row for each tolerance."""
    yield "| `rtol` | chains | within `rtol`, % | without warning, % | contacts, % | estimate holds, % | contacts, % |"
    yield "|---|---|---|---|---|---|---|"
    for rtol in TOLERANCES:
        rows = np.array([row for rows in found for row in rows if row[0] == rtol])
        within, quiet = rows[:, 1] <= rtol, rows[:, 5] == 0
        shares = within, within[quiet], rows[:, 2], rows[:, 4] <= 1, rows[:, 3]
        yield f"| {rtol:.0e} | {len(rows)} | " + " | ".join(f"{100 * np.mean(share):.1f}" for share in shares) + " |"


def main() -> None:
    """Check all chains, print the table and write it into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, help="number of chains; leaves the page as it is")
    parser.add_argument("--processes", type=int, help="by default one for each core")
    options = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    found, failed = [], []
    with ProcessPoolExecutor(options.processes) as pool:
        for number, rows in enumerate(pool.map(attempt, range(options.count or COUNT))):
            if isinstance(rows, str):
                failed.append(rows)
            else:
                found.append(rows)
            if (number + 1) % PROGRESS == 0:
                print(f"{number + 1} chains", *table(found), sep="\n", flush=True)
    text = "\n".join(table(found))
    print("\n".join([text, *failed]))
    if not options.count:
        begin = "<!-- table: random chains -->\n"
        before, rest = PAGE.read_text().split(begin)
        PAGE.write_text(f"{before}{begin}{text}\n{END}{rest.partition(END)[2]}")


if __name__ == "__main__":
    main()
