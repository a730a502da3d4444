"""clang-format and clang-tidy over the sources of this tree; what was clean once is remembered by its content.

A file is asked again when its own bytes, those of a file that it includes (of this tree), its compile command, the rules
or the tool changed. The memory is shared by all clones of one user: $XDG_CACHE_HOME/gripline/check. clang-tidy reads
framework, plugins and tools; clang-format the tests as well.
"""

import argparse
import hashlib
import json
import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
INCLUDE_ROOTS = ["framework/src", "framework/include", "plugins", "tests", "tools"]
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]', re.M)


def run(*words):
    return subprocess.run(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def output(*words):
    return subprocess.run(words, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def digest(*texts):
    whole = hashlib.sha256()
    for text in texts:
        whole.update(hashlib.sha256(text.encode()).digest())
    return whole.hexdigest()


class Memory:
    """What was clean: an empty file per digest, its time the last use."""

    def __init__(self):
        cache = os.environ.get("XDG_CACHE_HOME", "")
        cache = Path(cache) if cache.startswith("/") else Path.home() / ".cache"
        self.folder = cache / "gripline/check"
        self.folder.mkdir(parents=True, exist_ok=True)

    def knows(self, key):
        try:
            os.utime(self.folder / key)
        except FileNotFoundError:
            return False
        return True

    def learn(self, key):
        (self.folder / key).touch()

    def forget_unused(self, days=60):
        for file in self.folder.iterdir():
            if file.stat().st_mtime < time.time() - days * 86400:
                file.unlink(missing_ok=True)


class Sources:
    """C++ files of the tree, tracked or new, with what each includes of the tree."""

    def __init__(self):
        listed = output("git", "ls-files", "-co", "--exclude-standard", "--", "*.cpp", "*.hpp", "*.h").splitlines()
        self.text = {name: (ROOT / name).read_text() for name in sorted(set(listed)) if (ROOT / name).is_file()}
        self.includes = {name: self._direct(name) for name in self.text}

    def _direct(self, name):
        targets = INCLUDE.findall(self.text[name])
        return [path for target in targets for root in INCLUDE_ROOTS if (path := f"{root}/{target}") in self.text]

    def closure(self, name):
        seen, left = {name}, [name]
        while left:
            for other in self.includes[left.pop()]:
                if other not in seen:
                    seen.add(other)
                    left.append(other)
        return sorted(seen)

    def newest_first(self):
        """Uncommitted files, then by the last commit that touched them."""
        recent = output("git", "status", "--porcelain", "--no-renames", "-uall").splitlines()
        recent = [line[3:] for line in recent] + output("git", "log", "--format=", "--name-only", "-n", "300").split()
        rank = {}
        for name in recent:
            rank.setdefault(name, len(rank))
        return sorted(self.text, key=lambda name: rank.get(name, len(rank)))


def check_format(sources, memory):
    rules = digest((ROOT / ".clang-format").read_text(), output("clang-format", "--version"))
    keys = {name: digest("format", rules, text) for name, text in sources.text.items()}
    asked = [name for name in sources.text if not memory.knows(keys[name])]
    bad = []
    for name in asked:
        if run("clang-format", "--dry-run", "-Werror", name).returncode == 0:
            memory.learn(keys[name])
        else:
            bad.append(name)
    print(f"clang-format: {len(sources.text)} files, {len(asked)} read, {len(bad)} to be formatted")
    if bad:
        print("clang-format -i " + " ".join(bad))
    return not bad


def check_tidy(sources, memory, minutes):
    rules = digest((ROOT / ".clang-tidy").read_text(), output("clang-tidy", "--version"))
    entries = json.loads((ROOT / "build-tidy/compile_commands.json").read_text())
    commands = {os.path.relpath(entry["file"], ROOT): entry["command"].replace(str(ROOT), "") for entry in entries}
    names = [name for name in sources.newest_first() if name in commands and not name.startswith("tests/")]

    def key(name):
        closure = [digest(other, sources.text[other]) for other in sources.closure(name)]
        return digest("tidy", rules, commands[name], *closure)

    asked = [(name, k) for name in names if not memory.knows(k := key(name))]
    end = time.monotonic() + 60 * minutes if minutes else float("inf")

    def ask(entry):
        name, k = entry
        if time.monotonic() > end:
            return None
        answer = run("clang-tidy", "-p", "build-tidy", "--quiet", name)
        if answer.returncode == 0:
            memory.learn(k)
        else:
            print(answer.stdout, flush=True)
        return answer.returncode == 0

    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        answers = list(pool.map(ask, asked))
    late, bad = answers.count(None), answers.count(False)
    print(f"clang-tidy: {len(names)} files, {len(asked) - late} read, {bad} with findings"
          + (f", {late} not reached in {minutes:g} min" if late else ""))
    return not bad


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--minutes", type=float, default=0, help="for clang-tidy, newest changes first; 0: no limit")
    options.add_argument("--no-tidy", action="store_true", help="leave clang-tidy out")
    given = options.parse_args()
    sources, memory = Sources(), Memory()
    memory.forget_unused()
    good = [check_format(sources, memory)]
    if not given.no_tidy:
        good.append(check_tidy(sources, memory, given.minutes))
    sys.exit(0 if all(good) else 1)


if __name__ == "__main__":
    main()
