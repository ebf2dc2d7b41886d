"""A page in headless Chromium, over the DevTools protocol through two pipes (--remote-debugging-pipe): each message is JSON
that ends with a zero byte."""
import json
import os
import subprocess
import time

PATIENCE_S = 60  # no expectation: beyond it something hangs


def until(condition, what):
    """Waits until a condition is true, and returns what it is. what() says how it stands where that was in vain."""
    end = time.monotonic() + PATIENCE_S
    while not (value := condition()):
        if time.monotonic() > end:
            raise AssertionError(f"waited in vain; at last: {what()}")
        time.sleep(0.05)
    return value


class Page:
    """Ends the browser when the `with` block is left."""

    def __init__(self, folder, url):
        """folder: of the browser's profile"""
        self.sockets = []  # of each WebSocket that the page opened, the methods that it called
        self._last = 0
        self._session = {}
        to_read, self._to = os.pipe()
        self._from, to_write = os.pipe()
        # Tests run as root where the machine is a container, and there Chromium has no sandbox.
        chromium = ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run",
                    f"--user-data-dir={folder}", "--remote-debugging-pipe", "about:blank"]
        self._process = subprocess.Popen(["bash", "-c", f'exec "$@" 3<&{to_read} 4>&{to_write}', "bash", *chromium],
                                         pass_fds=(to_read, to_write), stdin=subprocess.DEVNULL,
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(to_read)
        os.close(to_write)
        self._answers = os.fdopen(self._from, "rb")
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = {"sessionId": self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]}
        self._call("Network.enable")
        self.go(url)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._session = {}
        self._call("Browser.close")
        self._process.wait(PATIENCE_S)
        self._answers.close()
        os.close(self._to)

    def go(self, url):
        self._call("Page.navigate", url=url)

    def value(self, expression):
        """Of an expression in the page; None while it has none."""
        return self._call("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def _call(self, method, **params):
        self._last += 1
        message = {"id": self._last, "method": method, "params": params} | self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            message = self._next()
            if message.get("id") == self._last:
                return message["result"]
            if message.get("method") == "Network.webSocketCreated":
                self.sockets.append([])
            if message.get("method") == "Network.webSocketFrameSent":
                self._take(message["params"]["response"])

    def _take(self, frame):
        if frame["opcode"] == 1:
            self.sockets[-1].append(json.loads(frame["payloadData"])["method"])

    def _next(self):
        text = bytearray()
        while (byte := self._answers.read(1)) != b"\0":
            if not byte:
                raise RuntimeError("Chromium has ended")
            text += byte
        return json.loads(text)
