"""Answers, events and printed texts of a simulated cell and its daemon.

rpc/       one file for each method of the control port: good calls and refused ones
events/    one file for each topic: the events in their order, and their members
commands/  one file for each command of the command line that asks a daemon or reads its files
files/     what these commands wrote

The simulator draws its noise from a seed, once for each motion and measurement. A campaign without a pause is reproducible.
Values that depend on the machine's timing are left out: those of the stream, of a paused campaign, clocks and counters.
Of these answers the shape is frozen: the paths of all members with their types.
"""
import base64
import json
import pathlib
import re
import socket
import sys
import urllib.error
import urllib.request

import normal_form

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tools/clients"))
from live_cell import PATIENCE_S, TOKEN, LiveCell  # noqa: E402

UNKNOWN_ID = "00000000-0000-4000-8000-000000000000"
HOME = [0, -90, 90, 0, 35, 0]
# Members whose value depends on the machine's timing: clocks, durations, counters of the stream.
HIDDEN = {"elapsed_s", "time_s", "uptime_s", "eta_s", "seconds", "bytes", "left_s", "connections", "version", "seq", "next_seq", "rank_gap", "waiting",
          "ipoc_step", "packet_age_ms", "peer", "scheduling", "last_minute", "late_by", "turnaround_us", "compute_us", "cycles", "answered", "held",
          "unconfirmed", "duplicate", "clamped", "damped", "no_solution", "late", "lost", "max_step_deg", "correction_deg", "measured_deg"}
# The same of one method alone: the number of the next event, by how many there were until then.
HIDDEN_OF = {"events.subscribe": {"next"}}
# Members whose type, or that of their members, depends on it too.
UNTYPED = {"eta_s", "waiting", "ipoc_step", "packet_age_ms", "peer", "refused", "robot", "scheduling", "last_minute", "late_by", "correction_deg",
           "measured_deg"}
# Lines of the log that do not depend on the machine's timing.
UNTIMED_LOG = re.compile(r"(the campaign|campaign|model|cell|tool)\b")


class Client:
    """One connection: JSON-RPC 2.0, one object a line. Notifications that come while an answer is waited for are kept."""

    def __init__(self, port, token=None):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        self.lines = self.socket.makefile(encoding="utf-8", newline="\n")
        self.notifications, self.passed, self.last_id = [], 0, 0
        if token:
            self.result("session.hello", protocol=1, token=token)

    def send(self, line):
        self.socket.sendall(line.encode() + b"\n")

    def read(self):
        line = self.lines.readline()
        if not line:
            raise ConnectionError("the daemon closed the connection")
        return json.loads(line)

    def answer(self, method, params):
        """{"result": ...} or {"error": ...}"""
        self.last_id += 1
        self.send(json.dumps({"jsonrpc": "2.0", "id": self.last_id, "method": method, "params": params}))
        while True:
            message = self.read()
            if "method" in message:
                self.notifications.append(message)
            else:
                return {name: member for name, member in message.items() if name not in ("jsonrpc", "id")}

    def result(self, method, **params):
        answer = self.answer(method, params)
        if "result" not in answer:
            raise RuntimeError(f"{method}: {answer}")
        return answer["result"]

    def until(self, wanted):
        """Waits for the next notification for which this holds, behind the one that was waited for last."""
        while True:
            if self.passed == len(self.notifications):
                self.notifications.append(self.read())
            message = self.notifications[self.passed]
            self.passed += 1
            if wanted(message):
                return message["params"]


def event(topic, **members):
    """Whether a notification is an event with these members."""
    return lambda message: (message["method"] == "event" and message["params"]["topic"] == topic
                            and members.items() <= message["params"]["data"].items())


