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
from shockwave.chain.yielding import BEYOND
from shockwave.errors import InvalidValueError, ShockwaveError, UsageError, message_of
from shockwave.limit import verdict_facts
from shockwave.measurement.chain_result import ChainResult
from shockwave.measurement.chain_text import chain_answer, chain_lead
from shockwave.measurement.result_text import lead_text, result_answer
from shockwave.page.drawings import drawings
from shockwave.page.explorer_charts import Series, beads, chart, field_map
from shockwave.page.explorer_scene import controls, edited, loaded, presets, text_of_file
from shockwave.page.render import written
from shockwave.page.results import Findings, findings
from shockwave.pictures.drawing import BLACK, BLUE, GREEN, GREY, VERMILION
from shockwave.prediction.outcome_text import estimate_figures, outcome_limits, without_advice
from shockwave.text import html_of, si

if TYPE_CHECKING:
    from flask import Flask
    from flask.typing import ResponseReturnValue

#: The only address that the explorer listens on.
LOOPBACK = "127.0.0.1"
# Scenario at the start.
_FIRST = "chains/wall"
# Largest request [bytes], above the longest scenario.
_MOST_BYTES = 2**21
# The page executes its own script only, and loads nothing from elsewhere.
_POLICY = "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
_TEMPLATES = {name: Path(__file__).with_name(f"explorer_{name}.html.jinja") for name in ("page", "parts")}
_TIME, _CONTACT = ("time", "s"), ("contact, from the struck end", "")
# Colours of histories, and so their number.
_COLOURS = (BLUE, VERMILION, GREEN, BLACK)
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
def answered(text: str) -> Findings:
    """Results of the scenario in ``text``.

    Raises
    ------
    ShockwaveError
        As `loaded`.
    """
    return findings(loaded(text))


def limits_of(found: Findings) -> list[str]:
    """Caveats about the results: that of yield first, which applies to all of them, then failures, then the others."""
    others = outcome_limits(found.predicted) if found.predicted else []
    if found.simulated is not None:
        others = [without_advice(limit) for limit in others] + [*found.simulated.wave_warnings]
    return sorted(dict.fromkeys([*found.failures, *others]), key=lambda limit: not limit.startswith(BEYOND))


def parts_of(text: str, *names: str) -> dict[str, str]:
    """The parts ``names`` of the page for the scenario in ``text``, as HTML: controls, headline, estimate, figures."""
    found = answered(text)
    predicted = found.predicted
    reason = found.reason or (predicted and predicted.no_estimate) or ""
    filters = chain_answer, chain_lead, estimate_figures, lead_text, result_answer, si, verdict_facts
    values = {
        "found": found,
        "predicted": predicted,
        "reason": without_advice(reason) if found.simulated else reason,
        "limits": limits_of(found),
        "groups": controls(found.scenario) if "controls" in names else {},
        "figures": list(figures(found)) if "figures" in names else [],
        "exported": set(drawings(found)),
    }
    return {name: html_of(_TEMPLATES["parts"], filters, part=name, **values) for name in names}


