#!/usr/bin/env python3
"""Compares what users and clients see of the programs with what is frozen below tests/goldens/frozen.

    frozen_outputs.py             compares; ends 1 and prints what differs
    frozen_outputs.py --write     freezes what the programs print now
    frozen_outputs.py --only X    the outputs with X in their name

offline/: the sessions of commands.txt. Each runs in one copy of the shipped data, in a network of its own.
online/: every method of the control port, events, and the commands that ask a daemon (online_outputs.py).
normal_form.py says in which form outputs are frozen, and within which tolerance numbers agree.
"""
import argparse
import concurrent.futures
import html.parser
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
import normal_form  # noqa: E402
import online_outputs  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
FROZEN = HERE / "frozen"
ADVICE = ("If the difference is meant, write its reason into CHANGELOG.md and freeze again: tests/goldens/frozen_outputs.py --write")
HIDDEN = {"elapsed_s", "time_s", "rank_gap"}  # durations, and a ratio to a rounding error


class PageText(html.parser.HTMLParser):
    """The words of a page: a row of a table is one line, and so are the labels of a drawing. The names of the files that it carries."""

    def __init__(self):
        super().__init__()
        self.lines, self.open, self.within = [], [], []

    def handle_starttag(self, tag, attributes):
        if tag in ("script", "style", "svg", "tr"):
            self.open.append(tag)
            self.within.append([])
        for name, value in attributes:
            if name in ("aria-label", "alt", "title", "download"):
                self.add(f"{name}: {value}")

    def handle_endtag(self, tag):
        if self.open and self.open[-1] == tag:
            self.open.pop()
            words = self.within.pop()
            if tag == "svg":  # a bare number is a tick of an axis, which is layout
                words = [word for word in words if not re.fullmatch(r"[-−]?[\d.]+(e[-−+]?\d+)?", word)]
            if tag == "svg" and len(words) > 24:
                words = [*words[:16], f"[{len(words) - 20} labels between]", *words[-4:]]
            if tag in ("svg", "tr"):
                self.add(" | ".join(words))

    def handle_data(self, data):
        if data.strip():
            self.add(" ".join(data.split()))

    def add(self, words):
        (self.within[-1] if self.within else self.lines).append(words)


def page_text(text):
    page = PageText()
    page.feed(text)
    return "\n".join(page.lines)


def file_text(path, masks):
    """A written file in its normal form."""
    if not path.exists():
        return "[not written]"
    text = path.read_bytes().decode("utf-8", errors="replace")
    if path.suffix == ".html":
        text = page_text(text)
    kind = "[lines end with CR LF]\n" if "\r\n" in text else ""
    return kind + normal_form.output_text(text, HIDDEN, masks)


def sessions():
    """(name, lines) of each session of commands.txt."""
    found = {}
    for line in (HERE / "commands.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("== "):
            lines = found[line[3:]] = []
        elif line and not line.startswith("#"):
            lines.append(line)
    return found.items()


def files_of(words, work):
    for word in words:
        path = work / word
        yield from sorted(one for one in path.rglob("*") if one.is_file()) if path.is_dir() else [path]


def run_session(lines, work, environment, masks):
    """Commands with what they print and how they end; `show FILE...` has what they wrote."""
    parts = []
    for line in lines:
        command, *words = shlex.split(line)
        if command == "show":
            for path in files_of(words, work):
                parts += [f"--- {path.relative_to(work)}", file_text(path, masks)]
            continue
        done = subprocess.run(["bash", "-c", line], cwd=work, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        parts += [f"$ {line}", normal_form.output_text(done.stdout, HIDDEN, masks), normal_form.masked(done.stderr, masks).rstrip("\n"),
                  f"[exit {done.returncode}]"]
    return "\n".join(part for part in parts if part) + "\n"


def help_texts(environment, program="truepose", words=()):
    """The help of a program and of all its commands."""
    text = subprocess.run([program, *words, "--help"], env=environment, capture_output=True, text=True, check=True).stdout
    parts = [f"$ {' '.join([program, *words])} --help", text.rstrip("\n")]
    sections = [part.splitlines() for part in text.split("\n\n") if part.startswith("Commands")]
    for command in [line.split()[0] for lines in sections for line in lines if line.startswith("  ") and line[2] != " "]:
        parts += help_texts(environment, program, (*words, command))
    return parts


def offline_outputs(bin_folder):
    """{name: text} of all sessions."""
    with tempfile.TemporaryDirectory(prefix="goldens.") as folder:
        work = pathlib.Path(folder) / "work"
        shutil.copytree(ROOT / "config/quickstart", work, ignore=shutil.ignore_patterns("make.py"))
        shutil.copytree(ROOT / "config", work / "cell", ignore=shutil.ignore_patterns("*.cpp", "*.hpp", "CMakeLists.txt", "quickstart"))
        (work / "tests").symlink_to(ROOT / "tests")
        environment = {"PATH": f"{bin_folder}:{os.environ['PATH']}", "HOME": folder, "XDG_RUNTIME_DIR": folder, "LC_ALL": "C.UTF-8", "TZ": "UTC"}
        masks = [(str(work), "<work>"), (str(ROOT), "<source>")]
        found = {f"offline/{name}": run_session(lines, work, environment, masks) for name, lines in sessions()}
        found["offline/help"] = normal_form.masked("\n".join(help_texts(environment)) + "\n", masks)
        return found


def all_outputs(bin_folder):
    with concurrent.futures.ThreadPoolExecutor() as side_by_side:
        parts = [side_by_side.submit(offline_outputs, bin_folder), side_by_side.submit(online_outputs.outputs, bin_folder, ROOT)]
        return {name: text for part in parts for name, text in part.result().items()}


def write(found, only):
    if not only:
        shutil.rmtree(FROZEN, ignore_errors=True)
    for name, text in found.items():
        if only in name:
            path = FROZEN / f"{name}.txt"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")


def compare(found, only):
    """Prints what differs. Returns how many outputs do."""
    frozen = {str(path.relative_to(FROZEN).with_suffix("")): path.read_text(encoding="utf-8") for path in FROZEN.rglob("*.txt")}
    differing = 0
    for name in sorted(name for name in frozen.keys() | found.keys() if only in name):
        if difference := normal_form.difference(name, frozen.get(name, ""), found.get(name, "")):
            differing += 1
            print(difference)
    print(f"{len(found)} outputs, {differing} differ")
    return differing


def enter_own_network():
    """Restarts this program in a network of its own where the user may make one; the ports are free ones in any case."""
    if "GOLDENS_IN_OWN_NETWORK" in os.environ:
        return
    own = ["unshare", *([] if os.getuid() == 0 else ["--user", "--map-current-user"]), "--net", "bash", "-c", 'ip link set lo up && exec "$@"', "_"]
    if subprocess.run([*own, "true"], capture_output=True, check=False).returncode == 0:
        os.execvpe(own[0], [*own, sys.executable, *sys.argv], os.environ | {"GOLDENS_IN_OWN_NETWORK": "1"})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin", help="folder of the programs; default: build/release/bin")
    parser.add_argument("--write", action="store_true", help="freeze instead of comparing")
    parser.add_argument("--only", default="", metavar="X", help="the outputs with X in their name")
    options = parser.parse_args()
    found = all_outputs(options.bin.resolve())
    if options.write:
        return write(found, options.only)
    if compare(found, options.only):
        print(ADVICE)
        return 1
    return 0


if __name__ == "__main__":
    enter_own_network()
    sys.exit(main())
