#!/usr/bin/env python3
"""Plants one bug after another and sees whether a test finds it: into the stream, that of random histories; into the drivers of robot
and tracker, those of the drivers and of campaigns whose wires are disturbed.

    tests/daemon/planted_bugs.py [HISTORIES]      1000 unless said otherwise; needs build/release, whole

Ends with 0 where both pass as they are and every bug is found. The bugs are those that attacks on the product found, or that would be
easiest to make again.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

TREE = pathlib.Path(__file__).resolve().parents[2]
BUILD = TREE / "build/release"
SESSION = "daemon/realtime/controller_session.cpp"
IN_FORCE = "daemon/realtime/correction_in_effect.cpp"
CYCLE = "daemon/realtime/stream_cycle.cpp"
PIN = "daemon/realtime/controller_session.hpp"

# name: [(file, what stands there, what is put in its place), ...]
BUGS = {
    "as it is": [],
    "zero at the start, whatever is in force": [
        (IN_FORCE, "  if (knowledge_ == Knowledge::Doubtful) settle_doubt(evidence, step);",
         "  set(CorrectionRange::of(zero()));"),
    ],
    "a source that is not pinned": [
        (PIN, "    if (address_ && source.address != *address_) return false;", ""),
        (PIN, "    return !pinned_ || source == *pinned_ || now - heard_ >= release_;", "    return true;"),
        (PIN, "    return other;", "    return other && !heard_.time_since_epoch().count();"),
    ],
    "a timeout of the controller that is a constant": [
        (SESSION, "  sequence_.advance(frame.ipoc, position);\n  received_before_ = received_;\n  settle(",
         "  if (position.elapsed > 100) in_effect_.set(CorrectionRange::of(JointVector::Zero(6))), verdict.settled = true;\n"
         "  sequence_.advance(frame.ipoc, position);\n  received_before_ = received_;\n  settle("),
    ],
    "a bound of each datagram, not of what is in force": [
        (CYCLE, "bound_correction(wanted, session_.in_effect(), commanded, bounds_)",
         "bound_correction(wanted, CorrectionRange::of(correction_), commanded, bounds_)"),
        (CYCLE, "!free || verdict.missed ||", "!free ||"),
    ],
    "a new start that is judged on one axis": [
        (SESSION, "  if (longer_than_counted || (long_silence && !receipt.alive)) {",
         "  const auto one_axis = [&] {\n"
         "    Eigen::Index axis = 0;\n"
         "    const double largest = in_effect_.last_sent().cwiseAbs().maxCoeff(&axis);\n"
         "    const auto a = static_cast<std::size_t>(axis);\n"
         "    return frame.aipos_rad && frame.aspos_rad &&\n"
         "           std::abs((*frame.aipos_rad)[a] - (*frame.aspos_rad)[a]) < largest / 10;\n"
         "  };\n"
         "  if (long_silence && one_axis()) {\n"
         "    in_effect_.set(CorrectionRange::of(JointVector::Zero(6)));\n"
         "    verdict.settled = true;\n"
         "  }\n"
         "  if (false) {"),
    ],
    "a peer that waits has nothing in force, whatever was sent": [
        (SESSION, "  if (corrected_ || !frame.aspos_rad", "  if (!frame.aspos_rad"),
    ],
    "a peer that waits is believed to have taken what it was offered": [
        (SESSION, "&& next && receipt.taken) {", "&& next) {"),
    ],
}
EKI = "drivers/kuka/eki_channel.cpp"
ROBOT = "drivers/kuka/eki_robot.cpp"
DEVICES = "daemon/campaign/cell_devices.cpp"
EMSCON = "drivers/leica/emscon_connection.cpp"
LEICA = "drivers/leica/emscon_tracker.cpp"
LEICA_SETTINGS = "drivers/leica/emscon_settings.cpp"
BRIDGE = "drivers/bridge/bridge_tracker.cpp"

WIRE_BUGS = {
    "as they are": [],
    "half a document of a lost connection is gone on with": [
        (EKI, "  splitter_.reset();\n  messages_.clear();\n", ""),
    ],
    "half a packet of a lost connection is gone on with": [
        (EMSCON, "  wire_.close();\n  splitter_ = {};\n", "  wire_.close();\n"),
        (EMSCON, "    if (!is_open()) splitter_ = {};\n", ""),
    ],
    "a device that is lost is looked for every twenty seconds": [
        (DEVICES, "  const TimePoint next = clock_.now() + kAgain;", "  const TimePoint next = clock_.now() + 20 * kAgain;"),
    ],
}
DRIVER_BUGS = {
    "as they are": [],
    "a motion that is ordered again has a new number": [
        (ROBOT, "unfinished_ && same_order(command, *unfinished_) ? unfinished_->id : next_id();", "next_id();"),
    ],
    "a stop is not released by whoever connects": [
        (ROBOT, "return open(eki::ControlOp::ReleaseStop, deadline);", "return open(eki::ControlOp::AskState, deadline);"),
    ],
    "an open gate is ready": [
        (ROBOT, "  if (needs_gate && !state.gate_closed) return \"safety gate open\";\n", ""),
    ],
    "an arm that is switched off is at rest": [
        (ROBOT, "  if (!state.no_emergency_stop) return \"emergency stop\";\n", ""),
    ],
    "the search is never narrowed": [
        (LEICA, "  if (std::get<SearchParams>(answer->body) == wanted) co_return TrackerResult<void>{};",
         "  if (std::get<SearchParams>(answer->body).radius > 0) co_return TrackerResult<void>{};"),
    ],
    "a measurement that was left is not stopped": [
        (LEICA, "  if (!measurement_unfinished_) co_return", "  if (true) co_return"),
    ],
    "a broken beam is waited for": [
        (LEICA, "      if (change->event == SystemEvent::MeasurementNotReady) {", "      if (false) {"),
    ],
    "a point is taken whatever air it was measured in": [
        (LEICA, "  if (auto why_not = implausible(result->point))", "  if (auto why_not = std::optional<std::string>{})"),
    ],
    "a tracker that was switched on is not initialised": [
        (LEICA, "  if (!cold && !warm_up_.is_due()) co_return found;", "  co_return found;"),
    ],
    "what another program may have set is not looked at": [
        (LEICA, "  const auto ensured = co_await settings_.ensure();", "  const TrackerResult<void> ensured;"),
    ],
    "a bridge is not asked for its status first": [
        (BRIDGE, "  auto found = co_await status();\n  if (!found) co_return found;\n  if (found->reflector",
         "  TrackerResult<bridge::Status> found{bridge::Status{}};\n  found->locked = true;\n  found->reflector = reflector_;\n  if (found->reflector"),
    ],
    "what a bridge was in the midst of is not stopped": [
        (BRIDGE, "  if (!unfinished_) co_return", "  if (true) co_return"),
    ],
}
# A test program, which of its tests, and what they are to find.
LINKED = [
    ("daemon_test", "*DisturbedWire*", WIRE_BUGS),
    ("drivers_test", "*", DRIVER_BUGS),
]
OF_THE_STREAM = sorted(file.stem for file in (TREE / "daemon/realtime").glob("*.cpp"))
OF_THE_TEST = ["stream_history_test", "waiting_peer_test", "stream_cell", "robot_program", "plant"]
FLAGS = ["-std=c++23", "-O1", "-DNDEBUG", "-isystem", "/usr/include/eigen3", "-I.", '-DTRUEPOSE_VERSION="0"',
         f'-DTRUEPOSE_SOURCE_DIR="{TREE}"']


def plant(folder, changes):
    for file, old, new in changes:
        text = (folder / file).read_text()
        if old not in text:
            sys.exit(f"{file} no longer has what the bug takes the place of: {old!r}")
        (folder / file).write_text(text.replace(old, new, 1))


def link_command(test):
    """How the release build links a test program: sources, then libraries, from within BUILD."""
    commands = subprocess.run(["ninja", "-C", BUILD, "-t", "commands", f"tests/{test}"], capture_output=True, text=True, check=True)
    return commands.stdout.splitlines()[-1].removesuffix(" && :")


def compile_in(folder):
    sources = [f"daemon/realtime/{name}.cpp" for name in OF_THE_STREAM] + [f"tests/daemon/{n}.cpp" for n in OF_THE_TEST]
    objects = []
    pending = []
    for source in sources:
        objects.append(source.replace("/", "_") + ".o")
        pending.append(subprocess.Popen(["ccache", "g++", *FLAGS, f"-I{TREE}", "-c", source, "-o", objects[-1]], cwd=folder))
        if len(pending) == os.cpu_count():
            if pending.pop(0).wait() != 0:
                sys.exit("a planted bug does not compile")
    if any([job.wait() != 0 for job in pending]):
        sys.exit("a planted bug does not compile")
    libraries = link_command("daemon_stream_test").split(" -o tests/daemon_stream_test ")[1]
    linked = " ".join(str(folder / name) for name in objects)
    subprocess.run(f"g++ -o {folder}/histories {linked} -Wl,--allow-multiple-definition {libraries} ", cwd=BUILD, shell=True, check=True)


def with_sources(folder, test, changed):
    """Links a test program with changed sources: the linker takes their functions before the library's."""
    command = link_command(test)
    objects = []
    for source in changed:
        objects.append(folder / (source.replace("/", "_") + ".o"))
        subprocess.run(["g++", *FLAGS, f"-I{TREE}", "-c", folder / source, "-o", objects[-1]], cwd=folder, check=True)
    planted = " ".join(map(str, objects)) + " -Wl,--allow-multiple-definition "
    command = command.replace(f"-o tests/{test}", f"-o {folder}/test").replace(" tests/", f" {planted} tests/", 1)
    subprocess.run(command, cwd=BUILD, shell=True, check=True)


