"""The program's commands, in this process, so that they know plugins that are Python classes."""

import json
from dataclasses import dataclass
from pathlib import Path

from . import _gripline
from .plugins import offer
from .results import load_run, load_table


class ClaimFailed(AssertionError):
    """A claim of the experiment does not hold."""


def _assignments(changes):
    return [f"{pointer}={value if isinstance(value, str) else json.dumps(value)}"
            for pointer, value in (changes or {}).items()]


def _words(experiment, out, jobs, changes, force, plugin_folders):
    words = [str(experiment), "--out", str(out), "-j", str(jobs)]
    for assignment in _assignments(changes):
        words += ["--set", assignment]
    for folder in plugin_folders:
        words += ["--plugins", str(folder)]
    return words + (["--force"] if force else [])


def _out(out, experiment):
    return Path(out) if out is not None else Path("out") / Path(str(experiment)).stem


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


def compare(experiment, *, out=None, only=None, jobs=1, set=None, plugins=(), plugin_folders=(), force=False):
    """Races every stack of an experiment, as `gripline compare`. `set` maps JSON pointers to values; `plugins` are Python
    classes derived from Estimator or Controller, which the experiment names by their id. Raises ValueError for wrong
    input, RuntimeError for a plugin that cannot be used or a run that broke."""
    offer(plugins)
    folder = _out(out, experiment)
    words = _words(experiment, folder, jobs, set, force, plugin_folders)
    if only:
        words += ["--only", only if isinstance(only, str) else ",".join(only)]
    return Comparison(folder, _gripline.compare(words) == 0)


def run(experiment, stack=None, seed=None, *, out=None, set=None, plugins=(), plugin_folders=(), force=False):
    """One run of an experiment, as `gripline run`."""
    offer(plugins)
    folder = _out(out, experiment)
    words = _words(experiment, folder, 1, set, force, plugin_folders)
    if stack is not None:
        words += ["--stack", stack]
    if seed is not None:
        words += ["--seed", str(seed)]
    _gripline.run(words)
    if stack is None or seed is None:
        first = _gripline.first_run(str(experiment), _assignments(set), [str(f) for f in plugin_folders])
        stack, seed = stack or first[0], first[1] if seed is None else seed
    return load_run(folder / stack / str(seed))


def diagnose(world, logs, *, out="out/diagnosis", held_out=(), plugin_folders=(), force=False):
    """Which effect is missing between a world and logs, as `gripline diagnose`: the contents of diagnosis.json."""
    logs = [logs] if isinstance(logs, (str, Path)) else list(logs)
    words = [str(world), *map(str, logs), "--out", str(out)]
    for log in held_out:
        words += ["--held-out", str(log)]
    for folder in plugin_folders:
        words += ["--plugins", str(folder)]
    _gripline.diagnose(words + (["--force"] if force else []))
    return json.loads((Path(out) / "diagnosis.json").read_text(encoding="utf-8"))
