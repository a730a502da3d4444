"""A command's words from the arguments of a Python function, and its call."""

import json
import os
from collections.abc import Mapping


def _plain(value):
    """What json knows of a NumPy scalar or array, or of a path."""
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    for convert in ("tolist", "item"):
        if callable(getattr(value, convert, None)):
            return getattr(value, convert)()
    raise TypeError(f"found {value!r:.80} of type {type(value).__name__}")


def _json_text(pointer, value):
    try:
        return json.dumps(value, default=_plain)
    except (TypeError, ValueError) as error:
        raise ValueError(f"set {pointer}: expected a number, a text, or a list or dict of them; {error}") from None


def assignments(changes):
    """POINTER=VALUE of a dictionary, as after --set."""
    if changes is None:
        return []
    if not isinstance(changes, Mapping):
        raise ValueError(f'set maps JSON pointers to values, {{"/world/laps": 1}}; found {changes!r:.80}')
    return [f"{pointer}={value if isinstance(value, str) else _json_text(pointer, value)}"
            for pointer, value in changes.items()]


def several(given):
    """One name or several, as texts."""
    if given is None:
        return []
    return [str(given)] if isinstance(given, (str, os.PathLike)) else [str(one) for one in given]


def options(**given):
    """--name value of what was given: once for each of a list, without a value where it is True."""
    words = []
    for name, value in given.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            words.append(option)
        elif value is not None and value is not False:
            for one in value if isinstance(value, list) else [value]:
                words += [option, str(one)]
    return words


def call(command, words, quiet, why_broken=lambda: ""):
    """Runs a command of _gripline: whether its answer is good, as the program's exit code 0. Raises RuntimeError where
    a run broke, with what `why_broken` says of it."""
    code = command(words, quiet)
    if code > 1:
        raise RuntimeError(why_broken() or "the report could not be written")
    return code == 0
