#!/usr/bin/env python3
"""Plants one bug after another and sees whether a test finds it.

    cmake --preset planted && cmake --build --preset planted && tests/planted_bugs.py [HISTORIES]

The bugs stand in core/planted_bug.hpp. HISTORIES: of the stream, 1000 unless given. Ends with 0 where the test programs pass as
they are, and each bug is found.
"""
import os
import pathlib
import re
import subprocess
import sys

TREE = pathlib.Path(__file__).resolve().parents[1]
BUG = re.compile(r'^ +\{"(.+)", "(\w+)"\},$', re.MULTILINE)
# Of a test program the tests that have to find its bugs; of others all.
TESTS = {"daemon_stream_test": "StreamHistories.*:APeerThatWaits.*:AQueue.*", "daemon_test": "*DisturbedWire*",
         "world_test": "Every/ASoak.*"}
LONGEST_S = 3600


def first_failure(program, environment):
    """The test that fails, or nothing."""
    command = [TREE / "build/planted/tests" / program, "--gtest_brief=1", "--gtest_fail_fast",
               f"--gtest_filter={TESTS.get(program, '*')}"]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S, env=os.environ | environment)
    except subprocess.TimeoutExpired:
        return f"does not end within {LONGEST_S} s"
    if run.returncode == 0:
        return None
    failed = re.search(r"^\[  FAILED  \] (\S+?),? ", run.stdout, re.MULTILINE)
    return failed[1] if failed else f"ends with {run.returncode}: {run.stderr.strip()[-100:]}"


def main():
    environment = {"TRUEPOSE_STREAM_HISTORIES": sys.argv[1] if len(sys.argv) > 1 else "1000", "TRUEPOSE_WORLD_DAYS": "1"}
    bugs = BUG.findall((TREE / "core/planted_bug.hpp").read_text())
    wrong = 0
    for program in dict.fromkeys(program for _, program in bugs):
        failure = first_failure(program, environment)
        print(f"{'fails ' if failure else 'passes'}  {program} as it is{f': {failure}' if failure else ''}", flush=True)
        wrong += failure is not None
    for name, program in bugs:
        failure = first_failure(program, environment | {"TRUEPOSE_PLANTED_BUG": name})
        print(f"{'found ' if failure else 'passes'}  {name}: {failure or program}", flush=True)
        wrong += failure is None
    sys.exit(1 if wrong or not bugs else 0)


if __name__ == "__main__":
    main()
