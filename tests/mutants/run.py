#!/usr/bin/env python3
"""Removes checks and rules from the core, one at a time, and says which of them no test misses.

    tests/mutants/run.py              every mutant of mutants.txt
    tests/mutants/run.py "dag: "      those whose names fit a regular expression
    tests/mutants/run.py --check      whether the list fits the sources, which takes no time

All mutants are built at once, into a copy of the committed tree (HEAD) under the folder MUTANTS_DIR (/tmp/voxdag-mutants):
each is a condition that holds only while the environment variable VOXDAG_MUTANT is its number. So one build is enough, and
what is tried is the tests' own binaries. A mutant is killed if a test fails or takes longer than the limit; the exit code
is 1 if one survives, 2 if a change no longer fits the source. Equivalent mutants stand in mutants.txt with the reason.
Writes docs/mutants.md of this tree when all mutants were tried."""

import datetime
import io
import json
import os
import re
import subprocess
import sys
import tarfile
import threading
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
COPY = Path(os.environ.get("MUTANTS_DIR", "/tmp/voxdag-mutants")) / "tree"
LIMIT_S = 300

SWITCH = '''
/// Whether this mutant is the one that is tried.
#[inline]
pub(crate) fn mutant(number: u32) -> bool {
    static TRIED: std::sync::OnceLock<u32> = std::sync::OnceLock::new();
    *TRIED.get_or_init(|| std::env::var("VOXDAG_MUTANT").ok().and_then(|n| n.parse().ok()).unwrap_or(0)) == number
}
'''


class Mutant:
    def __init__(self, number, name, path, tests, equivalent):
        self.number, self.name, self.path, self.tests, self.equivalent = number, name, path, tests, equivalent
        self.killed_by = None


def fail(message):
    print(message, file=sys.stderr)
    sys.exit(2)


def read_changes(text):
    """Yields (file, tests, old lines, new lines) in the order of the list."""
    path, tests = None, None
    for block in re.split(r"\n\s*\n", text):
        old, new = [], []
        for line in block.splitlines():
            kind, rest = line[:1], line[2:]
            if kind == "=":
                path = rest.strip()
            elif kind == "?":
                tests = rest.split()
            elif kind == "-":
                old.append(rest)
            elif kind == "+":
                new.append(rest)
            elif kind not in ("#", ""):
                fail(f"mutants.txt: what is this? {line}")
        if old:
            yield path, tests, old, new


def mutate(source, path, old, new):
    """Replaces the old lines, whatever their indentation, by the new ones; they must be there exactly once."""
    pattern = r"\n".join(r"[ \t]*" + re.escape(line.strip()) for line in old)
    # The last line may go on, as may the first have something in front of it.
    found = list(re.finditer(pattern, source))
    if len(found) != 1:
        fail(f"{path}: found {len(found)} times, not once:\n" + "\n".join(old))
    return source[: found[0].start()] + "\n".join(new) + source[found[0].end() :]


def change():
    """The files of the tree, changed, by path; and the mutants."""
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, stdout=subprocess.PIPE, check=True).stdout
    with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
        files = {member.name: tar.extractfile(member).read() for member in tar if member.isfile()}
    text = (HERE / "mutants.txt").read_text()
    equivalent = dict(re.findall(r"^# equivalent: (.*?) -- (.*)$", text, re.M))
    mutants = []
    for path, tests, old, new in read_changes(text):
        def number(match):
            # A name that comes again is the same mutant.
            known = next((mutant for mutant in mutants if mutant.name == match[1]), None)
            if not known:
                known = Mutant(len(mutants) + 1, match[1], path, tests, equivalent.get(match[1]))
                mutants.append(known)
            return f"crate::mutant({known.number})"

        new = [re.sub(r"\bM\(([^()]*)\)", number, line) for line in new]
        files[path] = mutate(files[path].decode(), path, old, new).encode()
    unknown = set(equivalent) - {mutant.name for mutant in mutants}
    if unknown:
        fail(f"equivalent, but no mutants: {unknown}")
    library = files["core/src/lib.rs"].decode().replace('#[cfg(feature = "std")]\nextern crate std;', "extern crate std;")
    files["core/src/lib.rs"] = (library + SWITCH).encode()
    return files, mutants


def prepare():
    """Copies the tree, changed, and gives the mutants."""
    files, mutants = change()
    # What is the same is left alone, so that cargo builds no more than it must.
    for path, content in files.items():
        file = COPY / path
        if not file.is_file() or file.read_bytes() != content:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
    # What an earlier copy had and this tree has not would be built as well.
    for file in [file for file in COPY.rglob("*") if file.is_file()]:
        if str(file.relative_to(COPY)) not in files:
            file.unlink()
    return mutants


