#!/usr/bin/env python3
"""The clients of tools/examples, each as its page says, before a real daemon and the simulated cell.

    examples_test.py BIN SOURCE [unittest options]
"""
import json
import pathlib
import shutil
import subprocess
import sys
import unittest

from live_cell import PATIENCE_S, LiveCell

BIN, SOURCE = sys.argv[1:3]
EXAMPLES = pathlib.Path(SOURCE) / "tools/examples"
POSES = ["12", "6"]
DONE = r"done: (\d+) of \1 poses"


def run(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=PATIENCE_S, check=False)


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cell = cls.enterClassContext(LiveCell(BIN, SOURCE, tls=True))
        cell = cls.cell
        cls.plain, cls.secure = f"127.0.0.1:{cell.port}", f"127.0.0.1:{cell.tls_port}"
        cls.ca = cell.folder / "tls/ca.pem"
        cls.token_file = cell.folder / "engineer"
        cls.token_file.write_text(cell.access("Engineer", "engineer"))
        cell.made("tls", "client", "Panel 1", "--dir", cell.folder / "tls")
        cls.by_certificate = ["--cert", cell.folder / "tls/Panel-1.pem", "--key", cell.folder / "tls/Panel-1.key"]
        cell.access("Panel 1", "operator", "--certificate", cell.folder / "tls/Panel-1.pem")

    def expect_campaign(self, done, report):
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, DONE)
        self.assertIn("is active", done.stdout)
        self.assertEqual(json.loads(report.read_text())["validate"]["poses"], 6)
        status = json.loads(self.cell.truepose("status", "--json")[1])
        self.assertIn(status["model"]["id"], done.stdout)

    def python(self, *words):
        report = self.cell.folder / "python.json"
        poses = ["--identify", POSES[0], "--validate", POSES[1], "--report", report]
        return run(sys.executable, EXAMPLES / "campaign.py", *words, *poses), report

    def test_the_python_client_runs_a_campaign_over_tcp_with_a_token(self):
        self.expect_campaign(*self.python(self.plain, "--token-file", self.token_file))

    def test_the_python_client_runs_a_campaign_over_tls_with_a_token(self):
        self.expect_campaign(*self.python(self.secure, "--ca", self.ca, "--token-file", self.token_file))

    def test_the_python_client_is_known_by_its_certificate_and_says_what_that_may_not(self):
        done, _ = self.python(self.secure, "--ca", self.ca, *self.by_certificate)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stdout, DONE)
        self.assertIn("model.activate needs the role engineer; Panel 1 is operator", done.stderr)

    def test_the_python_client_talks_to_no_daemon_of_another_ca(self):
        self.cell.made("tls", "init", "--dir", self.cell.folder / "other", "--host", "127.0.0.1")
        done, _ = self.python(self.secure, "--ca", self.cell.folder / "other/ca.pem", "--token-file", self.token_file)
        self.assertEqual(done.returncode, 1)
        self.assertIn("certificate verify failed", done.stderr)

    @unittest.skipUnless(shutil.which("mcs") and shutil.which("mono"), "no Mono: tools/install-packages installs it")
    def test_the_csharp_client_runs_a_campaign(self):
        program, report = self.cell.folder / "Campaign.exe", self.cell.folder / "csharp.json"
        made = run("mcs", "-warnaserror", "-r:System.Web.Extensions", f"-out:{program}", EXAMPLES / "Campaign.cs")
        self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
        self.expect_campaign(run("mono", program, self.plain, self.token_file, report, *POSES), report)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
