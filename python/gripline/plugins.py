"""Plugins that are Python classes."""

import hashlib
import inspect
import tempfile
import traceback
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import _gripline


@dataclass
class Param:
    """A declared parameter, set in JSON and checked there: default, unit ("1" when pure), least and largest, a sentence.
    Raises ValueError where the default is outside its range."""

    default: float
    unit: str = "1"
    low: float = -1e300
    high: float = 1e300
    doc: str = "a number"

    def __post_init__(self):
        try:
            inside = self.low <= self.default <= self.high
        except TypeError:
            raise ValueError(f"{self}: default, low and high are numbers") from None
        if not inside:
            raise ValueError(f"the default of a Param, {self.default}, is outside its range, {self.low} to {self.high}")


class _Plugin:
    """`id` is what JSON calls it, `params` its declared parameters by name. The constructor is given a context (car, dt,
    seed, mu_init) and the values of the parameters as keywords. A process of its own makes and runs it."""

    id = None
    version = "1"
    params = {}

    def __init__(self, context, **params):
        self.context = context
        self.params = params


class Estimator(_Plugin):
    """Learns from every step what the nominal model leaves unexplained."""

    def update(self, sample):
        """Takes in one step. sample: t, dt, x and x_next (x, y, yaw, vx, vy, omega, delta), u (d, ddelta), e (what the
        nominal model left unexplained of vx, vy, omega, per second), kappa, grade, bank."""
        raise NotImplementedError("update() is not written")

    def belief(self):
        """Friction of the front and rear axle, peak lateral force over static load."""
        return self.context["mu_init"], self.context["mu_init"]

    def correction(self, points):
        """What to add to the accelerations (ax, ay, aw) of the nominal model, (n, 3), at (n, 5) points: vx, vy, omega, d,
        delta. A pure function; derivatives are taken by central differences of it."""
        return np.zeros((len(points), 3))


class Controller(_Plugin):
    """Drives. `horizon` is how many reference points it wants, the first for now."""

    horizon = 10

    def control(self, now, reference):
        """Throttle and steering rate for the step that begins. now: t, x (x, y, yaw, vx, vy, omega, delta), d, s, n;
        reference: (horizon, 5): x, y, yaw, kappa, v."""
        raise NotImplementedError("control() is not written")


_offered = {}
_typed = tempfile.TemporaryDirectory(prefix="gripline_classes_")


def _body(code):
    """What a function does, whatever its place in a file."""
    return code.co_code.hex(), code.co_names, [_body(c) if hasattr(c, "co_code") else repr(c) for c in code.co_consts]


def _text(one):
    """What a class is made of, where it stands in no file: typed into a notebook or a terminal."""
    try:
        return inspect.getsource(one)
    except (OSError, TypeError):
        members = sorted(vars(one).items())
        return repr([(k, _body(v.__code__) if inspect.isfunction(v) else repr(v)) for k, v in members if k[:2] != "__"])


def _source(one):
    """The file whose contents name the runs of a class: another file, another run."""
    try:
        file = inspect.getsourcefile(one)
    except (OSError, TypeError):
        file = None
    if file and Path(file).is_file():
        return str(Path(file).absolute())
    text = _text(one)
    file = Path(_typed.name) / f"{one.__name__}_{hashlib.sha256(text.encode()).hexdigest()[:12]}.py"
    file.write_text(text, encoding="utf-8")
    return str(file)


def offer(classes):
    """Makes classes known to every call that follows, under their ids."""
    classes = [classes] if isinstance(classes, type) else classes
    for one in classes:
        if not isinstance(one, type) or not issubclass(one, (Estimator, Controller)):
            name = one.__name__ if isinstance(one, type) else f"{one!r:.80}, which is no class,"
            raise ValueError(f"{name} derives neither from Estimator nor from Controller")
        kind = "estimator" if issubclass(one, Estimator) else "controller"
        if not one.id:
            raise ValueError(f"{one.__name__}.id is what JSON calls it: give it one")
        if _offered.get((kind, one.id)) is one:
            continue
        doc = (one.__doc__ or one.__name__).strip().splitlines()[0]
        params = [(name, p.default, p.unit, p.low, p.high, p.doc) for name, p in one.params.items()]
        _gripline.offer(kind, one.id, str(one.version), doc, _source(one), params, one)
        _offered[(kind, one.id)] = one


def told(thrown, trace):
    """An exception of a class in one line: what it says, and where, the innermost call first."""
    lines = [line.strip() for line in str(thrown).splitlines() if line.strip()]
    lines[:1] = [": ".join([type(thrown).__name__, *lines[:1]])]
    calls = [(frame.f_code, line) for frame, line in traceback.walk_tb(trace)]
    places = [f"{code.co_filename}:{line} in {code.co_name}" for code, line in calls]
    return " | ".join(lines + places[:-5:-1])
