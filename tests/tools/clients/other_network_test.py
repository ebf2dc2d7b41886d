#!/usr/bin/env python3
"""A panel's story from another machine: connect, campaign, report, activate, arm, fault, acknowledge, over TLS and over OPC UA.

    other_network_test.py BIN SOURCE SERVER    SERVER: the folder of tools/install-opcua; ends 77 where no networks can be made
"""
import json
import os
import pathlib
import subprocess
import sys

from live_cell import PATIENCE_S, LiveCell
from two_networks import CELL, OtherMachine, enter_own_network

HERE = pathlib.Path(__file__).parent


def over_opcua(bin_folder, source, server):
    """opcua_test.mjs runs on the other machine; cell, daemon and OPC UA server are here."""
    story = "trust list is refused|Nobody is let in|The cell.s state is shown|started, paused, resumed|may activate a model|armed and disarmed|A fault is an alarm"
    here = f"nsenter -t {os.getpid()} -n"
    with OtherMachine() as machine:
        done = subprocess.run(machine.there("node", f"--test-name-pattern={story}", HERE / "opcua_test.mjs", bin_folder, source, server),
                              env=os.environ | {"TRUEPOSE_CELL_NETWORK": here, "TRUEPOSE_CELL_HOST": CELL},
                              capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    if done.returncode != 0 or "pass 7" not in done.stdout:
        sys.exit(f"other_network_test.py: {done.stdout}{done.stderr}")


def over_tls(bin_folder, source):
    examples = pathlib.Path(source) / "tools/examples"
    with OtherMachine() as machine, LiveCell(bin_folder, source, tls=True, host=CELL) as cell:
        token, ca = cell.access("Anna", "engineer"), cell.folder / "tls/ca.pem"
        (cell.folder / "anna").write_text(token)

        def there(*words):
            done = subprocess.run(machine.there(sys.executable, *words), capture_output=True, text=True,
                                  timeout=PATIENCE_S, check=False)
            if done.returncode != 0:
                sys.exit(f"other_network_test.py: {words[0]}: {done.stdout}{done.stderr}")
            return done.stdout

        clear = f"import socket; socket.create_connection(('{CELL}', {cell.port}), 5)"
        refused = subprocess.run(machine.there(sys.executable, "-c", clear), capture_output=True, text=True,
                                 timeout=PATIENCE_S, check=False)
        assert "ConnectionRefusedError" in refused.stderr, "the port in the clear is reached from another machine"

        report = cell.folder / "report.json"
        said = there(examples / "campaign.py", f"{CELL}:{cell.tls_port}", "--ca", ca, "--token-file", cell.folder / "anna",
                     "--identify", "12", "--validate", "6", "--report", report)
        assert "is active" in said, said
        assert json.loads(report.read_text())["validate"]["poses"] == 6
        story = HERE / "panel_story.py", examples, CELL, cell.tls_port, ca, token
        there(*story, "arm")
        cell.steer({"kind": "eki-drop", "lasts_ms": 8000 * cell.speedup})
        said = there(*story, "fault")
        assert "fault: " in said, said
        records = json.loads(cell.truepose("audit", "list", "--json")[1])["records"]
        assert any(record.get("method") == "cell.acknowledge" for record in records), records[-3:]


if __name__ == "__main__":
    enter_own_network()
    over_tls(*sys.argv[1:3])
    over_opcua(*sys.argv[1:4])