def build():
    """The test binaries by name; the core's unit tests are called `core`."""
    env = dict(os.environ, CARGO_TARGET_DIR=str(COPY.parent / "target"))
    binaries = {}
    for package in (["-p", "voxdag-oracle", "--tests"], ["-p", "voxdag", "--lib", "--features", "obj"]):
        command = ["cargo", "test", "--no-run", "--message-format=json", *package]
        built = subprocess.run(command, cwd=COPY, env=env, stdout=subprocess.PIPE, text=True)
        for line in built.stdout.splitlines():
            message = json.loads(line)
            if message.get("executable"):
                name = message["target"]["name"]
                binaries["core" if name == "voxdag" else name] = message["executable"]
            elif message.get("reason") == "compiler-message" and message["message"]["level"] == "error":
                print(message["message"]["rendered"], file=sys.stderr)
        if built.returncode:
            fail("the mutants do not compile")
    return binaries


def run(binaries, test, number):
    """None if the test passes, else what failed."""
    name, _, only = test.partition(":")
    env = dict(os.environ, VOXDAG_MUTANT=str(number), RUST_BACKTRACE="0", CARGO_MANIFEST_DIR=str(COPY / "tests"))
    command = [binaries[name], *([only] if only else [])]
    process = subprocess.Popen(
        command, cwd=COPY / ("core" if name == "core" else "tests"), env=env,
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )
    watch = threading.Timer(LIMIT_S, process.kill)
    watch.start()
    failed = None
    for line in process.stdout:
        # One failure is enough.
        if found := re.match(r"test (\S+)( - should panic)? \.\.\. FAILED", line):
            failed = f"{name}: {found[1]}"
            process.kill()
            break
    process.stdout.close()
    code = process.wait()
    late = watch.finished.is_set()
    watch.cancel()
    if failed or code == 0:
        return failed
    return f"{name}: more than {LIMIT_S} s" if late else f"{name}: exit code {code}"


def report(mutants, seconds, tests_commit):
    lines = [
        "# Mutants: what the tests miss if it is removed",
        "",
        f"`tests/mutants/run.py`, {datetime.date.today()}, commit {tests_commit}, {seconds:.0f} s: {len(mutants)} mutants, "
        f"{sum(bool(m.killed_by) for m in mutants)} killed, {sum(bool(m.equivalent) for m in mutants)} equivalent.",
        "Each takes one inequality, rule, guard or check away (`tests/mutants/mutants.txt`); the first test that failed is named.",
    ]
    path = None
    for mutant in mutants:
        if mutant.path != path:
            path = mutant.path
            lines += ["", f"## `{path}`", "", "| mutant | killed by |", "| --- | --- |"]
        verdict = f"`{mutant.killed_by}`" if mutant.killed_by else None
        lines.append(f"| {mutant.name} | {verdict or 'equivalent: ' + (mutant.equivalent or '**SURVIVED**')} |")
    (ROOT / "docs/mutants.md").write_text("\n".join(lines) + "\n")


def main():
    only = sys.argv[1] if len(sys.argv) > 1 else ""
    if only == "--check":
        print(f"{len(change()[1])} mutants fit the sources")
        return
    start = time.monotonic()
    mutants = prepare()
    binaries = build()
    tried = [mutant for mutant in mutants if re.search(only, mutant.name)]
    print(f"{len(mutants)} mutants built in {time.monotonic() - start:.0f} s", flush=True)
    # The tests must pass without any.
    for test in sorted({test for mutant in tried for test in mutant.tests}):
        begun = time.monotonic()
        if failed := run(binaries, test, 0):
            fail(f"without a mutant: {failed}")
        print(f"{test}: passes, {time.monotonic() - begun:.1f} s", flush=True)
    survivors = []
    for mutant in tried:
        begun = time.monotonic()
        if not mutant.equivalent:
            mutant.killed_by = next(filter(None, (run(binaries, test, mutant.number) for test in mutant.tests)), None)
            if not mutant.killed_by:
                survivors.append(mutant)
        verdict = mutant.equivalent and "equivalent" or mutant.killed_by and "killed" or "SURVIVED"
        print(f"{verdict}  {mutant.name}  ({mutant.killed_by or ''}, {time.monotonic() - begun:.1f} s)", flush=True)
    if not only:
        commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, stdout=subprocess.PIPE, text=True)
        report(mutants, time.monotonic() - start, commit.stdout.strip())
    print(f"{len(tried)} mutants, {len(survivors)} survived, {time.monotonic() - start:.0f} s")
    sys.exit(1 if survivors else 0)


main()
