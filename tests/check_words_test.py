#!/usr/bin/env python3
"""tools/check-words finds what is wrong with a page, and nothing where nothing is.

    check_words_test.py ROOT [unittest options]
"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv.pop(1))
GOOD = "# A page\n\nThis page has a link to [a section](#a-section).\n\n## A section\n\nIt is short.\n"


class CheckWords(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        (pathlib.Path(self.folder.name) / "config").mkdir()

    def check(self, text, *options):
        (pathlib.Path(self.folder.name) / "page.md").write_text(text, encoding="utf-8")
        return subprocess.run([ROOT / "tools/check-words", "--root", self.folder.name, *options, "page.md"], capture_output=True, text=True, check=False)

    def assert_found(self, what, text, *options):
        done = self.check(text, *options)
        if done.returncode == 77:
            self.skipTest(done.stdout)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn(what, done.stdout)
        self.assertIn(", 1 faults", done.stdout)

    def assert_good(self, text, *options):
        done = self.check(text, *options)
        if done.returncode == 77:
            self.skipTest(done.stdout)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_good_page_has_no_fault(self):
        self.assert_good(GOOD, "--words")

    def test_a_long_sentence_is_found_with_its_line(self):
        self.assert_found("page.md:9: a sentence of 36 words", GOOD + "\n" + "\n".join(["word " * 6] * 6).replace("word", "Word", 1).rstrip() + ".\n", "--words")

    def test_a_page_of_long_sentences_is_found(self):
        self.assert_found("the median sentence has 18 words", "# A page\n\n" + ("Word " + "word " * 16 + "word.\n") * 3, "--words")

    def test_a_sentence_of_a_table_is_judged_too(self):
        self.assert_found("a sentence of 40 words", GOOD + "\n| a |\n| --- |\n| " + "ab " * 40 + "|\n", "--words")

    def test_a_phrase_that_has_a_term_of_the_field_is_found(self):
        self.assert_found("'gross errors' has a term", GOOD + "\nThese are gross errors.\n", "--words")
        self.assert_good(GOOD + "\nThese are `gross errors`.\n", "--words")

    def test_a_long_line_is_found_also_in_code(self):
        self.assert_found("141 columns", GOOD + "\n```text\n" + "x" * 141 + "\n```\n", "--words")
        self.assert_good(GOOD + "\n```jsonl\n" + "x" * 141 + "\n```\n", "--words")

    def test_a_long_page_is_found(self):
        self.assert_found("401 lines", GOOD + "\n" * (401 - GOOD.count("\n")), "--words")

    def test_a_dead_link_and_a_dead_anchor_are_found(self):
        self.assert_found("the link other.md leads to no file", GOOD + "\nSee [other](other.md).\n", "--words")
        self.assert_found("the link #nowhere leads to no heading", GOOD + "\nSee [nowhere](#nowhere).\n", "--words")

    def test_a_test_that_does_not_exist_is_found(self):
        self.assert_found("no test is named Nothing.*", GOOD + "\nRun `core_test --gtest_filter='Nothing.*'`.\n", "--words")

    def test_a_block_that_is_not_run_needs_a_reason(self):
        self.assert_found("a block of sh that is not in NOT_RUN", GOOD + "\n```sh\nreboot\n```\n", "--words")

    def test_a_message_is_judged_as_one_where_its_text_is_broken(self):
        source = pathlib.Path(self.folder.name) / "daemon/a.cpp"
        source.parent.mkdir()

        def judged(text):
            source.write_text(text, encoding="utf-8")
            return subprocess.run([ROOT / "tools/check-words", "--root", self.folder.name, "--messages"], capture_output=True, text=True, check=False)

        self.assertEqual(judged('// told\nsay("the arm stands", kTold);\n').returncode, 0)
        self.assertIn("daemon/a.cpp:2: 'so that' has a term", judged('// a\nsay("it stands, so "\n    "that it is dry");\n').stdout)
        self.assertIn("a clause of 26 words", judged('say("' + "word " * 26 + '");\n').stdout)

    def test_commands_print_what_the_page_shows(self):
        self.assert_good(GOOD + "\n```console\n$ printf 'one\\ntwo 2.50\\nthree\\n'\none\ntwo ...\n...\n$ cat <<END\n> four\n> END\nfour\n```\n")

    def test_another_output_is_found(self):
        self.assert_found("prints something else", GOOD + "\n```console\n$ echo 0.037\n0.038\n```\n")

    def test_more_output_than_is_shown_is_found(self):
        self.assert_found("prints something else", GOOD + "\n```console\n$ printf 'one\\ntwo\\n'\none\n```\n")

    def test_a_command_that_fails_is_found_and_may_be_announced(self):
        self.assert_found("ended with 1, not 0", GOOD + "\n```console\n$ false\n```\n")
        self.assert_good(GOOD + "\n```console\n$ false  # exit 1\n```\n")
        self.assert_found("ended with 0, not 1", GOOD + "\n```console\n$ true  # exit 1\n```\n")

    def test_one_session_has_one_folder_and_its_variables(self):
        self.assert_good(GOOD + "\n```console\n$ mkdir a && cd a && word=here\n```\n\n```console\n$ basename $PWD; echo $word\na\nhere\n```\n")

    def test_a_program_in_the_background_is_waited_for_and_ends_with_the_page(self):
        # What is left of a page is a program without a parent of ours: its processes have a number space of their own.
        self.assert_good(GOOD + "\n```console\n$ { read line <wait; echo ready; exec tail -f /dev/null; } &\n```\n".replace(
            "$ {", "$ mkfifo wait; (echo x >wait &)\n$ {").replace("} &\n", "} &\nready\n"))


if __name__ == "__main__":
    unittest.main()
