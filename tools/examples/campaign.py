#!/usr/bin/env python3
"""Runs a calibration campaign at a truepose daemon, follows it, keeps its report, and activates the model that it made.

    campaign.py HOST:PORT --token-file FILE                        on the daemon's machine
    campaign.py HOST:PORT --ca ca.pem --cert me.pem --key me.key   from elsewhere, over TLS (or --ca with --token-file)

Python's standard library is enough. proto/control/reference.md has each method and event.
"""
import argparse
import json
import pathlib
import socket
import ssl
import sys
import uuid


class Refused(Exception):
    """What the daemon refused, in its own words."""


class Daemon:
    """One connection: JSON-RPC 2.0, one object a line. Events that come while an answer is waited for are kept."""

    def __init__(self, host, port, token=None, tls=None):
        plain = socket.create_connection((host, port), timeout=10)
        self._socket = tls.wrap_socket(plain, server_hostname=host) if tls else plain
        self._socket.settimeout(None)  # a long call answers when it is done
        self._lines = self._socket.makefile(encoding="utf-8", newline="\n")
        self._last_id, self._events = 0, []
        self.call("session.hello", protocol=1, **({"token": token} if token else {}))

    def call(self, method, **params):
        self._last_id += 1
        request = {"jsonrpc": "2.0", "id": self._last_id, "method": method, "params": params}
        self._socket.sendall((json.dumps(request) + "\n").encode())
        while True:
            message = self._read()
            if message.get("id") != self._last_id:
                continue  # an event, which is kept, or a message of a later daemon
            if "error" in message:
                raise Refused(message["error"]["message"])
            return message["result"]

    def command(self, method, **params):
        """A call that changes something: with a name, by which the daemon would know it again if it came twice."""
        return self.call(method, command_id=str(uuid.uuid4()), **params)

    def events(self):
        """All events from now on, each {"seq", "time", "topic", "data"}."""
        while True:
            while self._events:
                yield self._events.pop(0)
            self._read()

    def _read(self):
        line = self._lines.readline()
        if not line:
            raise ConnectionError("the daemon closed the connection")
        message = json.loads(line)
        if message.get("method") == "event":
            self._events.append(message["params"])
        elif message.get("id") is None and "error" in message:  # why it is about to close
            raise ConnectionError(message["error"]["message"])
        return message


def follow(daemon, campaign):
    """Prints what happens until the campaign is over. Returns its last progress."""
    for event in daemon.events():
        data = event["data"]
        if event["topic"] == "log" and data["level"] != "info":
            print(f"{data['level']}: {data['text']}")
        if event["topic"] == "campaign" and data["id"] == campaign:
            print(f"{data['phase']}: {data['done']} of {data['total']} poses, mean error {data['error_mm'] or '-'} mm")
            if data["phase"] in ("done", "aborted", "failed"):
                return data


def run(daemon, options):
    if daemon.call("cell.status")["state"] == "disconnected":
        daemon.command("cell.connect")
    daemon.call("events.subscribe", topics=["campaign", "log"])
    poses = {"identify_poses": options.identify, "validate_poses": options.validate}
    started = daemon.command("campaign.start", activate=False, **{name: n for name, n in poses.items() if n is not None})
    last = follow(daemon, started["id"])
    if last["phase"] != "done":
        sys.exit(f"campaign {last['phase']}: {last['reason']}")
    report = daemon.call("report.get", id=started["id"])
    options.report.write_text(json.dumps(report["document"], indent=1))
    model = daemon.command("model.activate", id=last["model_id"])
    print(f"model {model['id']} is active: {model['validation_after_mm']:.3f} mm, without it {model['validation_before_mm']:.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("daemon", metavar="HOST:PORT")
    for name in ("--token-file", "--ca", "--cert", "--key"):
        parser.add_argument(name, type=pathlib.Path)
    for name in ("--identify", "--validate"):
        parser.add_argument(name, type=int, help="poses; default: the cell file's")
    parser.add_argument("--report", type=pathlib.Path, default="report.json")
    options = parser.parse_args()
    host, port = options.daemon.rsplit(":", 1)
    token = options.token_file.read_text().strip() if options.token_file else None
    tls = ssl.create_default_context(cafile=options.ca) if options.ca else None
    if options.cert:
        tls.load_cert_chain(options.cert, options.key)
    run(Daemon(host, int(port), token, tls), options)


if __name__ == "__main__":
    try:
        main()
    except (OSError, Refused) as failure:
        sys.exit(f"campaign.py: {failure}")
