"""The contracts for plugins where pytest is not installed."""

import subprocess
import sys


def test_the_contracts_state_how_pytest_is_installed() -> None:
    code = "import sys; sys.modules['pytest'] = None; import shockwave.testing"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert answer.stderr.rstrip().endswith("ImportError: shockwave.testing needs pytest: python -m pip install pytest")
