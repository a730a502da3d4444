"""Logs of a car: what is missing in a world, what it predicts, its unknowns, and tables of other loggers.

`map` is a JSON file that says what a log's columns mean (without it gripline's own), `track` a road or the two files of
its edges; `quiet` prints nothing.
"""

import json
import tempfile
from pathlib import Path

from . import _gripline
from .results import table_of
from .words import call, options, several


def diagnose(world, logs, *, map=None, track=None, case=None, out="out/diagnosis", held_out=(), plugin_folders=(),
             force=False, quiet=False):
    """Which effect is missing between a world and logs, as `gripline diagnose`: the contents of diagnosis.json."""
    words = [str(world), *several(logs)]
    words += options(map=map, track=several(track), case=case, out=out, held_out=several(held_out),
                     plugins=several(plugin_folders), force=force)
    call(_gripline.diagnose, words, quiet)
    return json.loads((Path(out) / "diagnosis.json").read_text(encoding="utf-8"))


def predict(world, log, *, map=None, track=None, horizon=(0.5, 1), every=0.2, slowest=None, fixed=False, out=None,
            samples=None, plugin_folders=(), quiet=False):
    """How far a world's model is off a log, as `gripline predict`: the table of errors by horizon [s] and model. `out`
    and `samples` name CSV files to keep it, and every prediction, in."""
    seconds = horizon if isinstance(horizon, str) or not hasattr(horizon, "__iter__") else ",".join(several(horizon))
    with tempfile.TemporaryDirectory(prefix="gripline_predict_") as scratch:
        file = Path(scratch) / "errors.csv" if out is None else Path(out)
        words = [str(world), str(log)]
        words += options(map=map, track=several(track), horizon=seconds, every=every, slowest=slowest, fixed=fixed,
                         out=file, samples=samples, plugins=several(plugin_folders))
        call(_gripline.predict, words, quiet)
        return table_of(file)


def fit(world, logs, *, map=None, track=None, out="fitted.json", fit=None, starts=200, seed=1, plugin_folders=(),
        quiet=False):
    """A world's unknowns from logs, as `gripline fit`: the file of the fitted world. `fit` names the groups or
    parameters to fit, all by default."""
    words = [str(world), *several(logs)]
    words += options(map=map, track=several(track), out=out, fit=",".join(several(fit)) or None, starts=starts,
                     seed=seed, plugins=several(plugin_folders))
    call(_gripline.fit, words, quiet)
    return Path(out)


def import_log(log, *, map=None, out=None, v_ref=None, quiet=False):
    """A logger's table in gripline's columns, as `gripline import`: the file of the log, by default LOG.gripline.csv in
    the current folder. `v_ref` is the car's typical speed [m/s], by default the log's."""
    file = Path(out) if out is not None else Path(Path(log).stem + ".gripline.csv")
    call(_gripline.import_log, [str(log), *options(map=map, out=file, v_ref=v_ref)], quiet)
    return file
