"""What a panel does after a campaign, from another machine over TLS, with the client of tools/examples.

    panel_story.py EXAMPLES HOST PORT CA TOKEN arm|fault
"""
import ssl
import sys
import time

sys.path.insert(0, sys.argv[1])
from campaign import Daemon, Refused  # noqa: E402  of EXAMPLES


def state(daemon):
    return daemon.call("cell.status")["state"]


def arm(daemon):
    daemon.command("stream.arm")
    assert state(daemon) == "armed", state(daemon)
    daemon.command("stream.disarm")
    while state(daemon) != "disconnected":
        time.sleep(0.05)


def fault(daemon):
    """The robot's link is broken; it comes back after some seconds."""
    try:
        daemon.command("cell.connect")
        raise AssertionError("it connected over a broken link")
    except Refused as refusal:
        print(f"connect: {refusal}")
    found = daemon.call("cell.status")
    assert found["state"] == "fault", found["state"]
    print(f"fault: {found['faults'][0]['text']}")
    daemon.command("cell.acknowledge")
    assert state(daemon) == "disconnected", state(daemon)
    while True:
        try:
            daemon.command("cell.connect")
            break
        except Refused:
            daemon.command("cell.acknowledge")
            time.sleep(0.2)
    assert state(daemon) == "ready", state(daemon)


host, port, ca, token, part = sys.argv[2:]
panel = Daemon(host, int(port), token, ssl.create_default_context(cafile=ca))
{"arm": arm, "fault": fault}[part](panel)
