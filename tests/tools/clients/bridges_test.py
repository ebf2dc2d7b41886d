#!/usr/bin/env python3
"""The bridges of tools/examples before the stand-ins of their makers' software, and the simulated tracker behind these.

    bridges_test.py BIN SOURCE [unittest options]

Each keeps every promise that `truepose bridge-check` tries, ends a measurement whose beam breaks, and carries a campaign of
30 + 30 poses, whose residual is printed.
"""
import json
import math
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import unittest

from live_cell import PATIENCE_S, LiveCell

BIN, SOURCE = sys.argv[1:3]
EXAMPLES = pathlib.Path(SOURCE) / "tools/examples"
STAND_IN = pathlib.Path(__file__).resolve().parent / "stand_in"
NEST_MM = "1500,-900,-600"
NEST = "{x: 1500, y: -900, z: -600}"


def run(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=PATIENCE_S, check=False)


class Client:
    """A client of a bridge that says what it likes."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        self.lines, self.last_id = self.socket.makefile(), 0
        self.answer(self.ask("hello", protocol=1, client="bridges_test"))

    def ask(self, do, **members):
        self.last_id += 1
        self.socket.sendall((json.dumps({"id": self.last_id, "do": do} | members) + "\n").encode())
        return self.last_id

    def answer(self, request_id):
        """What comes up to this answer, which is the last."""
        said = [json.loads(self.lines.readline())]
        while said[-1].get("id") != request_id:
            said.append(json.loads(self.lines.readline()))
        return said

    def close(self):
        self.lines.close()
        self.socket.close()


class Bridges(unittest.TestCase):
    def spatial_analyzer(self, shot_ms=500):
        os.environ["PYTHONPATH"] = str(STAND_IN)
        self.addCleanup(os.environ.pop, "PYTHONPATH")
        return [sys.executable, EXAMPLES / "spatialanalyzer_bridge.py", "--listen", "127.0.0.1:0", "--shot-ms", str(shot_ms)]

    def lmf(self):
        if not (shutil.which("mcs") and shutil.which("mono")):
            self.skipTest("no Mono: tools/install-packages installs it")
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        sdk, program = folder / "LMF.Tracker.Connection.dll", folder / "LmfBridge.exe"
        for made in (run("mcs", "-warnaserror", "-target:library", "-r:System.Web.Extensions", f"-out:{sdk}", STAND_IN / "LmfStandIn.cs"),
                     run("mcs", "-warnaserror", "-r:System.Web.Extensions", f"-r:{sdk}", f"-out:{program}", EXAMPLES / "LmfBridge.cs",
                         EXAMPLES / "Bridge.cs")):
            self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
        return ["mono", program, "127.0.0.1:0", "Simulator"]

    def cell(self, bridge, speedup, target_6d=""):
        return self.enterContext(LiveCell(BIN, SOURCE, bridge=bridge, nests=NEST, speedup=speedup, target_6d=target_6d))

    def expect_all_promises(self, bridge, not_offered):
        cell = self.cell(bridge, speedup=20)
        cell.stop_daemon()
        code, out, err = cell.truepose("bridge-check", f"127.0.0.1:{cell.bridge_port}", "--at", NEST_MM, online=False)
        self.assertEqual(code, 0, out + err)
        self.assertEqual([line for line in out.splitlines() if not line.startswith(("ok", "skipped"))], [])
        skipped = [line for line in out.splitlines() if line.startswith("skipped")]
        self.assertEqual(len(skipped), len(not_offered) + 1, out)
        for sentence in [*not_offered, "the bridge does not offer to rehearse it"]:
            self.assertIn(sentence, out)
        self.expect_a_broken_beam_to_end_a_measurement(cell)

    def expect_a_broken_beam_to_end_a_measurement(self, cell):
        client = Client(cell.bridge_port)
        self.addCleanup(client.close)
        self.assertTrue(client.answer(client.ask("initialise"))[-1]["ok"])
        aim = dict(zip("xyz", map(float, NEST_MM.split(",")))) | {"search_mm": 50.0, "timeout_ms": 10000}
        said = [{"code": "no-target"}]
        while said[-1]["code"] == "no-target":  # the beam broke before the measurement had begun
            while not client.answer(client.ask("aim", **aim))[-1]["ok"]:
                pass  # it is still broken
            measuring = client.ask("measure", time_ms=200_000)
            self.assertEqual(client.answer(client.ask("status"))[-1]["state"], "busy")
            cell.steer({"kind": "beam-break", "lasts_ms": 300})
            said = client.answer(measuring)
            self.assertFalse(said[-1]["ok"])
        self.assertEqual(said[-1]["code"], "beam-broken", said)
        self.assertIn("beam-lost", [line.get("event") for line in said])
        self.assertEqual(client.answer(client.ask("measure", time_ms=500))[-1]["code"], "no-target")

    def expect_campaign(self, name, bridge, target_6d=""):
        cell = self.cell(bridge, 100, target_6d)
        code, out, err = cell.truepose("campaign", "start", "--watch")
        self.assertEqual(code, 0, out + err)
        found = cell.folder / "found.json"
        code, out, err = cell.truepose("campaign", "export", "--document", found)
        self.assertEqual(code, 0, out + err)
        document = json.loads(found.read_text())
        before, after = (document["validate"][stage]["mean"] for stage in ("before", "after"))
        print(f"{name}: validation error mean {before:.3f} mm -> {after:.3f} mm, RMS {document['validate']['after']['rms']:.3f} mm")
        self.assertEqual((document["identify"]["poses"], document["validate"]["poses"]), (30, 30))
        self.assertGreater(before, 5)
        self.assertLess(after, 0.05)  # as over emScon, from the same simulated arm
        return cell, document

    def test_the_one_for_spatial_analyzer_keeps_its_promises(self):
        self.expect_all_promises(self.spatial_analyzer(), ["SA's interface has no call that turns a tracker over"])

    def test_the_one_for_lmf_keeps_its_promises(self):
        self.expect_all_promises(self.lmf(), [])

    def test_the_one_for_spatial_analyzer_carries_a_campaign(self):
        self.expect_campaign("SpatialAnalyzer", self.spatial_analyzer())

    def test_the_one_for_lmf_carries_a_campaign(self):
        self.expect_campaign("LMF", self.lmf())

    def test_the_one_for_lmf_carries_the_orientations_of_a_probe(self):
        cell, document = self.expect_campaign("LMF, probe", self.lmf(), "{orientation: {a: 20, b: -35, c: 70}, std_deg: 0.005}")
        mounted = document["targets"][0]
        for angle, wanted in (("rz", 20), ("ry", -35), ("rx", 70)):
            self.assertAlmostEqual(math.degrees(mounted[angle]), wanted, delta=0.5)  # with the error of the last joint's zero
        points = cell.folder / "points.csv"
        code, out, err = cell.truepose("campaign", "export", "--data", points)
        self.assertEqual(code, 0, out + err)
        self.assertIn("a,b,c,sigma_abc", points.read_text().splitlines()[0])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
