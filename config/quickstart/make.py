#!/usr/bin/env python3
"""Makes the quickstart data: a simulated KR 210 with the errors of Table 2 of the method's paper, measured by a simulated tracker.

    make.py BIN    BIN: the folder of the program truepose

The arm, the poses and every flange pose come from truepose itself (plan, fk, compensate). This script adds the mounting and the noise, from a seed.
"""
import csv
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
TRUEPOSE = pathlib.Path(sys.argv[1]) / "truepose"
SIGMA_MM = math.hypot(0.010, 0.016592)  # the tracker's and, per axis, that of an arm with RP = 0.06 mm
ERRORS = [  # a, alpha, d, theta, beta of each joint; mm and rad
    (0.45, 0.003, 0.72, 0.0015, 0), (0.63, 0.002, 0.43, 0.0032, 0), (0.55, 0.003, 0.21, 0.0026, 0.001),
    (0.32, 0.006, 0.32, 0.0018, 0), (0.72, 0.004, 0.51, 0.0012, 0), (0.23, 0.005, 0.62, 0.0022, 0)]
NOMINAL = [(0, 0, 645, 0, -1, -185, 185, 116.8), (330, -90, 0, 0, 1, -140, -5, 111.4), (1150, 0, 0, -90, 1, -120, 168, 112),
           (115, -90, 1220, 0, -1, -350, 350, 179), (0, 90, 0, 0, 1, -125, 125, 172), (0, -90, 215, 180, -1, -350, 350, 220)]
BASE = (3387.4, 452.8, -1251.6, 164.82, 0.37, -0.24)  # in the tracker's frame
DOOR = (2210.0, -1630.5, -1249.1, 121.3, -0.15, 0.22)  # the same from a second station
REFLECTOR = (62, -48, 187)  # in the flange frame
TCP = {"origin": (120.4, -3.2, 342.7), "x": (220.4, -3.2, 342.7), "xy": (120.4, 96.8, 342.7)}
FIXTURE = (1500, 300, 700, 30, 0, 0)
ROOT = (1902.1, 351.4, -148.6, 25.15, 0.1, -0.1)  # of the positioner; the controller has 1900, 350, -150, 25, 0, 0
draw = random.Random(20261129)


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def moved(pose, point):
    return [sum(pose[i][k] * point[k] for k in range(3)) + pose[i][3] for i in range(3)]


def frame(x, y, z, a, b, c):
    """KUKA's Rz(a) Ry(b) Rx(c), deg."""
    ca, sa, cb, sb, cc, sc = (f(math.radians(angle)) for angle in (a, b, c) for f in (math.cos, math.sin))
    return [[ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc, x],
            [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc, y], [-sb, cb * sc, cb * cc, z], [0, 0, 0, 1]]


