"""What the three contracts share: the list of what is tested, opt-outs with a reason, and messages that help."""

from __future__ import annotations

import functools
import inspect
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NoReturn, TypeVar, cast

import pytest

from shockwave.errors import UnknownNameError
from shockwave.fields import text_of
from shockwave.registry import KINDS, find, load
from shockwave.testing.faults import loose_field, told

__all__ = ["Contract", "after", "clauses_of"]

_Test = TypeVar("_Test", bound=Callable[..., None])

_WIDTH = 110
_LONGEST_REPR, _LONGEST_ID = 300, 80
_CLAUSE = re.compile(r"^ *(\d+)\. +(.+?)(?=^ *\d+\. |^ *$|\Z)", re.MULTILINE | re.DOTALL)
_TEST = re.compile(r"test_(?:(.+)_)?clause_(\d+)_")
_SEE = "see "

# What a test has found, by contract, test and member: why it failed, why it was skipped. What stands on a test asks for
# it, and code that remembers its calls would not answer a second time as it did at first. The member is kept, for
# another could be given its id.
_known: dict[tuple[type, str, int], tuple[object, str, str]] = {}


def clauses_of(cls: type) -> dict[int, str]:
    """The numbered clauses of the contract in the docstring of ``cls``; none where docstrings are stripped."""
    found = _CLAUSE.findall(inspect.cleandoc(cls.__doc__ or ""))
    return {int(number): " ".join(text.split()) for number, text in found}


def after(*grounds: str) -> Callable[[_Test], _Test]:
    """A test whose failures are told in words, and which is skipped where one of its ``grounds`` does not hold.

    A ground is the beginning of names of tests, without ``test_``: ``clause_2``, ``clause_1_order``. One fault so fails
    one test: what would fail on account of it says which test to see first.
    """

    def decorated(test: _Test) -> _Test:
        @functools.wraps(test)
        def run(self: Contract, *args: object, **kwargs: object) -> None:
            (member,) = (*args, *kwargs.values())
            failed, skipped = self._outcome(test, grounds, member)
            # Outside of any handler of exceptions: pytest would show what led here, too.
            if failed:
                pytest.fail(failed, pytrace=False)
            if skipped:
                pytest.skip(skipped)

        return cast(_Test, run)

    return decorated


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
            loose = loose_field(member if isinstance(member, type) else type(member))
            if loose:
                pytest.fail(f"{where}[{index}]: {loose}", pytrace=False)
            problem = self._problem(member)
            if problem:
                got = text_of(member, _LONGEST_REPR)
                pytest.fail(f"{where}[{index}] must be {problem} (got {got}): {wanted}", pytrace=False)
        return members

    def _left_out(self) -> dict[str, str]:
        """Names of the tests that are left out, with the reasons."""
        tests = self._tests()
        names: dict[str, list[str]] = {name: [name] for name in tests}
        for name in tests:
            if _label(name):
                names.setdefault(_label(name), []).append(name)
        where = f"{type(self).__name__}.leave_out"
        if not isinstance(self.leave_out, Mapping):
            pytest.fail(f"{where} must be a dict of clauses and reasons (got {self.leave_out!r})", pytrace=False)
        found: dict[str, str] = {}
        for key, reason in self.leave_out.items():
            if key not in names:
                known = ", ".join(sorted(names.keys() - set(tests), key=_ascending))
                rule = f"must be one of {known}, or the name of a test"
                pytest.fail(f"{where}: {rule} (got {key!r})", pytrace=False)
            if not isinstance(reason, str) or not reason.strip():
                pytest.fail(f"{where}[{key!r}] must be a reason in words (got {reason!r})", pytrace=False)
            found |= dict.fromkeys(names[key], reason)
        return found

    @classmethod
    def _tests(cls) -> list[str]:
        return [name for name in dir(cls) if name.startswith("test_")]

    # ---------------------------------------------------------------- what a test finds

    def _outcome(self, test: Callable[..., None], grounds: Sequence[str], member: object) -> tuple[str, str]:
        """Why ``test`` fails for ``member``, or why it is skipped; texts that are empty if it passes."""
        key = type(self), test.__name__, id(member)
        if key not in _known:
            reason = next(filter(None, (self._broken_ground(ground, member) for ground in grounds)), "")
            _known[key] = (member, "", reason) if reason else (member, *self._tried(test, member))
        return _known[key][1:]

    def _broken_ground(self, ground: str, member: object) -> str:
        """Which test is to be seen first, if one of ``ground`` does not hold; those left out are taken to hold."""
        names = [name for name in self._tests() if f"{name}_".startswith(f"test_{ground}_")]
        if not names:
            raise LookupError(ground)
        left_out = self._left_out()
        for name in names:
            failed, skipped = ("", "") if name in left_out else self._tried(getattr(type(self), name), member)
            if failed:
                return f"{_SEE}{_label(name) or name} first ({name})"
            if skipped.startswith(_SEE):
                return skipped
        return ""

    def _tried(self, test: Callable[..., None], member: object) -> tuple[str, str]:
        try:
            test(self, member)
        except pytest.fail.Exception as failure:
            return str(failure), ""
        except pytest.skip.Exception as skipped:
            return "", str(skipped)
        except Exception as error:
            label = _label(test.__name__) or test.__name__
            return self._message(label, member, f"{told(error)} is raised", "see to that line"), ""
        return "", ""

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
        pytest.fail(self._message(label, member, what, mend), pytrace=False)

    def _message(self, label: str, member: Any, what: str, mend: str) -> str:
        kind, clause, number = label.rpartition("clause ")
        signed = self._signed[kind.strip()] if clause else None
        of = label if signed is None else f"clause {number} of the contract of {signed.__name__}"
        shown = _cut(self._shown(member), _LONGEST_REPR)
        lines = [f"{type(self).__name__}: {of} does not hold for {shown}", f"found: {what}", f"to mend: {mend}"]
        if signed is not None:
            lines.append(f"the clause: {clauses_of(signed).get(int(number), '')}")
        return "\n".join(map(_folded, lines))

    def _check_name(self, member: Any) -> None:
        """Fail clause 1 unless the name of the class is a text."""
        name = getattr(member, "name", None)
        if not isinstance(name, str) or not name:
            self._broken("clause 1", member, f"name is {name!r}", 'write  name = "my-name"  in the class')

    def _check_registered(self, kind: str, member: Any) -> None:
        """Fail clause 1 unless the class is registered under its name."""
        name, hook = member.name, f"shockwave_{kind}"
        try:
            loaded = load(kind, name)
        except UnknownNameError:
            mend = f"return an Entry({name!r}, ...) from {hook} in your hooks, and install the distribution"
            self._broken("clause 1", member, f"no {KINDS[kind]} is registered as {name!r}", mend)
        if loaded is not member:
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
