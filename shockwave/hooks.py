"""Names for modules of hooks: `Entry` and `hookimpl`.

A module of hooks is imported when plugins are listed; this module imports nothing slow.
"""

from shockwave.registry.built_ins import Entry as Entry
from shockwave.registry.hook_specifications import hookimpl as hookimpl
