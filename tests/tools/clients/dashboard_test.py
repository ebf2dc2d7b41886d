#!/usr/bin/env python3
"""The daemon's own web page in a real browser, before a real daemon and the simulated cell.

    dashboard_test.py BIN SOURCE    ends 77 where there is no Chromium
"""
import json
import re
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


SAYS = """typeof by === "function" && by("state") && JSON.stringify({
  state: by("state").innerText, why: by("why").innerText, next: by("next").innerText,
  interrupted: [...by("interrupted").children].map(line => line.children[2].innerText.replace(/^.* poses: /, "")),
  faults: [...by("faults").children].map(line => [line.children[1].innerText, line.children[2].innerText]),
  buttons: [...document.querySelectorAll("#buttons button")].map(one => one.dataset.method),
})"""


def without_seconds(text):
    """The page asks at other times than the command line."""
    return re.sub(r"\d+ s\b", "? s", text)


class Client:
    """A session over TCP, closed with its test."""

    def __init__(self, test, port):
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._lines = self._socket.makefile()
        test.addCleanup(self.close)
        self.welcome = self.call("session.hello", protocol=1, token=TOKEN)

    def call(self, method, **params):
        self._socket.sendall((json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}) + "\n").encode())
        while "id" not in (reply := json.loads(self._lines.readline())):
            pass
        return reply

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

    def go(self, after):
        """Another load of the page, from wherever the daemon is."""
        self.page.go(f"http://127.0.0.1:{self.cell.web_port}/?{len(self.page.sockets)}{after}")

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
        self.open()
        crowd = [Client(self, self.cell.port)]
        while "error" not in crowd[-1].welcome:
            crowd.append(Client(self, self.cell.port))
        self.go(f"#token={self.token}")

        def is_waiting(shown):
            for client in crowd[:-1]:
                client.call("session.ping")  # none is closed for its silence, however long the page takes
            return "sessions open already; trying again" in shown["why"]

        waiting = self.until_shown(is_waiting)
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
        until(lambda: self.shown() and sum(socket.count("cell.status") for socket in self.page.sockets) >= 5,
              lambda: self.page.sockets)
        operator = Client(self, self.cell.port)
        operator.call("control.acquire")
        operator.call("control.release")
        operator.close()
        events = self.until_shown(lambda shown: any("control released" in line for line in shown["events"]))["events"]
        self.assertEqual(sum("control released" in line for line in events), 1, events)
        self.assertEqual(len([socket for socket in self.page.sockets if socket]), 1, self.page.sockets)
        until(lambda: self.sessions() == 1, self.sessions)

    def rpc(self, method, **params):
        """Asked with the daemon's own token, an admin's."""
        client = Client(self, self.cell.port)
        answer = client.call(method, **params)
        client.close()
        return answer

    def status(self):
        return json.loads(self.cell.truepose("status", "--json")[1])

    def page_says(self):
        says = json.loads(self.page.value(SAYS) or "{}")  # nothing while it loads
        return says and says | {"why": without_seconds(says["why"]), "buttons": sorted(says["buttons"])}

    def command_line_says(self):
        now = self.status()
        offered = json.loads(self.page.value("JSON.stringify(Object.keys(kCommands))") or "[]")
        faults = [[fault["code"], fault["text"]] for fault in now["faults"]]
        return {"state": now["state"], "why": without_seconds(now["state_text"]), "next": now["next"],
                "interrupted": [one["reason"] for one in now["interrupted"]], "faults": faults or [["none", ""]],
                "buttons": sorted(method for method in now["allowed"] if method in offered)}

    def agrees(self, state, *words, waits=False):
        """Waits until the page and the command line say the same of this state, with these words. waits: for an operator."""
        def same():
            said, shown = self.command_line_says(), self.page_says()
            return said == shown and said["state"] == state and all(word in str(said) for word in words) and said
        said = until(same, lambda: (state, words, self.command_line_says(), self.page_says()))
        table = self.cell.truepose("status")[1]
        self.assertIn(said["next"], table)
        for _, text in said["faults"]:
            self.assertIn(text, table)
        self.assertNotIn("not possible in state", self.refusal())
        if waits:
            self.assertNotIn("none", self.shown()["green"])
        return said

    def refusal(self):
        return self.page.value('by("refusal").innerText')

    def press(self, method):
        """Until that is answered. No state refuses what it has a button for."""
        self.pressed.add(method)
        self.page.value(f"""confirm = () => true; document.querySelector('[data-method="{method}"]').click()""")
        until(lambda: self.page.value("link.asked.size") == 0, self.page_says)

    def test_says_what_the_command_line_says_in_every_state_and_carries_out_each_button(self):
        self.pressed = set()
        self.open(f"#token={self.token}")
        self.until_shown(lambda shown: shown["state"] == "disconnected")
        self.assertEqual(self.page_says()["buttons"], [], "a viewer may command nothing")
        operator = self.cell.access("Operator", "operator")
        self.go(f"#token={operator}")

        self.agrees("disconnected", "Connect robot and tracker")
        self.press("cell.connect")
        self.agrees("ready")
        self.assertIn("A1 ", self.shown()["robot"])
        self.cell.steer({"kind": "emergency-stop"})
        self.agrees("ready", "robot: emergency stop: release it", "start truepose_motion")
        self.cell.steer({"kind": "emergency-stop", "lasts_ms": 1})
        self.agrees("ready", "Start a campaign")

        self.rpc("campaign.start", identify_poses=12, validate_poses=6, remeasure=False, activate=False)
        self.agrees("campaign", "Keep out of the cell")
        self.cell.steer({"kind": "emergency-stop"})  # with which it cannot end meanwhile
        self.agrees("campaign", "waiting for the controller", waits=True)
        self.press("campaign.pause")
        self.agrees("paused", "resume the campaign", waits=True)
        self.press("campaign.resume")
        self.agrees("campaign", "waiting for the controller", "emergency stop: release it", waits=True)
        self.cell.steer({"kind": "emergency-stop", "lasts_ms": 1})
        until(lambda: self.status()["state"] == "ready", self.status)
        self.rpc("model.activate", id=self.rpc("model.list")["result"]["models"][0]["id"])

        self.rpc("campaign.start", kind="base", number=5, points=["origin", "x", "xy"],
                 at=[[1400, -300, 500], [1800, -300, 500], [1400, 100, 500]])
        self.agrees("paused", "then resume the campaign", "Do what the state says", waits=True)
        self.press("campaign.abort")

        self.agrees("ready", "stream.arm")
        self.press("stream.arm")
        self.agrees("armed")
        self.press("stream.disarm")
        self.agrees("disconnected")
        self.press("cell.connect")
        self.agrees("ready")
        self.cell.truepose("stream", "start")
        self.agrees("streaming")
        self.press("stream.stop")
        self.agrees("ready")

        self.press("cell.disconnect")
        self.agrees("disconnected")
        self.cell.steer({"kind": "emergency-stop"})
        self.press("cell.connect")
        said = self.agrees("fault", "emergency stop: release it", "start truepose_motion", "then acknowledge the fault and connect", waits=True)
        self.assertEqual(said["faults"], [["E_CELL", said["why"]]])
        until(lambda: self.refusal() == said["why"], self.refusal)
        self.cell.steer({"kind": "emergency-stop", "lasts_ms": 1})
        self.press("cell.acknowledge")
        self.agrees("disconnected")
        self.press("cell.connect")
        self.agrees("ready")

        self.rpc("campaign.start")
        until(lambda: (self.status()["campaign"] or {}).get("done", 0) > 0, self.status)
        self.cell.kill_daemon()
        self.cell.start_daemon()
        self.go(f"#token={operator}")
        self.agrees("disconnected", "the daemon ended in the middle of it", "Resume the interrupted campaign, or abort it.",
                    "campaign.resume", waits=True)
        self.press("campaign.abort")
        self.agrees("disconnected", "Connect robot and tracker")
        self.assertEqual(self.status()["interrupted"], [])
        self.cell.steer({"kind": "tracker-silent"})
        self.press("cell.connect")
        self.agrees("connecting", "Wait until robot and tracker answer.")
        self.press("cell.disconnect")
        self.agrees("disconnected")
        offered = json.loads(self.page.value("JSON.stringify(Object.keys(kCommands))"))
        self.assertEqual(self.pressed, set(offered))


if __name__ == "__main__":
    if not shutil.which("chromium"):
        print("dashboard_test.py: no Chromium: tools/install-packages installs it", file=sys.stderr)
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
