"""Examples in the docstrings of public names: they exist, and print what they show."""

import inspect
from typing import Any

import pytest

import shockwave as sw
from support import pages
from support.pages import ROOT, Block

#: Results of functions, base classes of plugins and parts of section 4: their users do not construct them.
NOT_CONSTRUCTED = {
    *("Comparison", "ContactLaw", "Design", "EjectionOutcome", "Outcome", "ShockProfile", "Simulation"),
    "ShockSpectrum",
    *("SingleOutcome", "SweepReport", "SweepResults", "TrainOutcome", "Uncertainty", "Verdict"),
}
#: They need a file of a sweep; `docs/python/sweeps.md` shows them.
WITH_A_FILE = {"load_sweep", "run_sweep"}
NAMES = [name for name in sw.__all__ if not name.endswith("Error") and name not in NOT_CONSTRUCTED | WITH_A_FILE]


@pytest.mark.parametrize("name", NAMES)
def test_examples_print_what_is_shown(name: str, patch: pytest.MonkeyPatch) -> None:
    shown = inspect.unwrap(getattr(sw, name))
    text = (inspect.getdoc(shown) or "").partition("Examples\n--------\n")[2]
    assert ">>> " in text
    names: dict[str, Any] = {}
    pages.execute(Block(ROOT / name, 1, "pycon", {}, text), names)
    assert {"sw"} <= set(names)


def test_names_without_an_example_exist() -> None:
    assert set(sw.__all__) >= NOT_CONSTRUCTED | WITH_A_FILE
