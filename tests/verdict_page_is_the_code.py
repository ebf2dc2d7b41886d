#!/usr/bin/env python3
"""The tables of docs/verdict.md have every finding of the code, with its severity, and no other.

    verdict_page_is_the_code.py ROOT

A finding is a function that the arrays of calibration_verdict.cpp name, or one of OTHERS. Its words are the texts in it and in the functions
that it calls; its severities are those that it names.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
SOURCES = [*sorted((ROOT / "core/judge").glob("*.cpp")), ROOT / "daemon/campaign/corrected_points.cpp"]
# Findings that no array of calibration_verdict.cpp names.
OTHERS = {("splits_verdict.cpp", "beyond_tolerance"), ("splits_verdict.cpp", "verdict_over_splits"), ("splits_verdict.cpp", "doubts_of_others"),
          ("joint_limits.cpp", "measured_beyond_limits"), ("corrected_points.cpp", "correct_aim"), ("corrected_points.cpp", "correct_stand"),
          ("corrected_points.cpp", "leave_out_unidentified")}
# What a function of another file or a variable decides.
DELEGATED = {
    "reference_moved": [("reference_pose.cpp", "moved_reference")],
    "joints_rounded": [("joint_coverage.cpp", "rounded_joints")],
    "on_last_axis": [("reflector_on_axis.cpp", "reflectors_on_last_axis")],
    "poses_narrow": [("joint_coverage.cpp", "narrow_poses")],
    "correct_aim": [("two_face.cpp", "described")],
}


def functions():
    """{(file, name): body}"""
    found = {}
    for file in SOURCES:
        text = file.read_text(encoding="utf-8")
        for match in re.finditer(r"^[A-Za-z][^\n;{}=]*?\b(\w+)\([^;{}]*\)[^;{}]*\{\n(.*?)^\}", text, re.MULTILINE | re.DOTALL):
            found[file.name, match[1]] = match[2]
        for match in re.finditer(r"^Finds (\w+)\([^;{}]*\) \{ (.*) \}$", text, re.MULTILINE):
            found[file.name, match[1]] = match[2]
    return found


def words_of(body):
    """Texts that stand one behind the other are one."""
    return [re.sub(r'"\s*"', "", found)[1:-1] for found in re.findall(r'"(?:[^"\\]|\\.)*"(?:\s*"(?:[^"\\]|\\.)*")*', body)]


def severities_of(body):
    by_helper = {"refusal": "error", "doubt": "warning", "advice": "advice"}
    named = {by_helper[name] for name in re.findall(r"\b(refusal|doubt|advice)\(", body)}
    return named | {name.lower() for name in re.findall(r"Severity::(\w+)", body)}


def quoted(row):
    """What a row quotes, "..." for any text."""
    found = re.search(r"`([^`]+)`", row[0])
    return re.compile(".*".join(map(re.escape, found[1].split("...")))) if found else None


def main():
    bodies = functions()
    verdict = (ROOT / "core/judge/calibration_verdict.cpp").read_text(encoding="utf-8")
    findings = set(OTHERS) & set(bodies)
    for names in re.findall(r"constexpr std::array kOf\w+\{(.*?)\};", verdict, re.DOTALL):
        findings |= {("calibration_verdict.cpp", name) for name in re.findall(r"\w+", names)}
    page = (ROOT / "docs/verdict.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (.*?) \| (note|advice|warning|error) \|", page, re.MULTILINE)
    faults, used = [], set()
    for file, name in sorted(findings):
        body = bodies.get((file, name))
        if body is None:
            faults.append(f"{file}: {name} is not found: this test reads the source wrongly")
            continue
        called = "\n".join(text for (of, other), text in bodies.items() if (of, other) in DELEGATED.get(name, []) or
                           (of == file and other != name and re.search(rf"\b{other}\(", body) and other not in ("of", "refusal", "doubt", "advice")))
        texts = words_of(body + called)
        severities = severities_of(body) | (severities_of(called) if name in DELEGATED or file != "calibration_verdict.cpp" else set())
        mine = {row for row in rows if any(quoted(row).search(text) for text in texts if quoted(row))}
        used |= mine
        shown = {severity for _, severity in mine}
        if not mine:
            faults.append(f"docs/verdict.md has no row for {name} of {file}: add one")
        elif "moved" not in name and "stand" not in name and shown != severities:
            faults.append(f"docs/verdict.md: {name} of {file} is {sorted(severities)} in the code, {sorted(shown)} on the page")
    faults += [f"docs/verdict.md: no finding of the code says {row[0]}" for row in rows if quoted(row) and row not in used]
    for fault in faults:
        print(fault)
    print(f"{len(findings)} findings, {len(rows)} rows")
    return 1 if faults else 0


sys.exit(main())
