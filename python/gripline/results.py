"""Folders of results as NumPy arrays."""

import csv
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from . import _gripline


def _column(texts):
    """Numbers where all cells are numbers or empty (NaN), else the texts."""
    try:
        return np.array([float(text) if text else np.nan for text in texts])
    except ValueError:
        return np.array(texts)


def read_csv(file):
    """A CSV file of gripline's as a dictionary of columns."""
    with open(file, newline="", encoding="utf-8") as lines:
        rows = list(csv.reader(lines))
    if not rows:
        raise ValueError(f"{file}: is empty")
    return {name: _column([row[i] for row in rows[1:]]) for i, name in enumerate(rows[0])}


def table_of(file):
    """A CSV file of gripline's: a pandas.DataFrame where pandas is installed, else a dictionary of columns."""
    columns = read_csv(file)
    try:
        import pandas
    except ImportError:
        return columns
    return pandas.DataFrame(columns)


@dataclass(repr=False)
class Run:
    """One run. Tables are dictionaries of columns; their units are in the names (framework/doc/output.md)."""

    folder: Path
    summary: dict
    steps: dict
    timing: dict
    replay: dict = field(default_factory=dict)
    tyres: dict = field(default_factory=dict)
    line: dict = field(default_factory=dict)

    def __repr__(self):
        rows = len(next(iter(self.steps.values()), ()))
        return f"<Run {self.folder}: {self.summary.get('status')}, {rows} rows of steps>"

    @property
    def finished(self):
        return self.summary.get("status") == "finished"

    def frame(self):
        """steps as a pandas.DataFrame."""
        import pandas

        return pandas.DataFrame(self.steps)


def _holds_results(folder):
    """Whether a folder is OUT, OUT/<stack> or a run."""
    if not folder.is_dir():
        return False
    return any((folder / name).is_file() for name in ("runs.csv", "summary.json")) or any(folder.glob("*/summary.json"))


def _nearest_results(folder):
    """What to look at in place of a folder, for messages: the results in it or, where it is not there, beside it."""
    here = folder
    while not here.is_dir() and here != here.parent:
        here = here.parent
    try:
        names = sorted(one.name for one in here.iterdir() if _holds_results(one))
    except OSError:
        names = []
    if here == folder:
        return f"; in it: {', '.join(names[:12])}" if names else ""
    return _gripline.did_you_mean(folder.relative_to(here).parts[0], names)


def load_run(folder):
    """The run in OUT/<stack>/<seed>. Raises ValueError where there is none."""
    folder = Path(folder)
    if not (folder / "summary.json").is_file():
        raise ValueError(f"{folder}: is not a run; expected OUT/<stack>/<seed> with a summary.json" +
                         _nearest_results(folder))
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    driven = folder.parent / str(summary["driven_as"]) if "driven_as" in summary else folder  # the same to the last bit
    tables = {}
    for name in ("steps", "timing", "replay", "tyres", "line"):
        file = driven / f"{name}.csv"
        tables[name] = read_csv(file) if file.is_file() else {}
    return Run(folder, summary, **tables)


def load_table(out, name="table"):
    """OUT/table.csv (or `name`, such as "runs"): a pandas.DataFrame where pandas is installed, else a dictionary.
    Raises ValueError where there is none."""
    out = Path(out)
    file = out / f"{name}.csv"
    if not out.is_dir():
        raise ValueError(f"{out}: no such folder of results" + _nearest_results(out))
    if not file.is_file():
        tables = sorted(one.stem for one in out.glob("*.csv"))
        raise ValueError(f"{file}: no such table" + _gripline.did_you_mean(str(name), tables))
    return table_of(file)
