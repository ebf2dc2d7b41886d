#!/usr/bin/env python3
"""The daemon's own web page in a real browser, before a real daemon and the simulated cell.

    dashboard_test.py BIN SOURCE    ends 77 where there is no Chromium
"""
import json
import shutil
import socket
import sys
import tempfile
import unittest
import urllib.request

from chromium import Page, until
from live_cell import TOKEN, LiveCell

BIN, SOURCE = sys.argv[1:3]
SHOWN = """({
  state: by("state").innerText, why: by("why").innerText, refused: by("refused").innerText,
  asks: by("login").checkVisibility(), kept: sessionStorage.getItem("token"),
  robot: by("robot").innerText, events: [...by("events").children].map(line => line.innerText),
  green: [...document.querySelectorAll(".good")].filter(one => one.checkVisibility()).map(one => one.innerText),
})"""


class Client:
    """A session over TCP, closed with its test."""

    def __init__(self, test, port):
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._lines = self._socket.makefile()
        test.addCleanup(self.close)
        self.welcome = self.call("session.hello", protocol=1, token=TOKEN)

    def call(self, method, **params):
        self._socket.sendall((json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}) + "\n").encode())
        while "id" not in (told := json.loads(self._lines.readline())):
            pass
        return told

    def close(self):
        self._lines.close()
        self._socket.close()


