"""Folders of results as NumPy arrays."""

import csv
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


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


@dataclass
class Run:
    """One run. Tables are dictionaries of columns; their units are in the names (framework/doc/output.md)."""

    folder: Path
    summary: dict
    steps: dict
    timing: dict
    replay: dict = field(default_factory=dict)
    tyres: dict = field(default_factory=dict)
    line: dict = field(default_factory=dict)

    @property
    def finished(self):
        return self.summary.get("status") == "finished"

    def frame(self):
        """steps as a pandas.DataFrame."""
        import pandas

        return pandas.DataFrame(self.steps)


def load_run(folder):
    """The run in OUT/<stack>/<seed>."""
    folder = Path(folder)
    if not (folder / "summary.json").is_file():
        raise FileNotFoundError(f"{folder}: is not a run; expected OUT/<stack>/<seed> with a summary.json")
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    driven = folder.parent / str(summary["driven_as"]) if "driven_as" in summary else folder  # the same to the last bit
    tables = {}
    for name in ("steps", "timing", "replay", "tyres", "line"):
        file = driven / f"{name}.csv"
        tables[name] = read_csv(file) if file.is_file() else {}
    return Run(folder, summary, **tables)


def load_table(out, name="table"):
    """OUT/table.csv (or `name`, such as "runs"): a pandas.DataFrame where pandas is installed, else a dictionary."""
    columns = read_csv(Path(out) / f"{name}.csv")
    try:
        import pandas
    except ImportError:
        return columns
    return pandas.DataFrame(columns)
