#!/usr/bin/env python3
"""The simulated cell and its daemon as processes, for tests of clients that are not written in C++.

As a program:

    live_cell.py BIN SOURCE [--tls HOST]

starts both and says where they are, as one line of JSON. Each further line on its standard input is one thing to do,
answered by one line: {"do": "truepose", "arguments": [...]}, {"do": "stop"} and {"do": "start"} (the daemon, on the ports
that it had), {"do": "freeze"} and {"do": "thaw"} (the daemon, which stands still between them), {"do": "steer", "line": {...}} (the simulated cell). All ends with the input.
"""
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

TOKEN = "0123456789abcdef0123456789abcdef"
PATIENCE_S = 300  # no expectation: beyond it something hangs


def changed(text, replacements):
    """A shipped file's text with others in it. One that is not there has been changed meanwhile: the test is wrong."""
    for before, after in replacements:
        if before not in text:
            raise RuntimeError(f'a shipped file has no "{before}"')
        text = text.replace(before, after, 1)
    return text


def free_udp_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class LiveCell:
    """Ends what it started, and removes its folder, when the `with` block is left."""

    def __init__(self, bin_folder, source, tls=False, speedup=100, origin="https://hmi.plant", host="127.0.0.1", bridge=None,
                 nests="", target_6d=""):
        """origin: whose pages may use the web port from a browser; host: where the TLS port is reached; bridge: the words that start
        a bridge for the daemon, which says on which port it listens and finds the simulated tracker by TRUEPOSE_SIM_BRIDGE;
        nests: of the tracker, as in a scenario; target_6d: of the reflector, likewise"""
        self.bin = pathlib.Path(bin_folder)
        self.config = pathlib.Path(source) / "config"
        self.tls, self.speedup, self.origin, self.host = tls, speedup, origin, host
        self.bridge, self.nests, self.target_6d = bridge, nests, target_6d
        self.processes = {}
        self.port = self.tls_port = self.web_port = 0
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)
        self.cell_file, self.token_file = self.folder / "cell.yaml", self.folder / "token"

    def __enter__(self):
        try:
            self._start_simulator()
            if self.bridge:
                self._start_bridge()
            self.start_daemon()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for name in list(self.processes):
            self._end(name)
        self._folder.cleanup()

    def start_daemon(self):
        self.cell_file.write_text(self._cell())
        notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        notify.bind(str(self.folder / "notify"))
        notify.settimeout(PATIENCE_S)
        self._start("trueposed", ["--config", self.cell_file], {"NOTIFY_SOCKET": str(self.folder / "notify")})
        said = ""
        while "READY=1" not in said:
            notify.settimeout(0.2)
            try:
                said = notify.recv(4096).decode()
            except TimeoutError:
                if self.processes["trueposed"].poll() is not None:
                    raise RuntimeError("no daemon: " + (self.folder / "trueposed.err").read_text()) from None
        notify.close()
        (self.folder / "notify").unlink()
        def port(name):
            return int(re.search(rf"{name} port (\d+)", said)[1])
        self.port, self.web_port = port("control"), port("web")
        if self.tls:
            self.tls_port = port("TLS")

    def stop_daemon(self):
        self._end("trueposed")

    def kill_daemon(self):
        self.processes["trueposed"].kill()
        self.processes.pop("trueposed").wait()
        self.web_port = 0  # another program may have taken it before the next start

    def freeze_daemon(self):
        self.processes["trueposed"].send_signal(signal.SIGSTOP)

    def thaw_daemon(self):
        self.processes["trueposed"].send_signal(signal.SIGCONT)

    def truepose(self, *arguments, online=True):
        """Runs the command line. Returns (exit code, standard output, standard error)."""
        where = ["--daemon", f"127.0.0.1:{self.port}", "--token-file", self.token_file] if online else []
        done = subprocess.run([self.bin / "truepose", *arguments, *where], capture_output=True, text=True,
                              timeout=PATIENCE_S, check=False)
        return done.returncode, done.stdout, done.stderr

    def made(self, *arguments):
        """Runs the command line on files, which has to succeed. Returns what it printed."""
        code, out, err = self.truepose(*arguments, online=False)
        if code != 0:
            raise RuntimeError(err)
        return out.strip()

    def access(self, name, role, *options):
        """Gives a client access. Returns the token, if he has one."""
        return self.made("access", "add", name, "--role", role, *options, "--cell", self.cell_file)

    def steer(self, line):
        """Has the simulated cell do something. Returns its answer."""
        with socket.create_connection(("127.0.0.1", self.ports["admin_port"])) as admin:
            admin.sendall((json.dumps(line) + "\n").encode())
            return json.loads(admin.makefile().readline())

    def place(self):
        """Where all is, for another program."""
        return {"folder": str(self.folder), "host": self.host, "port": self.port, "tls_port": self.tls_port,
                "web_port": self.web_port, "token": TOKEN, "token_file": str(self.token_file),
                "cell_file": str(self.cell_file)}

    def _start(self, name, arguments, environment=None, program=None):
        with open(self.folder / f"{name}.out", "wb") as out, open(self.folder / f"{name}.err", "wb") as err:
            self.processes[name] = subprocess.Popen([program or self.bin / name, *arguments], stdin=subprocess.DEVNULL,
                                                    stdout=out, stderr=err, env=os.environ | (environment or {}))

    def _end(self, name):
        process = self.processes.pop(name, None)
        if process is None:
            return
        process.terminate()
        process.send_signal(signal.SIGCONT)  # where it stands still
        try:
            process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _start_simulator(self):
        config = str(self.config)
        scenario = changed((self.config / "scenarios/demo.yaml").read_text(), [
            ("../robots", config + "/robots"), ("../kuka", config + "/kuka"),
            ("gluing.src", config + "/scenarios/gluing.src"), ("gluing.dat", config + "/scenarios/gluing.dat"),
            ("timeout_cycles: 100 ", "timeout_cycles: 2500 "),
            ("\n  # target_6d:", f"\n  target_6d: {self.target_6d}\n  #" if self.target_6d else "\n  # target_6d:"),
            ("\ntracker:\n", f"\ntracker:\n  nests_mm: [{self.nests}]\n" if self.nests else "\ntracker:\n")])
        (self.folder / "scenario.yaml").write_text(scenario)
        self.rsi_port = free_udp_port()
        ready = self.folder / "ready.json"
        self._start("truepose-sim", ["--scenario", self.folder / "scenario.yaml", "--ready-file", ready,
                                     "--rsi-target", f"127.0.0.1:{self.rsi_port}", "--admin-port", "0",
                                     "--speedup", str(self.speedup), *(["--bridge-port", "0"] if self.bridge else [])])
        end = time.monotonic() + PATIENCE_S
        while not ready.exists():
            if self.processes["truepose-sim"].poll() is not None or time.monotonic() > end:
                raise RuntimeError("no simulator: " + (self.folder / "truepose-sim.err").read_text())
            time.sleep(0.01)
        self.ports = json.loads(ready.read_text())
        self.token_file.write_text(TOKEN + "\n")
        self.token_file.chmod(0o400)
        if self.tls:
            self.made("tls", "init", "--dir", self.folder / "tls", "--host", self.host)

    def _start_bridge(self):
        simulated = {"TRUEPOSE_SIM_BRIDGE": "127.0.0.1:{}".format(self.ports["bridge_port"])}
        self._start("bridge", self.bridge[1:], simulated, program=self.bridge[0])
        end = time.monotonic() + PATIENCE_S
        while not (listening := re.search(r"listening on port (\d+)", (self.folder / "bridge.out").read_text())):
            if self.processes["bridge"].poll() is not None or time.monotonic() > end:
                raise RuntimeError("no bridge: " + (self.folder / "bridge.err").read_text())
            time.sleep(0.01)
        self.bridge_port = int(listening[1])

    def _cell(self):
        config, at = str(self.config), "127.0.0.1:{}".format
        replacements = [
            ("robots/kr210", config + "/robots/kr210"), ("kuka/rsi", config + "/kuka/rsi"),
            ("127.0.0.1:54600", at(self.ports["eki_port"])), ("127.0.0.1:54601", at(self.ports["eki_state_port"])),
            ("127.0.0.1:49152", at(self.rsi_port)), ("127.0.0.1:7000", at(self.bridge_port if self.bridge else self.ports["tracker_port"])),
            ("protocol: emscon", "protocol: bridge" if self.bridge else "protocol: emscon"),
            ("127.0.0.1:7210", at(self.port)), ("timeout_cycles: 100 ", "timeout_cycles: 2500 "),
            ("priority: 80", "priority: 40"),  # the simulator's is 60
            ("#runtime: /run/truepose/demo", "runtime: run"),
            ("#web:", "web:"), ("#  listen: 127.0.0.1:7280", "  listen: " + at(self.web_port)),
            ("#  origins: [https://hmi.plant]", f"  origins: [{self.origin}]")]
        if self.tls:
            replacements += [("  #tls:", "  tls:"), ("  #  listen: 0.0.0.0:7211", f"    listen: {self.host}:{self.tls_port}"),
                             ("  #  certificate:", "    certificate:"), ("  #  key:", "    key:")]
        return changed((self.config / "cell.yaml").read_text(), replacements)


def carry_out(cell, order):
    """One line of the standard input."""
    if order["do"] == "truepose":
        return dict(zip(("exit_code", "out", "err"), cell.truepose(*order["arguments"], online=order.get("online", True))))
    if order["do"] == "steer":
        return cell.steer(order["line"])
    {"stop": cell.stop_daemon, "start": cell.start_daemon, "freeze": cell.freeze_daemon, "thaw": cell.thaw_daemon}[order["do"]]()
    return cell.place()


def main():
    bin_folder, source, *options = sys.argv[1:]
    tls = {"tls": True, "host": options[1]} if options[:1] == ["--tls"] else {}
    with LiveCell(bin_folder, source, **tls) as cell:
        print(json.dumps(cell.place()), flush=True)
        for line in sys.stdin:
            print(json.dumps(carry_out(cell, json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
