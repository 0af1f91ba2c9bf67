"""The server of the explorer: a page on loopback on which sliders change a scenario, and its answers follow."""

from __future__ import annotations

import logging
import socket
import threading
import webbrowser
from contextlib import suppress
from hmac import compare_digest
from pathlib import Path
from secrets import token_urlsafe
from typing import Any

import flask
from flask.typing import ResponseReturnValue
from shockwave import ShockwaveError, UsageError
from shockwave.base.errors import message_of
from shockwave.base.files import parse_json
from shockwave.base.text import html_of
from shockwave.cli.parser import parse_command
from shockwave.cli.scenario_files import load_with_changes
from shockwave.report import page as report
from werkzeug.exceptions import HTTPException
from werkzeug.serving import make_server

from .answer import parts_of
from .scene import PRESETS, edit_text, load_text, scenario_text, text_of_file, titles

#: The only address that the explorer listens on.
LOOPBACK = "127.0.0.1"
# Scenario at the start.
_FIRST = "wall"
# Largest request [bytes], above the longest scenario.
_MOST_BYTES = 2**21
# The page executes its own script only, and loads nothing from elsewhere.
_POLICY = "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"


def explore(arguments: list[str]) -> int:
    """Run the command: answer the requests of the page until an interrupt.

    Raises
    ------
    ShockwaveError
        If the scenario is not valid, or the port is in use.
    """
    options = parse_command("explore", ["explore", *arguments])
    first = scenario_text(load_with_changes(options.file or str(PRESETS[_FIRST]), options))
    load_text(first)  # a file that the page cannot show ends here
    serve(first, options.port, not options.no_browser)
    return 0


def serve(first: str, port: int, browser: bool) -> None:
    """Serve the page on loopback until an interrupt; port 0 is a free one."""
    try:
        listening = socket.create_server((LOOPBACK, port))
    except OSError as error:
        got = f"got {port}: {error.strerror or message_of(error)}; choose another, or 0 for any"
        raise UsageError(f"--port: must be a free port ({got})") from None
    port = listening.getsockname()[1]
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    token = token_urlsafe(16)
    server = make_server(LOOPBACK, port, make_application(first, port, token), threaded=True, fd=listening.fileno())
    # errors of connections that break off, also by the end of the server; Flask reports all others
    server.handle_error = lambda *_: None  # type: ignore[method-assign]
    address = f"http://{LOOPBACK}:{port}/{token}/"
    with suppress(KeyboardInterrupt):
        print(f"{address} (Ctrl-C ends)", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        server.serve_forever()


def make_application(first: str, port: int, token: str) -> flask.Flask:
    """The web application at ``port``, whose addresses begin with ``token``; it begins with the scenario ``first``."""
    app = flask.Flask("shockwave", static_folder=None)
    app.config.update(MAX_CONTENT_LENGTH=_MOST_BYTES)
    folder = Path(__file__).parent
    examples = {name: text_of_file(file) for name, file in PRESETS.items()}
    hosts = [f"{name}:{port}" for name in (LOOPBACK, "localhost")]

    @app.before_request
    def check_sender() -> None:
        """Refuse other users of the computer, who do not know the token, and pages of other sites."""
        request = flask.request
        host, origin = request.environ.get("HTTP_HOST", ""), request.headers.get("Origin")
        if (host if ":" in host else f"{host}:80") not in hosts:
            flask.abort(403, f"The request must be sent to {hosts[0]}.")
        if origin != f"http://{host}" and (origin is not None or request.method != "GET"):
            flask.abort(403, "The request must be sent by the page of the explorer.")
        if not compare_digest(request.path.split("/")[1].encode(), token.encode()):
            flask.abort(403, "This is not the address of the running explorer, which the command prints.")

    @app.get(f"/{token}/")
    def page() -> str:
        return html_of(folder / "page.html.jinja", first=first, titles=titles())

    @app.get(f"/{token}/explorer.<any(js, css):kind>")
    def asset(kind: str) -> ResponseReturnValue:
        return flask.send_file(folder / f"explorer.{kind}")

    @app.post(f"/{token}/answer")
    def answer() -> dict[str, str]:
        preset, text, edits = _read_fields(preset=str, text=str, edits=dict)
        text = examples[preset] if preset in examples else edit_text(text, edits)
        shown = next((name for name, example in examples.items() if example == text), "")
        return {"text": text, "preset": shown, **parts_of(text)}

    @app.post(f"/{token}/report")
    def report_page() -> str:
        (text,) = _read_fields(text=str)
        return report(load_text(text))

    @app.errorhandler(Exception)
    def report_error(error: Exception) -> ResponseReturnValue:
        """The errors of the scenario with their places, or another message as plain text; the server goes on."""
        text, status = f"internal error: {message_of(error)} (please report it)", 500
        if isinstance(error, ShockwaveError):
            return {"faults": [fault.to_dict() for fault in error.faults]}, 400
        if isinstance(error, RecursionError):
            text, status = str(error), 400
        elif isinstance(error, HTTPException):
            text, status = error.description or error.name, error.code or status
        return flask.Response(text, status, mimetype="text/plain")

    @app.after_request
    def protect(response: flask.Response) -> flask.Response:
        response.headers["Content-Security-Policy"] = _POLICY
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["Referrer-Policy"] = "same-origin"  # the address holds the token
        return response

    return app


def _read_fields(**kinds: type) -> list[Any]:
    """The named fields of the JSON object that the page sends; an empty value for one that is left out."""
    if not flask.request.is_json:
        flask.abort(415, "The request must be JSON.")
    request = parse_json(flask.request.get_data(), "request")
    values = [request.get(name, kind()) if isinstance(request, dict) else None for name, kind in kinds.items()]
    if not all(map(isinstance, values, kinds.values())):
        flask.abort(400, "The request must be a JSON object in the form that the page sends.")
    return values
