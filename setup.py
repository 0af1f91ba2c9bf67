"""The compiled part of shockwave: one C file, left out where it cannot be built. All else stands in pyproject.toml."""

from setuptools import Extension, setup

setup(
    ext_modules=[
        Extension(
            "shockwave.simulation._compiled",
            ["shockwave/simulation/_compiled.c"],
            # Without a C compiler NumPy serves, with the same answers.
            optional=True,
            py_limited_api=True,
            define_macros=[("Py_LIMITED_API", "0x030B0000")],
            # Products and sums stay apart: results are the same on every processor, and the same as NumPy's.
            extra_compile_args=["-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"],
        )
    ],
    options={"bdist_wheel": {"py_limited_api": "cp311"}},
)
