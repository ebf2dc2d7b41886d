#!/usr/bin/env python3
"""tools/examples/panel.html in a real browser, before a real daemon and the simulated cell.

    panel_test.py BIN SOURCE    ends 77 where there is no Chromium
"""
import http.server
import pathlib
import queue
import shutil
import subprocess
import sys
import threading

from live_cell import PATIENCE_S, LiveCell

HERE = pathlib.Path(__file__).parent


def handler(pages, requests):
    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            page = pages.get(self.path.split("?")[0])
            self.send_response(200 if page else 404)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            if page:
                self.wfile.write(page.read_bytes())

        def do_POST(self):
            requests.put((self.path, self.rfile.read(int(self.headers["Content-Length"])).decode()))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_):
            pass

    return Handler


def browse(url, folder):
    # Tests run as root where the machine is a container, and there Chromium has no sandbox.
    return subprocess.Popen(["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run",
                             f"--user-data-dir={folder / 'profile'}", "--remote-debugging-port=0", url],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)


def watch(cell, requests):
    """Does what the page asks for. Returns what it said at the end."""
    while True:
        path, text = requests.get(timeout=PATIENCE_S)
        if path == "/restart":
            cell.stop_daemon()
            cell.start_daemon()
        elif path == "/failed":
            sys.exit(f"panel_test.py: {text}")
        elif path == "/done":
            return text


def main():
    if not shutil.which("chromium"):
        print("panel_test.py: no Chromium: tools/install-packages installs it", file=sys.stderr)
        sys.exit(77)
    bin_folder, source = sys.argv[1:3]
    pages = {"/driver.html": HERE / "panel_driver.html", "/panel.html": pathlib.Path(source) / "tools/examples/panel.html"}
    requests = queue.Queue()
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler(pages, requests))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    origin = f"http://127.0.0.1:{server.server_port}"
    with LiveCell(bin_folder, source, origin=origin) as cell:
        token = cell.access("Panel", "operator")
        browser = browse(f"{origin}/driver.html?daemon=127.0.0.1:{cell.web_port}&token={token}", cell.folder)
        try:
            log = watch(cell, requests)
        finally:
            browser.terminate()
            browser.wait()
    for expected in ("connected as Panel, operator", "Panel: campaign.start ok", "Abort: done"):
        if expected not in log:
            sys.exit(f"panel_test.py: the panel's log has no '{expected}':\n{log}")


if __name__ == "__main__":
    main()
