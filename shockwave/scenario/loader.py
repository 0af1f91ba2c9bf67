"""Loader of scenario files: a shock, a chain and settings, or a report of all errors."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from attrs import evolve

from shockwave import __version__
from shockwave.base.errors import (
    Fault,
    FileAccessError,
    InvalidValueError,
    PluginError,
    ScenarioError,
    ShockwaveError,
    Steps,
    UsageError,
    collect_faults,
    refuse,
)
from shockwave.base.quantity_fields import join, text_of
from shockwave.base.units import to_si
from shockwave.prediction.predictor import Predictor
from shockwave.registry.registry import blame, find, load
from shockwave.scenario.block_keys import (
    BLOCKS,
    CHAIN,
    RECORD,
    SCENARIO,
    VERSIONS,
    has_chain_blocks,
    keys_of,
    parameters_of,
    shock_keys,
)
from shockwave.scenario.sweep_block import document_at, points_to_try, varied_paths
from shockwave.scenario.sweep_block import read as read_sweep
from shockwave.scenario.uncertainty_block import read as read_spreads
from shockwave.scenario.value_conversion import Parser, convert, items, names_files, structure, values_of
from shockwave.scenario.yaml_document import Document
from shockwave.scene.chain import Chain
from shockwave.scene.force_limit import limit_faults
from shockwave.scene.scene import faults_of, uniform_of
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions

# Errors that are listed; the number of the others is stated.
_MOST_FAULTS = 100
_MOST_TRIED = 3000  # errors after which no further point of a sweep is tried: so many are not due to its values


def parts_of(document: Document, path: Path | None) -> dict[str, Any]:
    """Parts of the scenario that ``document`` describes; see `load_scenario` for the errors.

    For a sweep it is the first valid scene of `points_to_try`; if there is none, the reported errors are those of the
    first of them.
    """
    token = names_files.set(document.names_files)
    try:
        return _parts_of(document, path)
    finally:
        names_files.reset(token)


def _parts_of(document: Document, path: Path | None) -> dict[str, Any]:
    sweep = None
    varied: set[Steps] = set()
    errors = [*document.faults]
    if document.data.get("sweep") is not None:
        with collect_faults(errors, "sweep"):
            sweep = read_sweep(document.data)
        # not reported as missing
        varied = set() if sweep is not None else varied_paths(document.data["sweep"])
    first_faults: list[Fault] = []
    for number, index in enumerate(points_to_try(sweep), 1):
        point = document_at(document, sweep, index)
        parts, faults = _parts(point, document.data.get("uncertainty"), path)
        placed = [_place(point, fault) for fault in (*errors, *faults)]
        faults = [fault for fault in placed if fault.steps not in varied]
        if not faults:
            return {"path": path, "sweep": sweep, "document": point, **parts}
        first_faults = first_faults or faults
        if len(faults) * number > _MOST_TRIED:
            break
    raise _error(first_faults, document.name)


def _place(document: Document, fault: Fault) -> Fault:
    """``fault`` with its place in the document, which may have a diameter in place of a radius."""
    *block, last = fault.steps or ("",)
    if last == "radius" and fault.steps not in document.keys and (*block, "diameter") in document.keys:
        fault = evolve(fault, steps=(*block, "diameter"))
    return document.place(fault)


def _error(faults: list[Fault], name: str) -> ShockwaveError:
    """Error of the file ``name`` with all faults, in the order of the file and without repetition."""

    def order(fault: Fault) -> tuple[float, ...]:
        """Line, column and depth; faults in another file come last."""
        file, _, place = fault.location.partition(f"{name}:")
        return (*map(int, place.split(":")), len(fault.steps)) if place and not file else (float("inf"),)

    faults = sorted(dict.fromkeys(faults), key=order)
    exit_codes = {fault.exit_code for fault in faults}
    if len(faults) > _MOST_FAULTS:
        faults = [*faults[:_MOST_FAULTS], Fault((), f"and {len(faults) - _MOST_FAULTS} more errors", name)]
    if PluginError.exit_code in exit_codes:
        return PluginError(*faults)
    return next((cls for cls in (FileAccessError, UsageError) if exit_codes == {cls.exit_code}), ScenarioError)(*faults)


# ---------------------------------------------------------------- blocks


def _parts(document: Document, spreads: Any, path: Path | None) -> tuple[dict[str, Any], list[Fault]]:
    """Parts of the scenario in ``document``, each as far as possible, and all errors; ``spreads`` are a block of it."""
    folder = path.parent if path is not None else document.folder
    values, faults = values_of(
        document.data, SCENARIO, {**_PARSERS, "shock": partial(_shock, folder), "motion": partial(_motion, folder)}
    )
    parts: dict[str, Any] = {
        name: values.get(name) for name in ("shock", "impact", "motion", "chain", "limit", "published")
    }
    parts["name"] = values.get("name") or (path.stem if path is not None else document.name)
    parts["predictor"] = values.get("predict") or Predictor()
    parts["simulate"] = values.get("simulate") or SimulateOptions()
    with collect_faults(faults, "uncertainty"):
        parts["uncertainty"] = read_spreads(spreads, document.data)
    if "chain" in values:
        faults += limit_faults(parts["limit"], parts["chain"].end)
        faults += _combination_faults(parts, document.data)
    return parts, faults


def _combination_faults(parts: Mapping[str, Any], data: Mapping[str, Any]) -> list[Fault]:
    """Errors of a chain under its excitation, and of options; ``data`` is the content of the document."""
    chain, impact, options = parts["chain"], parts["impact"], parts["simulate"]
    other = impact or parts["motion"]
    faults = faults_of(chain, other)
    if options.integrator is not None and (other is not None or uniform_of(chain) is None):
        from shockwave.scene.feature_rules import integrator_refusal  # equal granules do not need it

        reason = integrator_refusal(options.integrator, chain)
        faults += [Fault("simulate.integrator", reason)] * bool(reason)
    if options.sensors:
        from shockwave.scene.sensors import sensor_faults  # most simulations have none

        faults += (fault.below("simulate") for fault in sensor_faults(options.sensors, chain, impact is not None))
    if chain.count is not None:
        last = chain.count + (impact is not None) + (chain.end is not None) - 2
        for index, contact in enumerate(data["simulate"]["contacts"] if options.contacts else ()):
            if to_si(contact, "") > last:  # it may be text
                problem = f"must be at most {last}, the last contact of this chain (got {contact})"
                faults.append(Fault(("simulate", "contacts", index), problem))
    elif "forces" in options.record and not options.contacts:
        faults.append(Fault("simulate.contacts", "must be given if record includes forces (got none)"))
    return faults


def _version(value: Any) -> int:
    if type(value) is not int or value not in VERSIONS:  # True and 1.0 are equal to 1
        newer = "; a newer shockwave may read it" if type(value) is int and value > VERSIONS[-1] else ""
        raise InvalidValueError(f"must be {join(VERSIONS)} for shockwave {__version__} (got {text_of(value)}{newer})")
    return value


def _requires(content: Any) -> list[str]:
    """Names of installed distributions."""
    from importlib.metadata import PackageNotFoundError, version

    def check_installed(name: str) -> str:
        try:
            version(name)
        except (PackageNotFoundError, ValueError):
            problem = f"must be an installed distribution (got {text_of(name)}; install it if you trust it)"
            raise InvalidValueError(problem) from None
        return name

    return items(convert(_KEYS["requires"], content) or (), check_installed)


def _chain(content: Any) -> Chain:
    parsers: Mapping[str, Parser] = {}
    if has_chain_blocks({"chain": content}):
        from shockwave.scenario import chain_blocks  # not needed for equal granules

        parsers = chain_blocks.PARSERS
    return Chain(**structure(content, CHAIN, parsers))


def _impact(content: Any) -> Any:
    from shockwave.scenario.chain_blocks import impact  # not needed for a shock

    return impact(content)


def _settings(cls: Any, block: str, content: Any) -> Any:
    """Instance of ``cls`` from a block; errors that the constructor finds in valid values are reported as well."""
    values, faults = values_of(content, BLOCKS[block])
    with collect_faults(faults):
        settings = cls(**values)
    refuse(faults)
    return settings


_KEYS = {key.name: key for key in SCENARIO}
#: Key of the document -> its parser.
_PARSERS: Mapping[str, Parser] = {
    "version": _version,
    "requires": _requires,
    "chain": _chain,
    "impact": _impact,
    "predict": partial(_settings, Predictor, "predict"),
    "simulate": partial(_settings, SimulateOptions, "simulate"),
}


# ---------------------------------------------------------------- shock


def _shock(folder: Path, content: Any) -> Shock:
    """The shock; it is made even if a key has an error, so that those of its profile and its times are reported too."""
    block = content if isinstance(content, dict) else {}
    cls: Any = None
    faults: list[Fault] = []
    parsers: dict[str, Parser] = {}
    with collect_faults(faults, "profile"):
        cls = load("profiles", block["profile"]) if isinstance(block.get("profile"), str) else None
    if cls is not None:
        content = {**block, "parameters": block.get("parameters")}
        parsers["parameters"] = partial(_parameters, folder, find("profiles", block["profile"]).name, cls, faults)
    values, others = values_of(content, shock_keys(cls), parsers)
    faults += others
    if "parameters" not in values:
        raise InvalidValueError(*faults)
    if {"rise_time", "duration_ratio"} <= values.keys():
        values.pop("duration", None)  # reported with the keys
    built: list[Fault] = []
    with collect_faults(built), blame("profiles", cls):
        shock = Shock(**values)
        if not faults:
            return shock
    built = [fault if fault.steps else fault.below(*_place_of_profile(fault)) for fault in built]
    # what is missing was reported with the keys
    raise InvalidValueError(*faults, *(fault for fault in built if not faults or fault.steps[0] in values))


def _place_of_profile(fault: Fault) -> Steps:
    return ("parameters", "file") if fault.exit_code == FileAccessError.exit_code else ("profile",)


def _parameters(folder: Path, profile: str, cls: Any, others: list[Fault], content: Any) -> dict[str, Any]:
    """Parameters of the profile; errors of valid values that it does not take are added to ``others``."""
    values = structure(content, parameters_of(profile, cls))
    if profile == RECORD and "file" in values:
        values["file"] = _file(folder, values["file"], "file")
    elif profile == RECORD:
        for key in values.keys() - {key.name for key in keys_of(cls)}:
            problem = f"must be left out without file (got {text_of(values.pop(key))})"
            others.append(Fault(("parameters", key), problem, at_key=True))
    return values


def _motion(folder: Path, content: Any) -> Any:
    from shockwave.scenario.chain_blocks import motion  # not needed for a shock

    return motion(partial(_file, folder), content)


def _file(folder: Path, name: str, key: str) -> Path:
    """File ``name`` in the scenario's folder or below it."""
    file = folder / name
    # an absolute name may lead elsewhere, too; Path.resolve raises an error for a link to itself
    if name.strip() and Path(os.path.realpath(file)).is_relative_to(os.path.realpath(folder)):
        return file
    problem = f"must be a file in the scenario's folder or below it (got {text_of(name)}; copy it there)"
    raise InvalidValueError.of(key, problem)
