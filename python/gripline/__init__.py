"""gripline from Python: results as NumPy arrays, races step by step, estimators and controllers as Python classes.

The documentation is framework/doc/python.md.
"""

from pathlib import Path as _Path

from . import _gripline
from .plugins import Controller, Estimator, Param
from .results import Run, load_run, load_table
from .runs import ClaimFailed, Comparison, compare, diagnose, run
from .stepping import Race

__all__ = ["ClaimFailed", "Comparison", "Controller", "Estimator", "Param", "Race", "Run", "compare", "diagnose",
           "load_run", "load_table", "run"]

# Plugins, worlds and experiments are those of the tree that this package stands in.
for _folder in _Path(__file__).absolute().parents:
    if (_folder / "bin" / "gripline").exists() and (_folder / "lib" / "gripline").is_dir():
        _gripline.set_program(_gripline.__file__, str(_folder))
        break
