"""Environment of worker processes: one thread each, because there is a worker for each core.

The server of the workers loads this module first; the libraries of linear algebra read the variables when NumPy is
loaded.
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
