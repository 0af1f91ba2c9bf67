"""The explorer: a page on loopback on which sliders change a scenario, and its answers follow."""

from __future__ import annotations

import io
import logging
import socket
import threading
import webbrowser
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import frozen
from markupsafe import Markup

from shockwave import OWN_DISTRIBUTION, pictures
from shockwave.chain.layout import Layout
from shockwave.errors import InvalidValueError, ShockwaveError, UsageError, message_of
from shockwave.limit import verdict_facts
from shockwave.measurement.chain_result import ChainResult
from shockwave.measurement.chain_text import chain_answer, chain_lead
from shockwave.measurement.result_text import lead_text, result_answer
from shockwave.page.drawings import drawings
from shockwave.page.explorer_charts import APPLIED, LIMIT, PREDICTED, SIMULATED, Series, beads, chart, field_map
from shockwave.page.explorer_scene import controls, edited, loaded, presets, text_of_file
from shockwave.page.render import written
from shockwave.page.results import Findings, findings
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.outcome_text import estimate_figures, outcome_limits
from shockwave.text import html_of

if TYPE_CHECKING:
    from flask import Flask
    from flask.typing import ResponseReturnValue

#: The only address that the explorer listens on.
LOOPBACK = "127.0.0.1"
# Scenario at the start.
_FIRST = "chains/wall"
# Largest request [bytes], above the largest scenario.
_MOST_BYTES = 2**22
# The page executes its own script only, and loads nothing from elsewhere.
_POLICY = "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'"
_TEMPLATES = {name: Path(__file__).with_name(f"explorer_{name}.html.jinja") for name in ("page", "parts")}
# matplotlib and the caches of the package are used by one request at a time.
_LOCK = threading.Lock()


@frozen
class Figure:
    """A picture of the page; ``source`` is the name of the picture of the package that is exported, if any."""

    title: str
    picture: Markup
    caption: str = ""
    source: str = ""


# ---------------------------------------------------------------- answers


@lru_cache(maxsize=8)
def answered(text: str) -> tuple[Findings, Outcome | None, str]:
    """Results of the scenario in ``text``, its prediction, and the reason why there is none.

    Raises
    ------
    ShockwaveError
        As `loaded`.
    """
    scenario = loaded(text)
    found = findings(scenario)
    if found.predicted is not None:
        return found, found.predicted, ""
    try:
        return found, scenario.predictor.predict(scenario.excitation, scenario.chain), ""
    except InvalidValueError as error:
        return found, None, "; ".join(fault.problem for fault in error.faults)
    except ShockwaveError as error:
        return found, None, str(error)


def parts_of(text: str, *names: str) -> dict[str, str]:
    """The parts ``names`` of the page for the scenario in ``text``, as HTML: controls, headline, estimate, figures."""
    found, predicted, reason = answered(text)
    filters = (chain_answer, chain_lead, estimate_figures, lead_text, outcome_limits, result_answer, verdict_facts)
    values = {
        "found": found,
        "predicted": predicted,
        "reason": reason,
        "groups": controls(found.scenario.document) if found.scenario.document and "controls" in names else {},
        "figures": list(figures(found, predicted)) if "figures" in names else [],
        "exported": set(drawings(found)),
    }
    return {name: html_of(_TEMPLATES["parts"], filters, part=name, **values) for name in names}