def figures(found: Findings) -> Iterator[Figure]:
    """The charts of a scene and the animation of its beads."""
    chain, shock, result = found.scenario.chain, found.scenario.shock, found.simulated
    predicted = found.predicted
    kept: Any = None if result is None else result.recording
    end = 0.0 if kept is None else float(kept.times[-1])
    if kept is not None and kept.displacements is not None:
        radii = np.full(kept.displacements.shape[1], chain.radius)
        if found.is_beyond and chain.count is not None:
            radii = Layout.of(chain, found.scenario.excitation).radii
        walled = kept.wall_force is not None
        yield Figure("Beads", *beads(radii, kept.times, kept.displacements, kept.velocities, walled))
    if found.scenario.impact is None:
        times = np.linspace(0, shock.duration, 600)
        times = np.union1d(times, shock.rise_time * np.asarray(shock.profile.breakpoints, dtype=float))
        pulse = Series(times, shock.peak_force * shock.profile.force(times / shock.rise_time), kind="area")
        yield Figure("Pulse", chart([pulse], _TIME, ("force", "N"), shock.duration), source="pulse")
    if kept is not None:
        source = "chain-map" if found.is_beyond else "map"
        yield Figure("Space-time map", field_map(kept.times, kept.contacts, kept.forces, _CONTACT[0]), source=source)
        if kept.wall_force is not None:
            lines = [Series(kept.times, kept.wall_force, "simulated", colour=VERMILION)]
            if predicted is not None and (wall := predicted.transmitted) is not None:
                lines.insert(0, Series((0.0, end), (wall.low, wall.high), "estimate", "band"))
            if (limit := found.scenario.limit) is not None:
                lines.append(Series((0.0, end), (limit.force, limit.force), "limit", "dashed", BLACK))
            yield Figure("Force on the wall", chart(lines, _TIME, ("force on the wall", "N"), end), source="wall")
    if isinstance(result, ChainResult):
        contacts = [peak.contact for peak in result.contacts]
        peaks = Series(contacts, [peak.peak_force for peak in result.contacts], colour=VERMILION)
        picture = chart([peaks], _CONTACT, ("greatest force", "N"), max(contacts[-1], 1))
        yield Figure("Greatest force along the chain", picture, source="peaks")
    elif result is not None and predicted is not None:
        yield Figure("Wave train", _train(predicted, result), source="train")
    if kept is not None:
        chosen = np.unique(np.linspace(0, len(kept.contacts) - 1, len(_COLOURS)).astype(int))
        lines = [
            Series(kept.times, kept.forces[:, column], f"contact {kept.contacts[column]}", colour=colour)
            for column, colour in zip(chosen, _COLOURS, strict=False)
        ]
        yield Figure("Contact forces", chart(lines, _TIME, ("contact force", "N"), end), source="forces")


def _train(predicted: Any, result: Any) -> Markup:
    """Peak forces of the waves, predicted and simulated."""
    ends = 0.5, max(len(predicted.waves), len(result.waves)) + 0.5
    series = [Series(ends, [result.shock.peak_force] * 2, "shock", "dashed", GREY)]
    if (found := predicted.estimate) is not None:
        series.append(Series((0.7, 1.3), (found.low, found.high), "estimate", "band"))
    for waves, *look in ((predicted.waves, predicted.model, "dots"), (result.waves, "simulated", "squares", VERMILION)):
        series.append(Series(np.arange(1, len(waves) + 1), [wave.peak_force for wave in waves], *look))
    return chart(series, ("wave", ""), ("peak force", "N"), ends[1], whole=True)


def exported(text: str, source: str, kind: str) -> bytes:
    """A picture of the package as SVG or PNG, or the report on the scenario as HTML.

    Raises
    ------
    ShockwaveError
        As `loaded`; or if the scene does not have the picture.
    """
    found = answered(text)
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

    def asked(**kinds: type) -> list[Any]:
        given = flask.request.get_json()
        values = [given.get(name, kind()) if isinstance(given, dict) else None for name, kind in kinds.items()]
        if not all(map(isinstance, values, kinds.values())):
            flask.abort(400, "must be a JSON object that the page sends")
        return values

    @app.get("/")
    def page() -> str:
        return html_of(_TEMPLATES["page"], first=first, presets=list(files))

    @app.get("/explorer.<any(js, css):kind>")
    def own_file(kind: str) -> ResponseReturnValue:
        return flask.send_file(Path(__file__).with_name(f"explorer.{kind}"))

    @app.post("/answer")
    def answer() -> dict[str, str]:
        preset, text, edits, controls = asked(preset=str, text=str, edits=dict, controls=bool)
        with _LOCK:
            try:
                text = text_of_file(files[preset]) if preset in files else edited(text, edits)
                names = ("controls",) if controls else ()
                return {"text": text, **parts_of(text, *names, "headline", "estimate", "figures")}
            except ShockwaveError as error:
                return {"fault": str(error)}
            except Exception as error:  # the page goes on
                return {"fault": f"internal error: {message_of(error)} (please report it)"}

    @app.post("/export")
    def export() -> ResponseReturnValue:
        wanted = asked(text=str, source=str, kind=str)
        with _LOCK:
            try:
                return exported(*wanted)
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
    loaded(first)  # a file that the page cannot show ends here
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
    # errors of connections that break off, also by the end of the server; Flask reports all others
    server.handle_error = lambda *_: None  # type: ignore[method-assign]
    with suppress(KeyboardInterrupt):
        print(f"{address} (Ctrl-C ends)", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        server.serve_forever()
