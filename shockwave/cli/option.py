"""Options and arguments of commands, and the kinds of their values."""

from __future__ import annotations

import argparse
import math
import typing
from collections.abc import Callable, Sequence
from typing import Any

from attrs import frozen

from shockwave.base.errors import UsageError, hint_of, text_of
from shockwave.base.units import to_si


@frozen
class Option:
    """An option or an argument of a command: its names, its meaning, and arguments of `argparse`."""

    names: tuple[str, ...]
    meaning: str
    settings: dict[str, Any]

    @property
    def help(self) -> str:
        """The meaning, with range and default; those of an option that sets a key of the scenario are the key's."""
        if path := self.settings.get("path"):
            return self.meaning or _describe_key(path)
        meaning, bracket, stated = self.meaning.partition(" (default")
        default = self.settings.get("default")
        if default not in (None, [], argparse.SUPPRESS):
            bracket, stated = " (default", f": {default:g})" if isinstance(default, float) else f": {default})"
        return meaning + getattr(self.settings.get("type"), "rule", "") + bracket + stated

    @property
    def usage(self) -> list[str]:
        """Its names with the name of its value, as help shows them."""
        value = self.settings.get("metavar")
        value = " ".join(value) if isinstance(value, tuple) else value
        return [f"{name} {value}" if value else name for name in self.names if name.startswith("-")] or [value or ""]


def _describe_key(path: str) -> str:
    """Meaning, choices and default of a key of the scenario."""
    from shockwave.scenario.block_keys import BLOCKS  # not needed to read a command line

    block, _, name = path.rpartition(".")
    (key,) = (key for key in BLOCKS[block] if key.name == name)
    meaning, _, stated = key.meaning.replace("`", "").partition(". Default: ")
    choices = typing.get_args(key.annotation) if typing.get_origin(key.annotation) is typing.Literal else ()
    named = f": {', '.join(choices)}" if choices else ""
    default = stated if key.default in (None, ()) else key.default
    return f"{meaning[0].lower()}{meaning[1:]}{named}" + (f" (default: {default})" if default else "")


def option(usage: str, meaning: str, **settings: Any) -> Option:
    """An option from a usage such as ``-o --output FILE`` or ``FILE``; one without a name for a value is a flag."""
    *names, value = usage.split()
    if value.startswith("-"):
        return Option((*names, value), meaning, {"action": "store_true", **settings})
    once = {"action": _Once} if names else {}
    return Option(tuple(names) or (value.lower(),), meaning, {"metavar": value, **once, **settings})


class _Once(argparse.Action):
    """Store a value, and refuse a second one, which would silently replace the first."""

    _given = False

    def __call__(self, parser: Any, options: argparse.Namespace, value: Any, option: str | None = None) -> None:
        if self._given:
            raise UsageError(f"{option}: must be given once (got it again; see `{parser.prog} --help`)")
        self._given = True
        setattr(options, self.dest, value)


class Change(argparse.Action):
    """Add changes of the scenario to ``changes``, each an option, a path and the text of a value.

    The text is that of the option in ``form``; for an empty ``path`` it begins with a path. Values at the paths
    ``without``, which belong to the old value, are deleted. A second value for the same path is refused.
    """

    def __init__(
        self, path: str = "", form: str = "{}", without: Sequence[str] = (), dest: str = "", **settings: Any
    ) -> None:
        super().__init__(dest="changes", default=(), **settings)
        self.path, self.form, self.without = path, form, without

    def __call__(self, _: Any, options: argparse.Namespace, text: Any, option: str | None = None) -> None:
        path, equals, value = (self.path, "=", self.form.format(text)) if self.path else text.partition("=")
        if not equals:
            raise argparse.ArgumentError(self, f"must be PATH=VALUE (got {text_of(text)}; `{text}=` deletes it)")
        for earlier, other, given in options.changes:
            if other == path and given:
                raise argparse.ArgumentError(self, f"must give {path} only once (got {given!r} from {earlier} before)")
        deleted = ((option, other, "") for other in self.without)
        options.changes = (*deleted, *options.changes, (option, path, value))


def key_option(usage: str, path: str, meaning: str = "", **settings: Any) -> Option:
    """An option for the key of a scenario at a path."""
    return option(usage, meaning, action=Change, path=path, **settings)


def number_between(low: float, high: float, kind: Callable[[str], float] = to_si) -> Callable[[str], float]:
    """Parser of a number within limits."""

    def number(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"must be{number.rule[1:]} (got {text})")  # type: ignore[attr-defined]
        return value

    number.rule = f", >= {low:g} and <= {high:g}"  # type: ignore[attr-defined]
    return number


def check_folder(text: str) -> str:
    """The name of a folder, unchanged; `-` names none."""
    if text == "-":
        raise argparse.ArgumentTypeError("must be a folder, not standard input or output (got '-')")
    return text


def one_of(*names: str) -> dict[str, Any]:
    """Arguments of an option whose values are names."""

    def choice(text: str) -> str:
        if text in names:
            return text
        raise argparse.ArgumentTypeError(f"unknown name (got {text_of(text)}; {hint_of(text, names)})")

    choice.rule = f": {', '.join(names)}"  # type: ignore[attr-defined]
    return {"type": choice}
