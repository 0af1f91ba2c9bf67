"""The parser of the command line."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from typing import NoReturn

from shockwave import __version__
from shockwave.base.errors import UsageError, hint_of, text_of
from shockwave.cli.command_table import COMMANDS, EXITS, NO_PLUGINS, OFFERED, PAGE, Command


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are raised."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message.removeprefix('argument ')} (see `{self.prog} --help`)")


class _Version(argparse.Action):
    """Print the version and the back end, which is looked up only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from shockwave.engine.backend import lack

        backend = f"numpy; compiled code {lack()}" if lack() else "compiled"
        print(f"shockwave {__version__} (back end: {backend})")
        parser.exit()


def parser(name: str = "", in_full: bool = False) -> argparse.ArgumentParser:
    """Parser of the command ``name``, or of all commands; ``in_full`` adds the parts of its help that take time.

    Each sets ``command`` to the address of the function that runs it.
    """
    top = _Parser(
        prog="shockwave",
        usage="shockwave [options] COMMAND ...",
        description="Solitary waves in granular chains under shocks.",
        epilog=f"`shockwave COMMAND --help` describes a command.\n\n{PAGE}\n\n{EXITS}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    top.add_argument("-V", "--version", action=_Version, nargs=0, help="print the version and the back end, and exit")
    top.add_argument("--no-plugins", action="store_true", help=NO_PLUGINS.help)
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in [command for command in COMMANDS if command.name == name] or COMMANDS:
        single = commands.add_parser(
            command.name,
            prog=f"shockwave {command.name}",
            usage=_usage(command),
            help=command.summary,
            description=command.summary,
            epilog=command.epilog if in_full else None,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        single.set_defaults(command=command.address, changes=())
        for option in command.all_options:
            text = (option.help if in_full else option.meaning).replace("%", "%%")
            single.add_argument(*option.names, help=text, **option.settings)
    return top


def _usage(command: Command) -> str:
    """Usage of a command: its arguments and the options that it requires."""
    words = [f"shockwave {command.name}"]
    for option in command.options:
        value, count = option.usage[-1], str(option.settings.get("nargs"))
        if not value.startswith("-"):
            words.append({"?": f"[{value}]", "*": f"[{value} ...]", "+": f"{value} ..."}.get(count, value))
        elif option.settings.get("required"):
            words.append(value)
    return " ".join([*words, "[options]"])


def parse(arguments: list[str]) -> argparse.Namespace:
    """Options of a command; the arguments of a command of a plugin are left to its function.

    An unknown name is that of a plugin, which is looked up when the command runs. Without a command, the help is
    printed on stderr, and the exit status is that of wrong usage.
    """
    if arguments[:1] == ["help"]:
        arguments = [*arguments[1:], "--help"]
    no_plugins = arguments[:1] == ["--no-plugins"]
    name, *rest = arguments[no_plugins:] or [""]
    if not name:
        parser().print_help(sys.stderr)
        raise SystemExit(UsageError.exit_code)
    offered = name in OFFERED and {"-h", "--help"}.isdisjoint(rest)  # its help needs no plugin
    if offered or not (name.startswith("-") or name in {command.name for command in COMMANDS}):
        return argparse.Namespace(command="plugin_commands:run", no_plugins=no_plugins, name=name, arguments=rest)
    return parse_command(name, arguments)


def parse_command(name: str, arguments: Sequence[str]) -> argparse.Namespace:
    """Options of the command ``name``, which is among the arguments."""
    _check_options(name, arguments)
    in_full = not (name.startswith("-") or {"-h", "--help"}.isdisjoint(arguments))
    options, others = parser(name, in_full).parse_known_args(arguments)
    if others:
        raise UsageError(f"unrecognized arguments: {' '.join(others)} (see `shockwave {name} --help`)")
    return options


def _check_options(name: str, words: Sequence[str]) -> None:
    """Raise a `UsageError` for an unknown option."""
    options = [option for command in COMMANDS if command.name == name for option in command.all_options]
    flags = [flag for option in options or [NO_PLUGINS] for flag in option.names if flag.startswith("-")]
    names = ["--help", *flags, *([] if options else ["-V", "--version"])]
    for word in words:
        if word == "--":
            return
        flag = word.partition("=")[0] if word.startswith("--") else word[:2]
        if re.match("--|-[A-Za-z]", flag) and flag not in {*names, "-h"}:
            hint = hint_of(flag, [each for each in names if each.startswith("--")])
            if "--set" in names:
                from shockwave.scenario.block_keys import paths_of  # needed only here

                paths = paths_of(flag.strip("-").replace("-", "_"))
                hint = f"use `--set {paths[0]}=VALUE`" if paths else hint
            raise UsageError(f"unknown option (got {text_of(flag)}; {hint})")