def try_linked(test, cases, bugs):
    wrong = 0
    for name, changes in bugs.items():
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place)
            changed = sorted({file for file, _, _ in changes})
            for file in changed:
                (folder / file).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(TREE / file, folder / file)
            plant(folder, changes)
            with_sources(folder, test, changed)
            try:
                run = subprocess.run(["./test", "--gtest_brief=1", f"--gtest_filter={cases}"], cwd=folder, capture_output=True,
                                     text=True, timeout=120)
                found, how = run.returncode != 0, next((line for line in run.stdout.splitlines() if "FAILED" in line), "")
            except subprocess.TimeoutExpired:
                found, how = True, "it never ends"
            print(f"{'found ' if found else 'passes'}  {name}: {how}", flush=True)
            wrong += found != bool(changes)
    return wrong


def try_stream(histories):
    wrong = 0
    for name, changes in BUGS.items():
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place)
            for part in ("daemon", "drivers", "proto", "core", "config", "tests/daemon"):
                shutil.copytree(TREE / part, folder / part)
            plant(folder, changes)
            compile_in(folder)
            run = subprocess.run(["./histories", "--gtest_brief=1"], cwd=folder, capture_output=True, text=True,
                                 env=os.environ | {"TRUEPOSE_STREAM_HISTORIES": histories})
            found = run.returncode != 0
            first = next((line for line in run.stdout.splitlines() if line.startswith(("seed", histories))), "")
            print(f"{'found ' if found else 'passes'}  {name}: {first}", flush=True)
            wrong += found != bool(changes)
    return wrong


def main():
    wrong = sum(try_linked(*linked) for linked in LINKED)
    wrong += try_stream(sys.argv[1] if len(sys.argv) > 1 else "1000")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