def truepose(*arguments):
    done = subprocess.run([TRUEPOSE, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"truepose {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def robot_text(name, comment, joints):
    lines = [f"# {comment}", f"name: {name}",
             "joints:               # base to flange; mm, deg, deg/s; theta = sign * q + theta0"]
    lines += ["  - {a: %.10g, alpha: %.10g, d: %.10g, theta: %.10g, beta: %.10g, sign: %d, min: %g, max: %g, speed: %g}" % joint for joint in joints]
    return "\n".join([*lines, "flange: {x: 0, y: 0, z: 0, a: 0, b: 0, c: 0}", ""])


def write(name, head, rows):
    with open(HERE / name, "w", newline="\n", encoding="utf-8") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(head)
        writer.writerows(rows)


def read_joints(path):
    with open(path, encoding="utf-8") as rows:
        return [[float(row[f"q{i}"]) for i in range(1, 7)] for row in csv.DictReader(rows)]


class Arm:
    """The true arm, as truepose fk has it."""

    def __init__(self, folder):
        self.folder = folder
        self.robot = folder / "true.yaml"
        deg = math.degrees
        true = [(a + e[0], alpha + deg(e[1]), d + e[2], theta + deg(e[3]), deg(e[4]), *rest)
                for (a, alpha, d, theta, *rest), e in zip(NOMINAL, ERRORS)]
        self.robot.write_text(robot_text("true", "the true arm", true), encoding="utf-8")

    def flanges(self, joints, robot=None):
        path = self.folder / "joints.csv"
        path.write_text("\n".join(["q1,q2,q3,q4,q5,q6", *(",".join(map(repr, q)) for q in joints)]) + "\n", encoding="utf-8")
        poses = json.loads(truepose("fk", "--robot", robot or self.robot, "--joints", path, "--json"))["poses"]
        return [[pose[4 * i:4 * i + 4] for i in range(4)] for pose in poses]


def noisy(point, sigma=SIGMA_MM):
    return [f"{one + draw.gauss(0, sigma):.3f}" for one in point]


def angles(q):
    return [f"{one:.4f}" for one in q]


def seen(base, flange, offset=REFLECTOR):
    return moved(product(frame(*base), flange), offset)


def poses(folder, count, seed):
    path = folder / "plan.csv"
    truepose("plan", "--cell", HERE.parent / "cell.yaml", "--poses", count, "--seed", seed, "--out", path)
    return [[round(one, 4) for one in q] for q in read_joints(path)]


def arm_files(arm, folder):
    (HERE / "arm.yaml").write_text(robot_text("KUKA KR 210 R2700-2", "The nominal arm. Its convention: docs/robot-files.md", [
        (a, alpha, d, theta, 0, sign, low, high, speed) for a, alpha, d, theta, sign, low, high, speed in NOMINAL]), encoding="utf-8")
    head = [*(f"q{i}" for i in range(1, 7)), "x", "y", "z"]
    joints = poses(folder, 60, 1)
    write("points.csv", head, [angles(q) + noisy(seen(BASE, pose)) for q, pose in zip(joints, arm.flanges(joints))])
    joints = poses(folder, 12, 2)
    write("door.csv", head, [angles(q) + noisy(seen(DOOR, pose)) for q, pose in zip(joints, arm.flanges(joints))])
    joints = poses(folder, 5, 3)  # later: the zero of axis 3 has slipped
    slipped = [[*q[:2], q[2] + 0.0123, *q[3:]] for q in joints]
    write("five.csv", head, [angles(q) + noisy(seen(BASE, pose)) for q, pose in zip(joints, arm.flanges(slipped))])
    write("joints.csv", head[:6], [(20, -80, 100, 30, a5, -40) for a5 in (45, 5, 0)])
    head = ["x", "y", "z", "a", "b", "c"]
    write("targets.csv", head, [(1500, -400, 900, 0, 90, 0), (1500, 0, 1200, 10, 80, 0), (1700, 300, 1000, 0, 100, 15)])
    write("fixture_targets.csv", head,
          [(0, 0, 0, 0, 90, 0), (200, 0, 0, 0, 90, 0), (200, 150, 0, 10, 80, 0), (0, 150, 50, 0, 90, 15)])


def tool_and_base(arm, folder):
    head = [*(f"q{i}" for i in range(1, 7)), "point", "x", "y", "z"]
    joints = poses(folder, 12, 4)
    names = ["origin"] * 10 + ["x", "xy"]
    write("tool.csv", head, [[*angles(q), name, *noisy(seen(BASE, pose, TCP[name]))]
                             for q, name, pose in zip(joints, names, arm.flanges(joints))])
    points = {"origin": (0, 0, 0), "x": (400, 0, 0), "xy": (0, 300, 0)}
    write("base.csv", ["point", "x", "y", "z"],
          [[name, *noisy(seen(BASE, frame(*FIXTURE), point), 0.01)] for name, point in points.items()])


def model(folder):
    out = folder / "model.yaml"
    document = json.loads(truepose("calibrate", "--robot", HERE / "arm.yaml", "--data", HERE / "points.csv", "--split", 0.7, "--out", out, "--json"))
    return out, [document["smr"]["1"][axis] for axis in "xyz"]


def cycles(arm, folder):
    """30 cycles at the five points of a cube, commanded by the calibrated arm."""
    path, reflector = model(folder)
    targets = list(csv.DictReader(truepose("iso9283", "--cube", "1700,0,1100,800").splitlines()))
    turn = frame(0, 0, 0, 0, 90, 0)
    flanges = [[float(row[axis]) - moved(turn, reflector)[i] for i, axis in enumerate("xyz")] for row in targets]
    wanted = folder / "wanted.csv"
    wanted.write_text("\n".join(["x,y,z,a,b,c", *(",".join(map(repr, [*at, 0, 90, 0])) for at in flanges)]) + "\n", encoding="utf-8")
    truepose("compensate", "--robot", HERE / "arm.yaml", "--model", path, "--poses", wanted, "--near", "0,-90,90,0,35,0", "--out", folder / "at.csv")
    reached = [seen(BASE, pose) for pose in arm.flanges(read_joints(folder / "at.csv"))]
    write("iso.csv", ["point", "x", "y", "z"], [[row[name] for name in ("point", "x", "y", "z")] for row in targets])
    write("cycles.csv", ["point", "cycle", "x", "y", "z"],
          [[row["point"], cycle, *noisy(at)] for cycle in range(1, 31) for row, at in zip(targets, reached)])


def positioner(arm, folder):
    joints = [(0, 90, 0, 0, 0, 1, -90, 90, 60), (120, -90, 250, 0, 0, 1, -185, 185, 60)]
    (HERE / "table.yaml").write_text(robot_text("tilt and turn table", "A positioner: its base is the root, its flange the table", joints), encoding="utf-8")
    true = folder / "table.yaml"
    true.write_text(robot_text("true", "the true table", [(0, 90.02, 0.2, 0, 0, 1, -90, 90, 60), (120.3, -90.015, 250.2, 0, 0, 1, -185, 185, 60)]),
                    encoding="utf-8")

    def tables(turns):
        path = folder / "turns.csv"
        path.write_text("\n".join(["q1,q2", *(f"{a},{b}" for a, b in turns)]) + "\n", encoding="utf-8")
        found = json.loads(truepose("fk", "--robot", true, "--joints", path, "--json"))["poses"]
        return [product(frame(*BASE), product(frame(*ROOT), [pose[4 * i:4 * i + 4] for i in range(4)])) for pose in found]

    reflectors = {"a": (350, 0, 20), "b": (-180, 300, 20), "c": (-170, -310, 30), "d": (60, 80, 160)}
    turns = [(tilt, turn) for tilt in (-60, -20, 20, 60) for turn in (-170, -110, -50, 10, 70, 130)]
    draw.shuffle(turns)
    write("table.csv", ["q1", "q2", "smr", "x", "y", "z"],
          [[*turn, name, *noisy(moved(pose, at), 0.015)] for turn, pose in zip(turns, tables(turns)) for name, at in reflectors.items()])
    turns = [(-40, -90), (-10, 0), (25, 60), (50, 150)]
    points = {"origin": (0, 0, 0), "x": (300, 0, 0), "xy": (0, 250, 0)}
    part = frame(40, -30, 60, 15, 0, 0)
    write("workpiece.csv", ["q1", "q2", "point", "x", "y", "z"],
          [[*turn, name, *noisy(moved(product(pose, part), at), 0.015)] for turn, pose in zip(turns, tables(turns)) for name, at in points.items()])
    write("part_targets.csv", ["x", "y", "z", "a", "b", "c", "e1", "e2"], [(100, 50, 0, 180, 0, 180, 0, 0), (100, 150, 0, 180, 0, 180, 10, 30)])


with tempfile.TemporaryDirectory() as name:
    work = pathlib.Path(name)
    true_arm = Arm(work)
    arm_files(true_arm, work)
    tool_and_base(true_arm, work)
    cycles(true_arm, work)
    positioner(true_arm, work)
