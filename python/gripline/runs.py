"""Experiments in this process, so that they know plugins that are Python classes."""

import csv
import json
from dataclasses import dataclass
from pathlib import Path

from . import _gripline
from .plugins import offer
from .results import load_run, load_table
from .words import assignments, call, options, several


class ClaimFailed(AssertionError):
    """A claim of the experiment does not hold."""


def _words(experiment, out, changes, plugin_folders, force):
    return [str(experiment), *options(out=out, set=assignments(changes), plugins=several(plugin_folders), force=force)]


def _out(out, experiment):
    return Path(out) if out is not None else Path("out") / Path(str(experiment)).stem


def _why_broken(out, stacks, seed=None):
    """What the first of these runs that broke says (of all stacks, all seeds where none are named); "" if none did."""
    if not (out / "runs.csv").is_file():
        return ""
    with open(out / "runs.csv", newline="", encoding="utf-8") as lines:
        runs = list(csv.DictReader(lines))
    for row in runs:
        stack, number, status = (row.get(name) for name in ("stack", "seed", "status"))
        asked = (not stacks or stack in stacks) and (seed is None or str(seed) == number)
        if asked and status in ("error", "plugin_error"):
            file = out / stack / number / "summary.json"
            message = json.loads(file.read_text(encoding="utf-8"))["message"] if file.is_file() else "left no result"
            return f"a run broke: {stack}, seed {number}: {status}: {message}"
    return ""


@dataclass
class Comparison:
    """What a comparison left in its folder."""

    out: Path
    held: bool

    @property
    def table(self):
        return load_table(self.out)

    @property
    def runs(self):
        return load_table(self.out, "runs")

    @property
    def claims(self):
        return json.loads((self.out / "claims.json").read_text(encoding="utf-8"))

    def run(self, stack, seed=1):
        return load_run(self.out / stack / str(seed))

    def require_claims(self):
        """Raises ClaimFailed where one does not hold."""
        failed = [claim["text"] for claim in self.claims["claims"] if not claim["holds"]]
        if failed:
            raise ClaimFailed("; ".join(failed))
        return self


def compare(experiment, *, out=None, only=None, jobs=1, set=None, plugins=(), plugin_folders=(), force=False,
            quiet=False):
    """Races every stack of an experiment, as `gripline compare`. `set` maps JSON pointers to values; `plugins` are Python
    classes derived from Estimator or Controller, which the experiment names by their id; with `quiet` nothing is
    printed. Raises ValueError for wrong input, RuntimeError for a plugin that cannot be used or a run that broke."""
    offer(plugins)
    folder = _out(out, experiment)
    stacks = [name.strip() for one in several(only) for name in one.split(",")]
    words = _words(experiment, folder, set, plugin_folders, force) + options(jobs=jobs, only=",".join(stacks) or None)
    return Comparison(folder, call(_gripline.compare, words, quiet, lambda: _why_broken(folder, stacks)))


def run(experiment, stack=None, seed=None, *, out=None, set=None, plugins=(), plugin_folders=(), force=False,
        quiet=False):
    """One run of an experiment, as `gripline run`."""
    offer(plugins)
    folder = _out(out, experiment)
    words = _words(experiment, folder, set, plugin_folders, force) + options(stack=stack, seed=seed)
    call(_gripline.run, words, quiet, lambda: _why_broken(folder, several(stack), seed))
    if stack is None or seed is None:
        first = _gripline.first_run(str(experiment), assignments(set), several(plugin_folders))
        stack, seed = stack or first[0], first[1] if seed is None else seed
    return load_run(folder / stack / str(seed))
