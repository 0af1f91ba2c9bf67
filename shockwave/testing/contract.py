"""Base class of contract tests: one test per clause, run for each member of a list."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import pytest

from shockwave.base.errors import UnknownNameError
from shockwave.base.quantity_fields import declaration_of, text_of
from shockwave.base.units import is_si
from shockwave.registry.registry import KINDS, find, load


class Contract:
    """Base class of contracts: each clause is a test, which runs for each member of the list in the subclass."""

    #: Omitted clauses or tests, with the reasons: ``{"clause 5": "closed forms are accurate to 1e-9"}``.
    leave_out: ClassVar[Mapping[str, str]] = {}

    # Name of a member in the tests, its type, and a description of the list, whose name is the plural.
    _member: ClassVar[str]
    _type: ClassVar[type] = type
    _wanted: ClassVar[str] = "classes"

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Run each test for each member of the list."""
        name = f"{self._member}s"
        members = getattr(self, name, None)
        if not members or not all(isinstance(member, self._type) for member in members):
            rule = f"{type(self).__name__}.{name} must be a list of {self._wanted}"
            pytest.fail(f"{rule} (got {text_of(members, 300)})", pytrace=False)
        metafunc.parametrize(self._member, members, ids=_id)

    @pytest.fixture(autouse=True)
    def _skip_omitted_tests(self, request: pytest.FixtureRequest) -> None:
        name = request.function.__name__
        clause = request.node.callspec.params.get("clause", "").partition(",")[0]
        for key, reason in self.leave_out.items():
            prefix = f"test_{key.replace(' ', '_').replace('-', '_')}_"
            if key in (name, clause) or name.startswith(prefix):
                pytest.skip(f"left out: {reason}")


def _id(member: Any) -> str:
    """Name of a class, or repr of an object; the default repr differs between processes."""
    cls: Any = type(member)
    plain = isinstance(member, type) or cls.__repr__ is object.__repr__
    return getattr(member, "__name__", cls.__name__) if plain else text_of(member, 80)


def check_registered(kind: str, cls: Any) -> None:
    """Fail if the class has no name or is not registered by it."""
    name = getattr(cls, "name", None)
    assert isinstance(name, str), f"name must be a string (got {name!r})"
    remedy = f"return an Entry with it and the address of the class from shockwave_{kind} in your hooks, and install"
    try:
        noun = load(kind, name)
    except UnknownNameError:
        pytest.fail(f"no {KINDS[kind]} is registered as {name!r}: {remedy}", pytrace=False)
    assert noun is cls, f"{name!r} is registered for another class, {find(kind, name).address}: {remedy}"


def check_parameters(member: Any) -> None:
    """Fail if a declared quantity of an object has no description, or a unit that is not an SI unit."""
    specs = [declaration_of(field) for field in getattr(member, "__attrs_attrs__", ()) if field.init]
    for spec in filter(None, specs):
        assert spec.meaning, f"a field has no description: write  quantity({spec.unit!r}, 'description', ...)"
        assert is_si(spec.unit), f"the unit must be an SI unit (got {spec.unit!r})"


def check_twin(member: Any, twin: Any) -> None:
    """Fail if a copy of an object does not equal it."""
    assert twin == member, "a copy is not equal: for arrays use eq=attrs.cmp_using(eq=numpy.array_equal)"
    assert hash(twin) == hash(member), "a copy has a different hash: decorate the class with @attrs.frozen"