class Record:
    """What one cell is asked, and the frozen form of its answers."""

    def __init__(self, cell):
        self.cell = cell
        self.client = Client(cell.port, TOKEN)
        # How far a campaign is when it is first seen, or paused, depends on the machine's timing.
        self.masks = [(r"\A\w+ +\d+/\d+ poses(?=\n)", "<phase> 0/0 poses"), (r"(?<=to identify from, )\d+(?= are too few)", "<poses>"),
                      (str(cell.folder), "<cell>"), (str(cell.config), "<config>"), (cell.folder.name, "<folder>"),
                      ("the controller closed the connection|Connection reset by peer", "<connection ended>"),
                      ("SCHED_.*|the last .* s, .* kB", "<of the machine>"), (r'"state":"(running|idle)"', '"state":"<state>"'),
                      (r'"(next|oldest)": \d+', r'"\1": "<number>"')]
        self.files, self.asked = {}, {"well": set(), "badly": set()}

    def keep(self, name, *texts):
        self.files.setdefault(name, []).extend(texts)

    def keep_answer(self, method, title, params, answer, as_shape=False):
        hidden = HIDDEN | HIDDEN_OF.get(method, set())
        text = normal_form.shape(answer, hidden=UNTYPED) if as_shape else normal_form.json_form(answer, hidden, self.masks)
        asked = normal_form.masked(json.dumps(params, ensure_ascii=False), self.masks)
        self.keep(f"rpc/{method}", f"== {title}: {asked}", text)
        self.asked["badly" if "error" in answer else "well"].add(method)

    def well(self, method, title="well", as_shape=False, /, **params):
        answer = self.client.answer(method, params)
        if "result" not in answer:
            raise RuntimeError(f"{method} {params}: {answer}")
        self.keep_answer(method, title, params, answer, as_shape)
        return answer["result"]

    def badly(self, method, title, client=None, /, **params):
        answer = (client or self.client).answer(method, params)
        if "result" in answer:
            raise RuntimeError(f"{method} {params} is not refused: {answer}")
        self.keep_answer(method, title, params, answer)

    def command(self, line, numbers=True, online=True):
        """One of the command line, in text and as JSON. numbers: whether they are reproducible"""
        words = line.split()
        code, out, err = self.cell.truepose(*(word.replace("CELL", str(self.cell.folder)) for word in words), online=online)
        try:
            out = normal_form.json_form(json.loads(out), HIDDEN, self.masks) if numbers else normal_form.shape(json.loads(out), hidden=UNTYPED)
        except ValueError:
            out = normal_form.shortened(normal_form.masked(out, self.masks))
        if not numbers:
            out = normal_form.without_numbers(out)
        texts = [text.rstrip("\n") for text in (out, normal_form.masked(err, self.masks)) if text]
        self.keep(f"commands/{words[0]}", f"$ truepose {normal_form.masked(line, self.masks)}", *texts, f"[exit {code}]")

    def campaign(self, **params):
        """Starts one and waits for its end. Returns its id."""
        started = self.well("campaign.start", f"kind {params.get('kind', 'calibration')}", **params)
        return self.end_of(started["id"])

    def end_of(self, campaign):
        of_it = event("campaign", id=campaign)
        last = self.client.until(lambda message: of_it(message) and message["params"]["data"]["phase"] in ("done", "failed", "aborted"))["data"]
        if last["phase"] != "done":
            raise RuntimeError(f"campaign {last}")
        return campaign


def open_sessions(record):
    """Refusals before a session is open, and of lines that are no request."""
    port = record.cell.port
    for title, line in [("not JSON", "{"), ("no request", "[]"), ("before the session", '{"jsonrpc":"2.0","id":1,"method":"cell.status"}')]:
        client = Client(port)
        greeting = client.read()
        client.send(line)
        record.keep("rpc/greeting", f"== {title}: {line}", normal_form.json_form(greeting, HIDDEN, record.masks),
                   normal_form.json_form(client.read(), HIDDEN, record.masks))
    for title, params in [("wrong token", {"protocol": 1, "token": "0" * 32}), ("wrong protocol", {"protocol": 2, "token": TOKEN}),
                          ("no token", {"protocol": 1})]:
        record.keep_answer("session.hello", title, params, Client(port).answer("session.hello", params))
    client = Client(port)
    record.keep_answer("session.challenge", "well", {}, client.answer("session.challenge", {}))
    record.keep_answer("session.hello", "well", {}, client.answer("session.hello", {"protocol": 1, "token": TOKEN}))
    for line in ["{", '{"jsonrpc":"2.0","id":{},"method":"cell.status"}', '{"jsonrpc":"2.0","id":1,"method":"cell.dance"}',
                 '{"jsonrpc":"2.0","id":1,"method":"cell.status","params":[]}']:
        client.send(line)
        record.keep("rpc/no_method", f"== {line}", normal_form.json_form(client.read(), HIDDEN, record.masks))


def refuse_everything(record, schema):
    """Every method with an unknown parameter, and every command from a client with the role viewer."""
    viewer = Client(record.cell.port, record.cell.access("Viewer", "viewer"))
    for method in schema["methods"]:
        record.badly(method["name"], "unknown parameter", nonsense=1)
        if method["x-role"] != "viewer":
            required = {parameter["name"]: 1 if parameter["schema"].get("type") == "integer" else "x"
                        for parameter in method["params"] if parameter.get("required")}
            record.badly(method["name"], "as a viewer", viewer, **required)