def figures(found: Findings, predicted: Outcome | None) -> Iterator[Figure]:
    """The charts of a scene and the animation of its beads."""
    shock = found.scenario.shock
    kept: Any = None if found.simulated is None else found.simulated.recording
    if kept is not None and kept.displacements is not None:
        chain = found.scenario.chain
        if found.is_beyond and chain.count is not None:
            radii = Layout.of(chain, found.scenario.excitation).radii
        else:
            radii = np.full(kept.displacements.shape[1], chain.radius)
        walled = kept.wall_force is not None
        picture, caption = beads(radii, kept.times, kept.displacements, kept.velocities, walled)
        yield Figure("Beads", picture, caption)
    if found.scenario.impact is None:
        times = np.linspace(0, shock.duration, 600)
        times = np.union1d(times, shock.rise_time * np.asarray(shock.profile.breakpoints, dtype=float))
        force = shock.peak_force * shock.profile.force(times / shock.rise_time)
        pulse = [Series(times, force, kind="area")]
        yield Figure("Pulse", chart(pulse, ("time", "s"), ("force", "N"), shock.duration), source="pulse")
    if kept is not None:
        contacts = "contact, from the struck end"
        source = "chain-map" if found.is_beyond else "map"
        yield Figure("Space-time map", field_map(kept.times, kept.contacts, kept.forces, contacts), source=source)
    if kept is not None and kept.wall_force is not None:
        yield _wall(found, predicted, kept)
    yield from _waves(found, predicted)
    if kept is not None:
        yield _contacts(found, kept)


def _wall(found: Findings, predicted: Any, kept: Any) -> Figure:
    result: Any = found.simulated
    end = float(kept.times[-1])
    lines = [Series(kept.times, kept.wall_force, "simulated", colour=SIMULATED)]
    if predicted is not None and predicted.transmitted is not None:
        ends = predicted.transmitted.low, predicted.transmitted.high
        lines.insert(0, Series((0.0, end), ends, "estimate", "band", PREDICTED))
    if found.scenario.limit is not None:
        lines.append(Series((0.0, end), [found.scenario.limit.force] * 2, "limit", "dashed", LIMIT))
    impulse = f"The impulse on the wall is {result.transmitted.impulse:.3g} N s."
    picture = chart(lines, ("time", "s"), ("force on the wall", "N"), end)
    return Figure("Force on the wall", picture, impulse, "wall")


def _waves(found: Findings, predicted: Any) -> Iterator[Figure]:
    """Peak forces of the waves of a train, or of the contacts along a chain."""
    result = found.simulated
    simulated = [] if result is None else [wave.peak_force for wave in result.waves]
    foreseen = [wave.peak_force for wave in predicted.waves] if predicted is not None else []
    count = max(len(simulated), len(foreseen))
    if simulated or count > 1:
        series = []
        if found.scenario.impact is None:
            series.append(Series((0.5, count + 0.5), [found.scenario.shock.peak_force] * 2, "shock", "dashed", APPLIED))
        if predicted is not None and predicted.estimate is not None:
            ends = predicted.estimate.low, predicted.estimate.high
            series.append(Series((0.7, 1.3), ends, "estimate", "band", PREDICTED))
        for forces, label, kind, colour in (
            (foreseen, predicted.model if predicted is not None else "", "dots", PREDICTED),
            (simulated, "simulated", "squares", SIMULATED),
        ):
            if forces:
                series.append(Series(np.arange(1, len(forces) + 1), forces, label, kind, colour))  # type: ignore[arg-type]
        picture = chart(series, ("wave", ""), ("peak force", "N"), count + 0.5, whole=True)
        yield Figure("Wave train", picture, source="train")
    if isinstance(result, ChainResult):
        contacts = [peak.contact for peak in result.contacts]
        series = [Series(contacts, [peak.peak_force for peak in result.contacts], colour=SIMULATED)]
        picture = chart(series, ("contact, from the struck end", ""), ("greatest force", "N"), max(contacts[-1], 1))
        yield Figure("Greatest force along the chain", picture, source="peaks")


