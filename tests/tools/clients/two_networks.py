"""Another machine for a test, as far as the network goes."""
import os
import subprocess
import sys
import time

CELL, PANEL = "10.77.0.1", "10.77.0.2"


def enter_own_network():
    """Goes on in a network namespace that nobody else has; ends 77 where it may not."""
    if os.environ.get("TRUEPOSE_OWN_NETWORK"):
        return
    if subprocess.run(["unshare", "-n", "ip", "link", "show"], capture_output=True, check=False).returncode != 0:
        print(f"{sys.argv[0]}: makes networks, which needs root and iproute2", file=sys.stderr)
        sys.exit(77)
    os.execvpe("unshare", ["unshare", "-n", sys.executable, *sys.argv], os.environ | {"TRUEPOSE_OWN_NETWORK": "1"})


class OtherMachine:
    """A second namespace, joined to ours by a cable: we are CELL, it is PANEL."""

    def __enter__(self):
        self._holder = subprocess.Popen(["unshare", "-n", "sleep", "infinity"])
        try:
            self._connect()
        except BaseException:
            self._end_holder()
            raise
        return self

    def _connect(self):
        ours = os.readlink("/proc/self/ns/net")
        while os.readlink(f"/proc/{self._holder.pid}/ns/net") == ours:
            time.sleep(0.01)
        self._do("ip", "link", "add", "cell", "type", "veth", "peer", "name", "panel", "netns", str(self._holder.pid))
        for within, name, address in (([], "cell", CELL), (self.there(), "panel", PANEL)):
            self._do(*within, "ip", "address", "add", f"{address}/30", "dev", name)
            for link in ("lo", name):
                self._do(*within, "ip", "link", "set", link, "up")

    def __exit__(self, *_):
        # The kernel removes a namespace some time after its last process, and the next cable has the same name.
        self._do("ip", "link", "delete", "cell")
        self._end_holder()

    def _end_holder(self):
        self._holder.kill()
        self._holder.wait()

    def there(self, *words):
        """The command that runs a command there."""
        return ["nsenter", "-t", str(self._holder.pid), "-n", *map(str, words)]

    @staticmethod
    def _do(*words):
        subprocess.run(words, check=True)
