"""gripline from Python: results as NumPy arrays, races step by step, estimators and controllers as Python classes.

The documentation is framework/doc/python.md.
"""

import platform as _platform
import sys as _sys
from importlib import import_module as _import_module
from pathlib import Path as _Path

try:
    for _name in ("numpy", "gripline._gripline"):
        _import_module(_name)
except ImportError as _error:
    _built = ", ".join(sorted(file.name for file in _Path(__file__).parent.glob("_gripline*.so"))) or "no _gripline*.so"
    raise ImportError(
        f"gripline runs in the Python that it was built for ({_built} beside its sources), with NumPy: on Debian "
        f"/usr/bin/python3 with python3-numpy. This is Python {_platform.python_version()}, {_sys.executable}: {_error}"
    ) from _error

from . import _gripline
from .logs import diagnose, fit, import_log, predict
from .plugins import Controller, Estimator, Param
from .results import Run, load_run, load_table
from .runs import ClaimFailed, Comparison, compare, run
from .stepping import Race

__all__ = ["ClaimFailed", "Comparison", "Controller", "Estimator", "Param", "Race", "Run", "compare", "diagnose", "fit",
           "import_log", "load_run", "load_table", "predict", "run"]

# Plugins, worlds and experiments are those of the tree that this package stands in.
for _folder in _Path(__file__).absolute().parents:
    if (_folder / "bin" / "gripline").exists() and (_folder / "lib" / "gripline").is_dir():
        _gripline.set_program(_gripline.__file__, str(_folder))
        break