def refuse_without_model(record):
    """Refusals of a cell without a campaign, and of wrong parameters."""
    for method in ["campaign.pause", "campaign.resume", "campaign.abort", "campaign.get", "campaign.points", "campaign.export", "drift.check",
                   "model.get", "model.export", "model.rollback", "stream.start", "stream.arm", "report.get", "report.html"]:
        record.badly(method, "nothing measured")
    for method in ["campaign.resume", "campaign.abort", "campaign.get", "campaign.points", "campaign.export", "campaign.identify", "model.get",
                   "model.export", "model.activate", "tool.activate", "report.get", "report.html", "job.get", "store.get_backup"]:
        record.badly(method, "unknown id", id=UNKNOWN_ID)
    record.badly("recording.get", "unknown name", name="none.pcapng")
    record.badly("tool.deactivate", "unknown number", number=7)
    record.badly("targets.compensate", "no model", joints=[HOME])
    record.badly("targets.compensate", "neither joints nor poses")
    record.badly("campaign.start", "no model", kind="targets")
    record.badly("campaign.start", "wrong type", identify_poses="many")
    record.badly("campaign.start", "out of range", identify_poses=2)
    record.badly("campaign.start", "wrong kind", kind="dance")
    record.badly("campaign.start", "parameter of another kind", kind="calibration", cycles=3)
    record.badly("control.acquire", "out of range", lease_s=600)
    record.badly("events.subscribe", "wrong topic", topics=["weather"])
    record.badly("audit.list", "out of range", limit=0)
    record.badly("audit.acknowledge", "unchanged", name="Anna Beer")


def ask_at_rest(record):
    """All that can be asked before the cell is connected."""
    for method in ["session.ping", "system.info", "system.config", "cell.status", "campaign.list", "model.list", "tool.list", "stream.status",
                   "control.get", "recording.list", "cell.acknowledge", "cell.disconnect", "model.deactivate", "stream.stop", "stream.disarm"]:
        record.keep_answer(method, "at rest", {}, record.client.answer(method, {}))
    record.well("events.subscribe")
    record.well("rpc.discover", method="cell.connect")
    outline = record.client.result("rpc.discover")
    record.keep("rpc/rpc.discover", "== methods", *(f"{method['name']} {method['x-role']}: {' '.join(parameter['name'] for parameter in method['params'])}"
                                                   for method in outline["methods"]))


def control(record):
    other = Client(record.cell.port, record.cell.access("Operator", "operator"))
    record.well("control.acquire", lease_s=60)
    record.well("control.get", "held")
    record.badly("cell.connect", "without control", other)
    record.badly("control.acquire", "held by another", other)
    record.badly("control.takeover", "held by a higher role", other)
    record.well("control.release")
    other.result("control.acquire")
    record.well("control.takeover", lease_s=60)
    record.well("control.release")


def campaigns(record):
    """One of each kind that runs without an operator. Returns their ids."""
    record.well("cell.connect")
    record.well("cell.status", "ready")
    record.badly("cell.connect", "connected")
    first = record.campaign(identify_poses=12, validate_poses=6, remeasure=True, note="frozen")
    ask_about_campaign(record, first)
    record.well("campaign.identify", id=first, non_geometric="auto", residual="auto")
    ids = {"calibration": first}
    for kind, params in [("targets", {"validate_poses": 2}), ("iso9283", {"cycles": 2}), ("tool", {"number": 3, "poses_per_point": 4})]:
        ids[kind] = record.campaign(kind=kind, **params)
        record.well("campaign.get", kind, id=ids[kind], points_limit=2)
    record.well("tool.activate", id=ids["tool"])
    record.badly("tool.activate", "of no tool", id=first)
    record.well("tool.list", "one in use")
    record.well("targets.compensate", "with the tool", joints=[HOME], tool=3)
    record.well("tool.deactivate", number=3)
    ids["drift"] = record.end_of(record.well("drift.check", poses=2, update=True)["id"])
    record.well("campaign.get", "drift", id=ids["drift"])
    record.well("campaign.list", "several", limit=20)
    return ids


def pause(record):
    record.well("campaign.pause", "well", True)
    record.client.until(event("cell", state="paused"))


def paused_campaign(record):
    """Pause, resume and abort. The pose at which it pauses depends on the machine's timing."""
    record.paused = campaign = record.well("campaign.start", "to be paused", True, identify_poses=12, validate_poses=6)["id"]
    record.badly("campaign.start", "while one runs")
    record.badly("model.activate", "while one runs", id=UNKNOWN_ID)
    pause(record)
    record.well("cell.status", "paused", True)
    record.well("campaign.resume", "well", True)
    pause(record)
    record.well("campaign.abort", "well", True, id=campaign)
    record.badly("campaign.identify", "too few points", id=campaign)
    record.badly("campaign.resume", "aborted", id=campaign)


