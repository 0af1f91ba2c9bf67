"""What pyproject.toml cannot state: C files, left out where they cannot be built, and README.md with absolute links."""

import os
import re
import sysconfig
import tomllib
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.bdist_wheel import bdist_wheel


class BdistWheel(bdist_wheel):
    """A wheel that is tagged for a platform only if a C file was compiled."""

    def run(self):
        self.run_command("build_ext")
        if not any(map(os.path.exists, self.get_finalized_command("build_ext").get_outputs())):
            self.distribution.ext_modules = None
            self.root_is_pure = True
        super().run()


def long_description() -> str:
    """README.md for a package index: its relative links lead to the files of this version in the repository."""
    project = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["project"]

    def absolute(link: re.Match[str]) -> str:
        view = "raw" if link[1].endswith((".svg", ".png")) else "blob"
        return f"]({project['urls']['Repository']}/{view}/v{project['version']}/{link[1]})"

    return re.sub(r"\]\((?!\w+:|#)([^)]+)\)", absolute, Path("README.md").read_text(encoding="utf-8"))


# Without a C compiler, the NumPy code gives the same results. It is also used where the files cannot be compiled yet:
# MSVC lacks vector types, and the limited API does not support free-threaded Python.
COMPILES = not (sysconfig.get_platform().startswith("win") or sysconfig.get_config_var("Py_GIL_DISABLED"))

EXTENSIONS = [
    Extension(
        f"shockwave.{name}",
        [f"shockwave/{name.replace('.', '/')}.c"],
        depends=sorted(map(str, Path("shockwave/engine").glob("*.h"))),
        optional=True,
        py_limited_api=True,
        define_macros=[("Py_LIMITED_API", "0x030B0000")],
        # Products and sums stay apart: results are the same on every processor, and the same as NumPy's.
        extra_compile_args=["-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"],
        libraries=["m"],
    )
    for name in ("engine._lanes", "engine._chains")
]

setup(
    long_description=long_description(),
    long_description_content_type="text/markdown",
    cmdclass={"bdist_wheel": BdistWheel},
    ext_modules=EXTENSIONS if COMPILES else [],
    options={"bdist_wheel": {"py_limited_api": "cp311"}} if COMPILES else {},
)
