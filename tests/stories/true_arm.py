#!/usr/bin/env python3
"""An arm that differs from its data sheet: the files of its user, and where it truly goes. Shares no code with the product.

    true_arm.py ARM make FOLDER    ARM: ur10, kr210. What was measured and what is to be reached; for kr210 the archive.
    true_arm.py ARM judge JOINTS   ends 1 where the arm misses its targets at these joints (CSV of truepose compensate)

Lengths are in mm, angles in rad.
"""
import csv
import math
import pathlib
import random
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
NOISE_MM = 0.02
POSES, TARGETS = 60, 12


def product(*factors):
    result = [[float(i == j) for j in range(4)] for i in range(4)]
    for its in factors:
        result = [[sum(row[k] * its[k][j] for k in range(4)) for j in range(4)] for row in result]
    return result


def step(kind, value):
    """A shift along x, y, z, or a turn about x (c), y (b), z (a)."""
    m = product()
    if kind in "xyz":
        m["xyz".index(kind)][3] = value
        return m
    i, j = {"c": (1, 2), "b": (2, 0), "a": (0, 1)}[kind]
    m[i][i] = m[j][j] = math.cos(value)
    m[i][j], m[j][i] = -math.sin(value), math.sin(value)
    return m


def chain(*steps):
    return product(*(step(kind, value) for kind, value in steps))


# Standard DH: d, a, alpha. Then by what the true arm differs: d, a, alpha, zero of the joint.
UR10 = [(127.3, 0, math.pi / 2), (0, -612, 0), (0, -572.3, 0), (163.941, 0, math.pi / 2), (115.7, 0, -math.pi / 2), (92.2, 0, 0)]
UR10_ERRORS = [(0, 0.4, 0.0008, 0), (0, 1.1, -0.0012, 0.0021), (0, -0.8, 0.0006, -0.0017), (0.5, 0.2, -0.001, 0.0012),
               (-0.4, 0.1, 0.0009, -0.0024), (0, 0, 0, 0)]


def ur10(q, share):
    """@param share  of the errors: 0 the data sheet, 1 the true arm"""
    steps = []
    for angle, (d, a, alpha), (e_d, e_a, e_alpha, zero) in zip(q, UR10, UR10_ERRORS):
        steps += [("a", angle + share * zero), ("z", d + share * e_d), ("x", a + share * e_a), ("c", alpha + share * e_alpha)]
    return chain(*steps)


def kr210(q, share):
    """KR 210 R2700-2 as its drawing shows it: at zero stretched along x."""
    a1, a2, a3, a4, a5, a6 = (angle + share * zero for angle, zero in zip(q, (0, 0.0015, -0.0022, 0.0018, -0.0012, 0)))
    return chain(("z", 645), ("a", -a1), ("x", 330 + share * 0.7), ("c", share * 0.0007),
                 ("b", a2), ("x", 1150 - share * 1.2), ("a", share * 0.0005),
                 ("b", a3), ("x", 1220 + share * 0.9), ("z", 115 + share * 0.6), ("a", -share * 0.0006),
                 ("c", -a4), ("b", a5), ("y", share * 0.2), ("c", -a6), ("x", 215), ("b", math.pi / 2))


# The arm, and between which angles (deg) its poses are.
ARMS = {"ur10": (ur10, [(-170, 170), (-150, -30), (-130, 130), (-150, 150), (-150, 150), (-170, 170)]),
        "kr210": (kr210, [(-80, 80), (-120, -40), (20, 130), (-150, 150), (-100, 100), (-170, 170)])}


def angles_abc(m):
    """A, B, C of Rz(A) Ry(B) Rx(C)."""
    return [math.atan2(m[1][0], m[0][0]), math.asin(max(-1, min(1, -m[2][0]))), math.atan2(m[2][1], m[2][2])]


def position(m):
    return [row[3] for row in m[:3]]


def random_joints(ranges, chance):
    return [math.radians(chance.uniform(*each)) for each in ranges]