def ask_about_campaign(record, campaign):
    record.well("campaign.get", "calibration", id=campaign, points_limit=2)
    record.badly("campaign.get", "out of range", id=campaign, points_limit=1000)
    record.well("campaign.points", "json", id=campaign, limit=3)
    record.well("campaign.points", "csv", id=campaign, format="csv", limit=3)
    record.badly("campaign.points", "wrong format", id=campaign, format="xml")
    for method in ["campaign.export", "report.html"]:
        record.well(method, id=campaign)
    record.well("model.export")
    record.well("report.get", id=campaign, points_limit=2)
    job = record.well("report.html", "as a job", id=campaign, job=True)["job"]
    record.client.until(lambda message: message["method"] == "job" and message["params"]["id"] == job and message["params"]["state"] == "done")
    record.well("job.get", "done", id=job)


def models(record):
    models = record.well("model.list", "several")["models"]
    record.well("model.get")
    active = record.client.result("cell.status")["model"]["id"]
    record.well("model.activate", id=active)
    record.well("model.deactivate")
    record.well("model.rollback")
    record.badly("model.activate", "unknown id", id=models[0]["campaign_id"])
    record.well("targets.compensate", "joints", joints=[HOME])
    record.well("targets.compensate", "poses", poses=[[1700, 0, 1500, 0, 60, 0]])
    record.badly("targets.compensate", "beyond a limit", joints=[[0, -90, 90, 0, 35, 360]])
    record.badly("targets.compensate", "beyond reach", poses=[[9000, 0, 1500, 0, 60, 0]])


def campaign_files(record, ids):
    """The files that the command line writes of each kind of campaign, and its texts."""
    for kind, files in [("calibration", ["--data points.csv", "--document calibration.json"]),
                        ("targets", ["--joints joints.csv", "--document targets.json"]),
                        ("iso9283", ["--cycles cycles.csv", "--document iso9283.json"]),
                        ("tool", ["--data tool.csv", "--frame tool.yaml", "--document tool.json"]), ("drift", ["--document drift.json"])]:
        record.command(f"campaign show {ids[kind]}")
        record.command(f"campaign export {ids[kind]} {' '.join(files).replace(' ', ' CELL/').replace('CELL/--', '--')}")
        for name in (file.split()[1] for file in files):
            record.keep(f"files/{name}", normal_form.output_text((record.cell.folder / name).read_text(encoding="utf-8"), HIDDEN, record.masks))
    record.command("drift", numbers=False)
    record.command("drift --json", numbers=False)
    record.command("campaign start --identify 12 --validate 6 --no-remeasure --no-activate --watch", numbers=False)


def commands(record, campaign):
    """The commands that ask a daemon, in text and as JSON, and those that read its store without it."""
    for line in ["status", "campaign list", f"campaign show {campaign}", "model list", "model show", "tools list", "control show", "recording list",
                 "control acquire --lease 5", "control release", f"campaign identify {campaign} --residual gp",
                 'call targets.compensate {"joints":[[0,-90,90,0,35,0]]}', "model export"]:
        record.command(line)
        record.command(f"{line} --json")
    record.command(f"report {campaign} --html CELL/report.html --out-json CELL/report.json")
    for line in ["stream status", "events --topics model --count 1 --after 0", "audit list --limit 3",
                 "backup --out CELL/copy.sqlite", "recording save --out CELL/copy.pcapng"]:
        record.command(line, numbers=False)
        record.command(f"{line.replace('copy', 'other')} --json", numbers=False)
    for line in ["campaign list --store CELL/copy.sqlite", f"campaign show {campaign} --store CELL/copy.sqlite --json",
                 f"report {campaign} --store CELL/copy.sqlite", "replay CELL/copy.pcapng", "audit verify --cell CELL/cell.yaml"]:
        record.command(line, numbers=line.startswith(("campaign", "report")), online=False)
    for line in ["dance", "status --wrong", "campaign show none", f"campaign show {UNKNOWN_ID}", "campaign start --targets CELL/none.csv",
                 "campaign start --touch 3", "campaign abort", "campaign resume", f"campaign export {campaign}", f"report {UNKNOWN_ID}",
                 f"model show {UNKNOWN_ID}", f"model activate {UNKNOWN_ID}", f"model export {UNKNOWN_ID} --out CELL/none.yaml",
                 f"tools activate {UNKNOWN_ID}", "tools deactivate 7", "stream stop", "control acquire --lease 600",
                 "recording export none --out CELL/none.pcapng", "audit acknowledge --name Anna", "events --topics weather", "call cell.dance",
                 "call cell.status []", "backup --out CELL/none/copy.sqlite"]:
        record.command(line)


