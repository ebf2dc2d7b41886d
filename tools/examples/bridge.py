"""The half of a bridge that has nothing to do with a tracker: the lines of docs/trackers.md, for one client at a time.

    class Tracker:                         # one method for each request that it offers, by its name
        not_offered = {"face": "the T3 has one face"}  # and a sentence for each that it does not
        state = {"initialised": False, "locked": False, "face": 0, "reflector": "", "reflectors": []}
        async def status(self): ...        # returns a dictionary, which is the answer
        async def measure(self, time_ms): ...
        async def interrupt(self): ...     # ends what was under way in the device
        async def look(self): ...          # every 0.3 s while nothing is under way: brings state["locked"] up to date

    asyncio.run(serve("0.0.0.0", 7700, Tracker(), {"bridge": "acme-bridge 1.0", "model": "T3", "serial": "4711", "firmware": ""}))

A method raises Refused with a code of that page. What takes time runs as a task, so that ping is answered meanwhile.
"""
import asyncio
import contextlib
import json

MEMBERS = {"hello": ["protocol"], "ping": [], "status": [], "stop": [], "initialise": [], "reflector": ["name"], "face": ["face"],
           "air": ["temperature_c", "pressure_mbar", "humidity_percent"], "aim": ["x", "y", "z", "search_mm", "timeout_ms"],
           "measure": ["time_ms"]}
LINE, WATCH_S = 64 * 1024, 0.3


class Refused(Exception):
    """Why a request is not carried out: a code of the page, and one sentence for the operator."""

    def __init__(self, code, text):
        super().__init__(text)
        self.code = code


async def serve(host, port, tracker, greeting):
    bridge = Bridge(tracker, {"protocol": 1} | greeting)
    server = await asyncio.start_server(bridge.client, host, port, limit=LINE)
    print(f"listening on port {server.sockets[0].getsockname()[1]}", flush=True)
    async with server:
        await server.serve_forever()


class Bridge:
    def __init__(self, tracker, greeting):
        self.tracker, self.greeting = tracker, greeting
        self.writer = self.job = None
        self.greeted = False

    def send(self, line):
        self.writer.write(json.dumps(line).encode() + b"\n")

    def refuse(self, request_id, code, text):
        self.send({"id": request_id, "ok": False, "code": code, "text": text})

    async def client(self, reader, writer):
        if self.writer:
            writer.write(json.dumps({"id": None, "ok": False, "code": "busy", "text": "another client is connected"}).encode() + b"\n")
            return writer.close()
        self.writer, self.greeted, watch = writer, False, asyncio.create_task(self.watch())
        try:
            while line := await reader.readline():
                await self.take(line)
        except (OSError, ValueError) as error:  # a reset; a line beyond the limit
            print(f"the client's connection ended: {error}", flush=True)
        watch.cancel()
        await self.stop()
        self.writer = None
        writer.close()

    async def take(self, line):
        try:
            request = json.loads(line)
            request_id, do = request["id"], request.get("do")
            if type(request_id) is not int or request_id < 1:
                raise ValueError("id")
        except (ValueError, KeyError, TypeError, AttributeError):
            return self.refuse(None, "bad-request", "no JSON object with an id of 1 or more")
        members = {name: request.get(name) for name in MEMBERS.get(do, [])}
        wrong = [name for name, value in members.items() if not isinstance(value, str if name == "name" else (int, float))]
        if not self.greeted and do != "hello":
            self.refuse(request_id, "bad-request", "say hello first")
        elif wrong:
            self.refuse(request_id, "bad-request", f"{do}: {wrong[0]} is missing or of another type")
        elif do == "hello":
            self.greeted = True
            self.send({"id": request_id, "ok": True} | self.greeting)
        elif do in ("ping", "stop"):
            if do == "stop":
                await self.stop()
            self.send({"id": request_id, "ok": True})
        elif do not in MEMBERS or not hasattr(self.tracker, do):
            self.refuse(request_id, "not-offered", self.tracker.not_offered.get(do, f"{do}: no such request"))
        elif self.job and do == "status":
            self.send({"id": request_id, "ok": True, "state": "busy"} | self.tracker.state)
        elif self.job:
            self.refuse(request_id, "busy", "the tracker does something else")
        else:
            self.job = asyncio.create_task(self.carry_out(request_id, do, members))
            await asyncio.sleep(0)  # it has begun before it can be stopped

    async def carry_out(self, request_id, do, members):
        was_locked = self.tracker.state["locked"]
        line = {"id": request_id, "ok": True}
        try:
            line |= await getattr(self.tracker, do)(**members) or {}
        except Refused as refused:
            line |= {"ok": False, "code": refused.code, "text": str(refused)}
        except asyncio.CancelledError:
            line |= {"ok": False, "code": "stopped", "text": "stopped when asked to"}
        except Exception as error:  # of the SDK: whatever it is, the request has to be answered
            line |= {"ok": False, "code": "failed", "text": f"{type(error).__name__}: {error}"}
        self.job = None
        self.report(was_locked)
        self.send(line)

    async def stop(self):
        if job := self.job:
            job.cancel()
            await asyncio.wait([job])
            await self.tracker.interrupt()

    def report(self, was_locked):
        if self.tracker.state["locked"] != was_locked:
            self.send({"event": "beam-lost" if was_locked else "beam-found"})

    async def watch(self):
        while True:
            await asyncio.sleep(WATCH_S)
            was_locked = self.tracker.state["locked"]
            if not self.job:
                with contextlib.suppress(Exception):  # the next request says what is wrong
                    await self.tracker.look()
                self.report(was_locked)