class Dashboard(unittest.TestCase):
    def setUp(self):
        self.cell = self.enterContext(LiveCell(BIN, SOURCE))
        self.token = self.cell.access("Panel", "viewer")

    def open(self, after=""):
        folder = self.enterContext(tempfile.TemporaryDirectory(ignore_cleanup_errors=True))
        self.page = self.enterContext(Page(folder, f"http://127.0.0.1:{self.cell.web_port}/{after}"))

    def shown(self):
        return self.page.value(SHOWN) or {"state": "", "why": "", "asks": False}

    def until_shown(self, condition):
        return until(lambda: condition(shown := self.shown()) and shown, self.shown)

    def until_live(self):
        return self.until_shown(lambda shown: shown["state"] == "ready")

    def sessions(self):
        text = urllib.request.urlopen(f"http://127.0.0.1:{self.cell.web_port}/metrics").read().decode()
        return [int(line.split()[1]) for line in text.splitlines() if line.startswith("truepose_control_sessions ")][0]

    def test_of_a_daemon_that_does_not_answer_nothing_is_shown_until_it_does(self):
        self.cell.truepose("connect")
        self.open(f"#token={self.token}")
        self.assertIn("ready", self.until_live()["green"])
        self.cell.freeze_daemon()
        silent = self.until_shown(lambda shown: shown["state"] == "no connection")
        self.assertIn("no answer", silent["why"])
        self.assertEqual(silent["green"], [])
        self.assertEqual(silent["robot"], "")
        self.assertFalse(silent["asks"])
        self.until_shown(lambda shown: "no answer of the daemon" in shown["why"])  # where it connects again
        self.cell.thaw_daemon()
        self.assertIn("connected", self.until_live()["robot"])
        until(lambda: self.sessions() == 1, self.sessions)

    def test_a_panel_given_its_token_outlives_every_refusal_but_that_of_the_token(self):
        self.cell.truepose("connect")
        crowd = [Client(self, self.cell.port)]
        while "error" not in crowd[-1].welcome:
            crowd.append(Client(self, self.cell.port))
        self.open(f"#token={self.token}")
        waiting = self.until_shown(lambda shown: "sessions open already; trying again" in shown["why"])
        self.assertFalse(waiting["asks"])
        for client in crowd:
            client.close()
        self.until_live()
        self.cell.stop_daemon()
        self.until_shown(lambda shown: "cannot be reached; trying again" in shown["why"])
        self.cell.start_daemon()
        self.until_shown(lambda shown: shown["state"] == "disconnected")
        self.cell.made("access", "revoke", "Panel", "--cell", self.cell.cell_file)
        asks = self.until_shown(lambda shown: shown["asks"])
        self.assertIn("wrong token", asks["refused"])
        self.assertIsNone(asks["kept"])

    def test_who_gives_a_token_at_once_has_one_session_and_sees_each_event_once(self):
        self.cell.truepose("connect")
        self.open()
        self.until_shown(lambda shown: shown["asks"])
        self.page.value(f'by("token").value = "{self.token}"; document.querySelector("form button").click()')
        self.until_live()
        # Until the daemon would long have closed what said no hello, and the page come back.
        until(lambda: self.shown() and self.page.sockets[1].count("cell.status") >= 5, lambda: self.page.sockets)
        operator = Client(self, self.cell.port)
        operator.call("control.acquire")
        operator.call("control.release")
        operator.close()
        told = self.until_shown(lambda shown: any("control released" in line for line in shown["events"]))["events"]
        self.assertEqual(sum("control released" in line for line in told), 1, told)
        self.assertEqual(len(self.page.sockets), 2)
        until(lambda: self.sessions() == 1, self.sessions)

    def buttons(self):
        return self.page.value('[...document.querySelectorAll("#buttons button")].map(one => one.dataset.method)') or []

    def status(self):
        client = Client(self, self.cell.port)
        status = client.call("cell.status")["result"]
        client.close()
        return status

    def commands(self):
        """What the page has buttons for, of what the cell allows."""
        named = json.loads(self.page.value("JSON.stringify(Object.keys(kCommands))") or "[]")  # while it loads
        return sorted(method for method in self.status()["allowed"] if method in named)

    def test_has_a_button_for_what_an_operator_may_do_and_none_for_who_may_not(self):
        operator = self.cell.access("Operator", "operator")
        self.open(f"#token={self.token}")
        self.until_shown(lambda shown: shown["state"] == "disconnected")
        self.assertEqual(self.buttons(), [])
        self.open(f"#token={operator}")
        until(lambda: sorted(self.buttons()) == self.commands() != [], self.buttons)
        self.page.value("document.querySelector('[data-method=\"cell.connect\"]').click()")
        self.until_live()
        until(lambda: sorted(self.buttons()) == self.commands() and "cell.disconnect" in self.buttons(), self.buttons)
        self.assertIn("A1 ", self.shown()["robot"])

    def test_shows_in_every_state_what_the_command_line_shows(self):
        operator = self.cell.access("Operator", "operator")
        self.open(f"#token={operator}")

        def agrees(state):
            def same():
                now, shown = self.status(), self.shown()
                said = self.cell.truepose("status")[1]
                return (now["state"] == shown["state"] == state and shown["why"] == now["state_text"] and shown["why"] in said
                        and self.page.value('by("next").innerText') and sorted(self.buttons()) == self.commands())
            until(same, lambda: (state, self.status()["state_text"], self.shown()["why"], self.buttons(), self.commands()))

        agrees("disconnected")
        self.cell.truepose("connect")
        agrees("ready")
        self.cell.truepose("campaign", "start")
        self.cell.truepose("campaign", "pause")
        agrees("paused")
        self.cell.truepose("campaign", "abort")
        agrees("ready")
        self.cell.steer({"kind": "eki-drop", "lasts_ms": 6_000_000})
        agrees("fault")
        self.assertNotIn("none", self.shown()["green"])

    def test_shows_an_interrupted_campaign_with_both_ways_on_as_the_command_line_does(self):
        operator = self.cell.access("Operator", "operator")
        self.cell.truepose("campaign", "start")
        until(lambda: (self.status()["campaign"] or {}).get("done", 0) > 0, self.status)
        self.cell.kill_daemon()
        self.cell.start_daemon()
        self.open(f"#token={operator}")
        until(lambda: {"campaign.resume", "campaign.abort"} <= set(self.buttons()), self.buttons)
        text = self.page.value('by("interrupted").innerText')
        self.assertIn("the daemon ended in the middle of it", text)
        self.assertIn("the daemon ended in the middle of it", self.cell.truepose("status")[1])
        self.assertNotIn("none", self.shown()["green"])
        self.page.value("document.querySelector('[data-method=\"campaign.abort\"]').click()")
        until(lambda: not self.status()["interrupted"], self.status)
        until(lambda: "campaign.abort" not in self.buttons(), self.buttons)


if __name__ == "__main__":
    if not shutil.which("chromium"):
        print("dashboard_test.py: no Chromium: tools/install-packages installs it", file=sys.stderr)
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
