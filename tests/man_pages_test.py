#!/usr/bin/env python3
"""The man pages: man_pages_test.py SOURCE BIN"""
import gzip
import importlib.machinery
import importlib.util
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE, BIN = map(pathlib.Path, sys.argv[1:3])


def tool():
    loader = importlib.machinery.SourceFileLoader("man_pages", str(SOURCE / "tools/man-pages"))
    sys.dont_write_bytecode = True
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("man_pages", loader))
    loader.exec_module(module)
    return module


class ManPages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        subprocess.run([SOURCE / "tools/man-pages", "--bin", BIN, "--out", cls.folder], check=True)
        cls.pages = {file.name.removesuffix(".gz"): gzip.decompress(file.read_bytes()).decode()
                     for file in cls.folder.glob("man*/*.gz")}

    def test_every_program_and_command_has_one_that_man_finds(self):
        module = tool()
        commands = {command for program in module.PROGRAMS for command, _ in module.commands_of(BIN, program)}
        self.assertGreater(len(commands), 50)
        self.assertEqual({name.rsplit(".", 1)[0] for name in self.pages}, {command.replace(" ", "-") for command in commands})
        self.assertEqual(set(module.PAGES) - commands, set(), "a command of PAGES is gone")
        for file in self.folder.glob("man*/*.gz"):
            found = subprocess.run(["lexgrog", file], capture_output=True, text=True, check=False)
            self.assertEqual(found.returncode, 0, found.stdout)

    def test_each_is_right_roff(self):
        for name, text in self.pages.items():
            judged = subprocess.run(["mandoc", "-T", "lint", "-W", "warning"], input=text, capture_output=True, text=True, check=False)
            faults = [line for line in judged.stdout.splitlines() if "missing date" not in line and "skipping paragraph macro" not in line]
            self.assertEqual(faults, [], name)

    def test_it_has_the_options_of_the_help_and_the_section_of_the_page(self):
        drift = self.pages["truepose-drift.1"]
        self.assertIn("\\-\\-update", drift)
        self.assertIn("Bring base, reflectors and joint zeros up to date", drift)
        self.assertIn("Five new points, spread over all joints", drift)
        self.assertIn("truepose\\-sim", self.pages["truepose-sim.1"])
        self.assertIn("truepose daemon", self.pages["truepose-opcua.1"])
        self.assertIn("\\-\\-policies LIST", self.pages["truepose-opcua.1"])
        self.assertIn(".SH COMMANDS", self.pages["truepose-campaign.1"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
