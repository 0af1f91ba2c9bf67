"""What the three contracts share: the list of what is tested, opt-outs with a reason, and messages that help."""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NoReturn

import pytest

from shockwave.errors import UnknownNameError
from shockwave.fields import text_of
from shockwave.registry import KINDS, find, load

__all__ = ["Contract", "clauses_of"]

_WIDTH = 110
_LONGEST_REPR, _LONGEST_ID = 300, 80
_CLAUSE = re.compile(r"^ *(\d+)\. +(.+?)(?=^ *\d+\. |^ *$|\Z)", re.MULTILINE | re.DOTALL)
_TEST = re.compile(r"test_(?:(.+)_)?clause_(\d+)_")


def clauses_of(cls: type) -> dict[int, str]:
    """The numbered clauses of the contract in the docstring of ``cls``; none where docstrings are stripped."""
    found = _CLAUSE.findall(inspect.cleandoc(cls.__doc__ or ""))
    return {int(number): " ".join(text.split()) for number, text in found}


class Contract:
    """Base class of the contracts: each clause is one test, which runs for each thing that the subclass lists."""

    #: Clauses or tests that are left out, each with its reason: ``{"clause 7": "the closed form is good to 1e-9"}``.
    leave_out: ClassVar[Mapping[str, str]] = {}

    # The list that a subclass writes, what a test calls one of its members, and a line that shows how it is written.
    _list: ClassVar[str]
    _member: ClassVar[str]
    _example: ClassVar[str]
    # Classes whose docstrings number the clauses, under the word that their tests and labels begin with.
    _signed: ClassVar[Mapping[str, type]]

    # ---------------------------------------------------------------- what pytest calls

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Run each test for each member of the list; those that are left out are skipped with their reason."""
        members, reasons = self._members(), self._left_out()
        if self._member in metafunc.fixturenames:
            reason = reasons.get(metafunc.function.__name__)
            marks = [pytest.mark.skip(reason=f"left out: {reason}")] if reason else []
            ids = [_cut(self._shown(member), _LONGEST_ID) for member in members]
            rows = [pytest.param(member, id=name, marks=marks) for member, name in zip(members, ids, strict=True)]
            metafunc.parametrize(self._member, rows)

    def _members(self) -> Sequence[Any]:
        """What the subclass lists, checked."""
        members = getattr(self, self._list, None)
        where = f"{type(self).__name__}.{self._list}"
        wanted = f"write  {self._example}  in the class"
        if members is None:
            pytest.fail(f"{where} must be given: {wanted}", pytrace=False)
        if not isinstance(members, list | tuple) or not members:
            pytest.fail(f"{where} must be a list with one member at least (got {members!r}): {wanted}", pytrace=False)
        for index, member in enumerate(members):
            problem = self._problem(member)
            if problem:
                got = text_of(member, _LONGEST_REPR)
                pytest.fail(f"{where}[{index}] must be {problem} (got {got}): {wanted}", pytrace=False)
        return members

    def _left_out(self) -> dict[str, str]:
        """Names of the tests that are left out, with the reasons."""
        tests = {name for name in dir(Contract if type(self) is Contract else type(self)) if name.startswith("test_")}
        names = {name: name for name in tests} | {label: name for name in tests if (label := _label(name))}
        where = f"{type(self).__name__}.leave_out"
        if not isinstance(self.leave_out, Mapping):
            pytest.fail(f"{where} must be a dict of clauses and reasons (got {self.leave_out!r})", pytrace=False)
        found = {}
        for key, reason in self.leave_out.items():
            if key not in names:
                known = ", ".join(sorted(names.keys() - tests, key=_ascending))
                rule = f"must be one of {known}, or the name of a test"
                pytest.fail(f"{where}: {rule} (got {key!r})", pytrace=False)
            if not isinstance(reason, str) or not reason.strip():
                pytest.fail(f"{where}[{key!r}] must be a reason in words (got {reason!r})", pytrace=False)
            found[names[key]] = reason
        return found

    # ---------------------------------------------------------------- what a kind of contract says

    def _problem(self, member: object) -> str:
        """What a member must be, if it is not."""
        raise NotImplementedError

    def _shown(self, member: Any) -> str:
        """A member as ids and messages show it."""
        # The repr that every object has tells an address, which is another in each process.
        cls: Any = type(member)
        return f"{cls.__name__}()" if cls.__repr__ is object.__repr__ else repr(member)

    # ---------------------------------------------------------------- for its tests

    def _broken(self, label: str, member: Any, what: str, mend: str) -> NoReturn:
        """Fail the test of ``label`` ("clause 3"): ``what`` is wrong, and how to ``mend`` it."""
        kind, clause, number = label.rpartition("clause ")
        signed = self._signed[kind.strip()] if clause else None
        told = label if signed is None else f"clause {number} of the contract of {signed.__name__}"
        shown = _cut(self._shown(member), _LONGEST_REPR)
        lines = [f"{type(self).__name__}: {told} does not hold for {shown}", f"found: {what}", f"to mend: {mend}"]
        if signed is not None:
            lines.append(f"the clause: {clauses_of(signed).get(int(number), '')}")
        pytest.fail("\n".join(map(_folded, lines)), pytrace=False)

    def _check_name(self, kind: str, member: Any, cls: type) -> None:
        """Fail clause 1 unless the name of ``cls`` is a text under which the class is registered."""
        name = getattr(cls, "name", None)
        if not isinstance(name, str) or not name:
            self._broken("clause 1", member, f"name is {name!r}", 'write  name = "my-name"  in the class')
        hook = f"shockwave_{kind}"
        try:
            loaded = load(kind, name)
        except UnknownNameError:
            mend = f"return an Entry({name!r}, ...) from {hook} in your hooks, and install the distribution"
            self._broken("clause 1", member, f"no {KINDS[kind]} is registered as {name!r}", mend)
        if loaded is not cls:
            mend = f"let the Entry({name!r}, ...) that {hook} returns hold the address of this class"
            at = find(kind, name).address
            self._broken("clause 1", member, f"{name!r} is registered for another class, {at}", mend)


def guarded(function: Callable[[], Any], otherwise: Callable[[Exception], NoReturn]) -> Any:
    """What ``function`` returns; what it raises goes to ``otherwise``, which fails the test in words."""
    try:
        return function()
    except Exception as error:
        otherwise(error)


def _label(test: str) -> str:
    """``clause 3`` for ``test_clause_3_...``, ``one-step clause 3`` for ``test_one_step_clause_3_...``."""
    match = _TEST.match(test)
    if match is None:
        return ""
    kind = f"{match[1].replace('_', '-')} " if match[1] else ""
    return f"{kind}clause {match[2]}"


def _cut(text: str, longest: int) -> str:
    text = " ".join(text.split())
    return text if len(text) <= longest else text[: longest - 3] + "..."


def _ascending(label: str) -> tuple[str, int]:
    kind, _, number = label.rpartition(" ")
    return kind, int(number)


def _folded(line: str) -> str:
    return textwrap.fill(line, _WIDTH, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