def _contacts(found: Findings, kept: Any) -> Figure:
    """The wave at some contacts, which lie at equal distances."""
    last = len(kept.contacts) - 1
    colours = PREDICTED, SIMULATED, "#009E73", LIMIT
    chosen = sorted({0, last // 4, last // 2, last})
    lines = [
        Series(kept.times, kept.forces[:, column], f"contact {kept.contacts[column]}", colour=colour)
        for column, colour in zip(chosen, colours, strict=False)
    ]
    source = "" if found.is_beyond else "forces"
    picture = chart(lines, ("time", "s"), ("contact force", "N"), float(kept.times[-1]))
    return Figure("Contact forces", picture, source=source)


def exported(text: str, source: str, kind: str) -> bytes:
    """A picture of the package as SVG or PNG, or the report on the scenario as HTML.

    Raises
    ------
    ShockwaveError
        As `loaded`; or if the scene does not have the picture.
    """
    found = answered(text)[0]
    if kind == "html":
        return written(found).encode()
    draw = drawings(found).get(source)
    if draw is None or kind not in ("svg", "png"):
        raise InvalidValueError.of("picture", f"must be one of {', '.join(drawings(found))}, as svg or png")
    drawn, (ax,) = pictures.figure()
    draw(ax)
    if kind == "svg":
        return ('<?xml version="1.0" encoding="utf-8"?>\n' + pictures.svg(drawn)).encode()
    picture = io.BytesIO()
    drawn.savefig(picture, format="png", dpi=300, metadata={"Software": None})
    return picture.getvalue()


# ---------------------------------------------------------------- server


def application(first: str) -> Flask:
    """The web application, which begins with the scenario in the text ``first``.

    Raises
    ------
    UsageError
        If Flask or matplotlib is not installed.
    """
    try:
        import flask
    except ImportError as missing:
        remedy = f"pip install '{OWN_DISTRIBUTION}[explore]'"
        raise UsageError(f"Flask must be installed (got {missing}; {remedy})") from missing
    pictures.figure()  # fails early without matplotlib
    app = flask.Flask("shockwave", static_folder=None)
    # a page from elsewhere that names this address otherwise cannot read the answers
    app.config.update(TRUSTED_HOSTS=[LOOPBACK, "localhost"], MAX_CONTENT_LENGTH=_MOST_BYTES)
    files = presets()

    @app.get("/")
    def page() -> str:
        return html_of(_TEMPLATES["page"], first=first, presets=list(files))

    @app.get("/explorer.<any(js, css):kind>")
    def own_file(kind: str) -> ResponseReturnValue:
        return flask.send_file(Path(__file__).with_name(f"explorer.{kind}"))

    @app.post("/answer")
    def answer() -> dict[str, str]:
        asked = flask.request.get_json()
        with _LOCK:
            try:
                preset = asked.get("preset")
                text = text_of_file(files[preset]) if preset in files else edited(asked["text"], asked.get("edits", {}))
                names = ("controls",) if asked.get("controls") else ()
                return {"text": text, **parts_of(text, *names, "headline", "estimate", "figures")}
            except ShockwaveError as error:
                return {"fault": str(error)}
            except Exception as error:  # the page goes on
                return {"fault": f"internal error: {message_of(error)} (please report it)"}

    @app.post("/export")
    def export() -> ResponseReturnValue:
        asked = flask.request.get_json()
        with _LOCK:
            try:
                return exported(asked["text"], asked["source"], asked["kind"])
            except ShockwaveError as error:
                return str(error), 400

    @app.after_request
    def protected(response: flask.Response) -> flask.Response:
        response.headers["Content-Security-Policy"] = _POLICY
        response.headers["X-Content-Type-Options"] = "nosniff"
        return response

    return app


def serve(file: str | None, port: int, browser: bool) -> None:
    """Answer the requests of the page until an interrupt.

    Parameters
    ----------
    file : str or None
        Scenario to begin with.
    port : int
        Port on loopback; 0 for a free one.
    browser : bool
        Whether to open the page in the browser.

    Raises
    ------
    ShockwaveError
        If an extra is not installed, the scenario is not valid, or the port is in use.
    """
    first = text_of_file(file or presets()[_FIRST])
    app = application(first)
    from werkzeug.serving import make_server

    try:
        own = socket.create_server((LOOPBACK, port))
    except OSError as error:
        got = f"got {port}: {error.strerror or message_of(error)}; choose another, or 0 for any"
        raise UsageError(f"--port: must be a free port ({got})") from None
    address = f"http://{LOOPBACK}:{own.getsockname()[1]}/"
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    server = make_server(LOOPBACK, own.getsockname()[1], app, threaded=True, fd=own.fileno())
    with suppress(KeyboardInterrupt):
        print(f"{address} (Ctrl-C ends)", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        server.serve_forever()
