"""The pages on writing a plugin, followed to the letter: outside the source tree, in an environment of their own."""

import os
import subprocess
import sys
import sysconfig
import venv
from importlib import metadata
from pathlib import Path

import pytest

from support.pages import DOCS, agree, blocks_of

# pip builds each plugin; the commands of the pages also run in tests/claims/test_docs.py
pytestmark = pytest.mark.slow


@pytest.fixture
def programs(tmp_path: Path) -> Path:
    """The folder of programs of an environment that has what this one has, apart from plugins."""
    folder = tmp_path / "environment"
    venv.create(folder)
    scripts = {"base": str(folder), "platbase": str(folder)}
    place = Path(sysconfig.get_path("purelib", "venv", vars=scripts))
    plugins = [point.dist.name for point in metadata.entry_points(group="shockwave") if point.dist is not None]
    hidden = tuple(name.replace("-", "_") for name in plugins)
    for installed in {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}:
        for item in Path(installed).iterdir():
            if not item.name.removeprefix("__editable__.").startswith(hidden):
                (place / item.name).symlink_to(item)
    found = Path(sysconfig.get_path("scripts", "venv", vars=scripts))
    program = found / "shockwave"
    program.write_text(f"#!{found / 'python'}\nimport sys\nfrom shockwave.cli import main\nsys.exit(main())\n")
    program.chmod(0o755)
    return found


@pytest.mark.skipif(sys.platform == "win32", reason="the commands are those of a POSIX shell")
@pytest.mark.parametrize("page", ["write-a-profile", "write-an-integrator", "plugins"])
def test_a_plugin_made_by_the_page_alone_works(page: str, programs: Path, tmp_path: Path) -> None:
    kept = ("HOME", "LANG", "PIP_", "XDG_", "SSL_", "http", "HTTP", "no_proxy", "TMPDIR")
    names = {name: value for name, value in os.environ.items() if name.startswith(kept)}
    names["PATH"] = f"{programs}:{os.environ['PATH']}"

    def ran(*command: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(command, cwd=tmp_path, env=names, text=True, capture_output=True, check=False)

    session: list[str] = []
    for block in blocks_of(DOCS / f"{page}.md"):
        if "file" in block.directives:
            file = tmp_path / block.directives["file"]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.text, encoding="utf-8")
        elif block.language == "pycon":
            session.append(block.text)
        for command, shown in block.commands if block.language == "console" else ():
            done = ran("sh", "-c", command)
            told = f"$ {command}\n{done.stdout}{done.stderr}"
            if command.startswith("python -m"):  # of pip, and of pytest, it counts that they succeed
                assert done.returncode == 0, told
            if not command.startswith(("python -m pip", "echo")):
                assert agree(shown, done.stdout + done.stderr), told
    (tmp_path / "session.txt").write_text("\n".join(session), encoding="utf-8")
    program = "import doctest, sys; sys.exit(doctest.testfile('session.txt', module_relative=False).failed)"
    done = ran("python", "-c", program)
    assert done.returncode == 0, done.stdout + done.stderr