def stream(record):
    """The stream. All its values depend on the machine's timing."""
    record.well("stream.start", "well", True)
    record.badly("stream.start", "runs")
    record.badly("campaign.start", "while the stream runs")
    record.client.until(event("stream", state="correcting"))
    record.well("stream.status", "correcting", True)
    record.well("cell.status", "streaming", True)
    record.well("stream.stop", "well", True)
    record.well("cell.disconnect")
    record.well("stream.arm", "well", True)
    record.well("stream.disarm", "well", True)


def files(record):
    """The first bytes of a recording and a backup, and the web port."""
    saved = record.well("recording.save")
    record.well("recording.list")
    backup = record.well("store.backup")
    for method, length, params in [("recording.get", 4, {"name": saved["name"]}), ("store.get_backup", 15, {"id": backup["id"]})]:
        answer = record.client.answer(method, params)
        answer["result"]["data"] = base64.b64decode(answer["result"]["data"])[:length].decode()
        record.keep_answer(method, "well", params, answer)
    for path in ["healthz", "metrics", "none"]:
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{record.cell.web_port}/{path}") as answer:
                status, text = answer.status, answer.read().decode()
        except urllib.error.HTTPError as refused:
            status, text = refused.code, refused.read().decode()
        record.keep("web", f"== /{path}: {status}", normal_form.without_numbers(normal_form.masked(text, record.masks)))


def faults(record):
    record.cell.steer({"kind": "eki-drop", "lasts_ms": 6000000})
    record.badly("cell.connect", "no controller")
    record.well("cell.status", "fault", True)
    record.well("cell.acknowledge", "a fault")
    record.client.until(event("fault", active=False))
    keep_events(record)
    record.well("audit.list", "well", True, limit=200)
    (record.cell.folder / "demo.sqlite.audit").unlink()
    record.well("audit.acknowledge", name="Anna Beer")
    record.well("events.unsubscribe")


def keep_events(record):
    """The events of each topic in their order, each by the members that are reproducible, and the shape of all."""
    named = {"cell": ("from", "state", "reason"), "campaign": ("kind", "phase", "reason"), "measurement": ("purpose", "reason"),
            "model": ("change",), "fault": ("code", "severity", "active", "text"), "control": ("change", "method", "result"),
            "stream": (), "log": ()}
    events = [message["params"] for message in record.client.notifications[:record.client.passed] if message["method"] == "event"]
    for topic, members in named.items():
        of_topic = [event["data"] for event in events if event["topic"] == topic]
        in_order = [data for data in of_topic if record.paused not in (data.get("id"), data.get("campaign_id"))]
        if topic == "cell":  # a device that is waited for
            in_order = [data for data in in_order if data["from"] != data["state"]]
        kinds = [" ".join(str(data[member]) for member in members if data.get(member, "") != "") for data in in_order]
        if topic == "log":
            lines = [f"{data['level']} {data['text']}" for data in of_topic if UNTIMED_LOG.match(data["text"])]
            kinds = sorted({normal_form.masked(line, record.masks) for line in lines})
        kinds = [kind for kind, before in zip(kinds, [None, *kinds]) if kind and kind != before]
        record.keep(f"events/{topic}", *(normal_form.masked(kind, record.masks) for kind in kinds), "== shape", normal_form.shape(*of_topic, hidden=UNTYPED))
    jobs = [message["params"] for message in record.client.notifications if message["method"] == "job"]
    record.keep("events/job", normal_form.shape(*jobs, hidden=UNTYPED))


def outputs(bin_folder, source):
    """{name: text} of all that is asked."""
    schema = json.loads((source / "proto/control/openrpc.json").read_text(encoding="utf-8"))
    with LiveCell(bin_folder, source, speedup=1000) as cell:
        record = Record(cell)
        open_sessions(record)
        ask_at_rest(record)
        refuse_everything(record, schema)
        refuse_without_model(record)
        control(record)
        ids = campaigns(record)
        models(record)
        commands(record, ids["calibration"])
        campaign_files(record, ids)
        paused_campaign(record)
        stream(record)
        files(record)
        faults(record)
    for how, asked in record.asked.items():
        if missing := {method["name"] for method in schema["methods"]} - asked:
            raise RuntimeError(f"never asked {how}: {', '.join(sorted(missing))}")
    return {f"online/{name}": "\n".join(texts) + "\n" for name, texts in record.files.items()}