def measured(arm, ranges, chance):
    """Joints and what a tracker saw at them, of a reflector on the flange."""
    base = chain(("x", 2600), ("y", -1400), ("z", 900), ("a", 0.8))
    reflector = chain(("x", 85), ("y", 40), ("z", 60))
    for _ in range(POSES):
        q = random_joints(ranges, chance)
        yield q, [x + chance.gauss(0, NOISE_MM) for x in position(product(base, arm(q, 1), reflector))]


def targets_of(arm, ranges):
    chance = random.Random(2)
    return [(q, arm(q, 0)) for q in (random_joints(ranges, chance) for _ in range(TARGETS))]


def write_plain(path, header, rows):
    """In rad and m, which no name says."""
    path.write_text("\n".join([header] + [",".join(f"{x:.6f}" for x in row) for row in rows]) + "\n")


def write_german(path, header, rows):
    """As a German Excel saves it."""
    lines = [header] + [";".join(f"{x:.4f}".replace(".", ",") for x in row) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="cp1252", newline="\r\n")


def in_m(position_mm):
    return [x / 1000 for x in position_mm]


def in_deg(angles):
    return [math.degrees(x) for x in angles]


def make(name, folder):
    arm, ranges = ARMS[name]
    points, targets = list(measured(arm, ranges, random.Random(1))), [X for _, X in targets_of(arm, ranges)]
    if name == "ur10":
        (folder / "ur10_dh.csv").write_text((HERE / "ur10_dh.csv").read_text())
        write_plain(folder / "measured.csv", "q1,q2,q3,q4,q5,q6,x,y,z", [q + in_m(p) for q, p in points])
        write_plain(folder / "targets.csv", "x,y,z,a,b,c", [in_m(position(X)) + angles_abc(X) for X in targets])
        return
    axes = ";".join(f"A{i} (°)" for i in range(1, 7))
    write_german(folder / "Messung.csv", axes + ";X [mm];Y [mm];Z [mm]", [in_deg(q) + p for q, p in points])
    write_german(folder / "Ziele.csv", "X [mm];Y [mm];Z [mm];A (°);B (°);C (°)", [position(X) + in_deg(angles_abc(X)) for X in targets])
    archive = HERE.parent / "proto/krl_corpus/kss87"
    with zipfile.ZipFile(folder / "archive.zip", "w") as out:
        for file in sorted(archive.rglob("*")):
            out.write(file, file.relative_to(archive))


def largest_difference(arm, joints, targets):
    """Of the distances between reached positions from those between targets: no frame has to be aligned."""
    reached, wanted = [position(arm(q, 1)) for q in joints], [position(X) for X in targets]
    pairs = [(i, j) for i in range(len(wanted)) for j in range(i)]
    return max(abs(math.dist(reached[i], reached[j]) - math.dist(wanted[i], wanted[j])) for i, j in pairs)


def judge(name, joints_file):
    """@return whether the calibrated arm is better than 0.15 mm, as the nominal one is not"""
    arm, ranges = ARMS[name]
    targets = targets_of(arm, ranges)
    with open(joints_file, newline="") as file:
        joints = [[math.radians(float(row[f"q{i}"])) for i in range(1, 7)] for row in csv.DictReader(file)]
    if len(joints) != TARGETS:
        sys.exit(f"{joints_file}: {len(joints)} rows, expected {TARGETS}")
    X = [each for _, each in targets]
    before, after = largest_difference(arm, [q for q, _ in targets], X), largest_difference(arm, joints, X)
    print(f"distances between targets: wrong by up to {before:.3f} mm without, {after:.3f} mm with the calibrated model")
    return after < 0.15 < 1 < before


if __name__ == "__main__":
    arm_name, task, place = sys.argv[1:4]
    if task == "make":
        make(arm_name, pathlib.Path(place))
    else:
        sys.exit(0 if judge(arm_name, place) else 1)
