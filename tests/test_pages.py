"""How outputs that the pages show are compared: text to the letter, numbers to their last digit."""

from __future__ import annotations

import pytest

from pages import ROOT, Block, agree, execute

#: What a page shows, and what another processor may print.
SAME = {
    "equal": ("peak force 116.8 N, 84 steps", "peak force 116.8 N, 84 steps"),
    "last-digit": ("within 5e-08 relative", "within 4e-08 relative"),
    "last-of-many-digits": ("0.8829354351583389 s", "0.8829354351583401 s"),
    "all-digits-against-few": ("quadrature 1.0", "quadrature 0.9999999999999999"),
    "few-digits-against-all": ("quadrature 0.9999999999999999", "quadrature 1.0"),
    "across-a-power-of-ten": ("error 1.0e-06", "error 9.9e-07"),
    "zeros-left-out": ("1.1682", "1.16819"),
    "rounding": ("momentum defect 2e-16", "momentum defect 4e-16"),
    "rounding-that-vanishes": ("momentum defect 2e-16", "momentum defect 0e+00"),
    "wider-column": ("a    b\n---  -----\n0.0  2e-16", "a       b\n------  -----\n-1e-17  0e+00"),
    "anything": ("took ... s, 3 times\n... and so on", "took 0.25 s, 3 times\na\nb and so on"),
    "nothing-but-spaces": ("name  ...  from\n----  ...", "name        from\n----------  ----"),
    "digits-left-open": ("alpha 1.1681...", "alpha 1.16817"),
    "other-backend": ("simulation by rkn86 (compiled)", "simulation by rkn86 (numpy)"),
    "space-at-the-end": ("done\n", "done  \n\n"),
}

#: What a page shows, and what is wrong.
DIFFERENT = {
    "number": ("peak force 116.8 N", "peak force 117.1 N"),
    "two-units": ("within 5e-08 relative", "within 3e-08 relative"),
    "short-number": ("quadrature 1.0", "quadrature 0.95"),
    "sign": ("margin -0.5", "margin 0.5"),
    "rounding-grown": ("momentum defect 2e-16", "momentum defect 2e-12"),
    "count": ("84 steps", "85 steps"),
    "no-count": ("84 steps", "84.5 steps"),
    "word": ("regime train, peak 1.5", "regime single, peak 1.5"),
    "unit": ("1.5 N", "1.5 kN"),
    "name-with-a-digit": ("table1-row1", "table1-row2"),
    "version": ("version 0.1.0", "version 0.1.1"),
    "line-missing": ("one 1.5\ntwo 2.5", "one 1.5"),
    "line-added": ("one 1.5", "one 1.5\ntwo 2.5"),
    "around-anything": ("took ... s, 3 times", "took 0.25 s, 4 times"),
    "number-after-anything": ("... and 1.5 N", "a\nb and 1.9 N"),
    "digits-left-open": ("alpha 1.1681...", "alpha 1.16827"),
}


@pytest.mark.parametrize("name", SAME)
def test_last_digits_may_differ(name: str) -> None:
    assert agree(*SAME[name])


@pytest.mark.parametrize("name", DIFFERENT)
def test_other_text_or_numbers_do_not_agree(name: str) -> None:
    assert not agree(*DIFFERENT[name])


def session(text: str) -> Block:
    return Block(page=ROOT / "README.md", line=1, language="pycon", directives={}, text=text)


@pytest.mark.parametrize("text", [">>> 0.1 + 0.2\n0.3\n", ">>> print('a\\n\\nb')\na\n<BLANKLINE>\nb\n"])
def test_sessions_are_compared_alike(text: str) -> None:
    execute(session(text), {})


def test_a_session_that_prints_another_number_fails() -> None:
    with pytest.raises(AssertionError, match="Expected"):
        execute(session(">>> 0.1 + 0.2\n0.31\n"), {})
