/**
 * The OPC UA server as its users start it, before a real daemon (over TLS) and the simulated cell, by node-opcua's client:
 *
 *     opcua_test.mjs BIN SOURCE SERVER      SERVER: the folder of tools/install-opcua
 */
import assert from "node:assert/strict";
import { webcrypto } from "node:crypto";
import { existsSync, mkdtempSync, readFileSync, readdirSync, renameSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import net from "node:net";
import os from "node:os";
import path from "node:path";
import { after, before, test } from "node:test";
import { setTimeout as delay } from "node:timers/promises";
import { CELL_HOST, LiveCell, spawnAtCell } from "./live_cell.mjs";

const [bin, source, folderOfServer] = process.argv.slice(2);
globalThis.crypto ??= webcrypto; // in Node 18 too
const opcua = createRequire(`${path.resolve(folderOfServer)}/`)("node-opcua");
const { ControlSession } = await import(path.resolve(folderOfServer, "src/control_session.mjs"));
const { storeOf } = await import(path.resolve(folderOfServer, "src/server.mjs"));
const { AttributeIds, DataType, MessageSecurityMode, SecurityPolicy, StatusCodes, UserTokenType } = opcua;

const SMALL = { identify_poses: 12, validate_poses: 6, remeasure: false, activate: false }; // a campaign
const SECURE = { securityMode: MessageSecurityMode.SignAndEncrypt, securityPolicy: SecurityPolicy.Basic256Sha256 };
const PATIENCE_MS = 100_000; // no expectation: beyond it something hangs

const folder = mkdtempSync(path.join(os.tmpdir(), "truepose-opcua-"));
const tokens = {};
let cell, server, endpoint, pki, ours;

before(async () => {
  cell = await LiveCell.start(bin, source, "--tls", CELL_HOST);
  await cell.offline("tls", "client", "Gateway", "--dir", tls(""));
  await cell.access("Gateway", "viewer", "--certificate", tls("Gateway.pem"));
  tokens["Panel 1"] = await cell.access("Panel 1", "operator");
  tokens.Anna = await cell.access("Anna", "engineer");
  [{ endpoint, pki }, ours] = await Promise.all([startServer(), clientOf("panel")]);
});

after(async () => {
  await session?.close();
  await Promise.all(clients.map((client) => client.disconnect()));
  server?.kill();
  await cell?.end();
  rmSync(folder, { recursive: true, force: true });
});

// ---- What the tests are made of ----

const tls = (file) => path.join(cell.place.folder, "tls", file);

async function startServer() {
  const ready = path.join(folder, "ready.json");
  const options = {
    "--daemon": `${cell.place.host}:${cell.place.tls_port}`,
    "--tls-ca": tls("ca.pem"),
    "--cert": tls("Gateway.pem"),
    "--key": tls("Gateway.key"),
    "--listen": `${CELL_HOST}:0`,
    "--pki": path.join(folder, "pki"),
    "--ready-file": ready,
  };
  const words = [path.join(folderOfServer, "src/main.mjs"), ...Object.entries(options).flat()];
  server = spawnAtCell(process.execPath, words, { stdio: ["ignore", "ignore", "inherit"] });
  await until(() => existsSync(ready) || server.exitCode !== null, 20);
  assert.equal(server.exitCode, null, "the server ended");
  return JSON.parse(readFileSync(ready));
}

async function until(condition, pause_ms = 50) {
  for (const end = Date.now() + PATIENCE_MS; !(await condition()); await delay(pause_ms))
    assert.ok(Date.now() < end, `waited in vain for: ${condition}`);
}

const clients = [];

/** A client with a certificate of its own. */
async function clientOf(name, security = SECURE) {
  const certificates = new opcua.OPCUACertificateManager({
    rootFolder: path.join(folder, name),
    automaticallyAcceptUnknownCertificate: true,
  });
  await certificates.initialize();
  return clientWith(certificates, name, security);
}

function clientWith(clientCertificateManager, name, security = SECURE) {
  const client = opcua.OPCUAClient.create({
    ...security,
    applicationName: name,
    clientCertificateManager,
    endpointMustExist: false,
    connectionStrategy: { maxRetry: 0 },
  });
  clients.push(client);
  return client;
}

/** What an attempt is refused with. */
async function refusal(attempt) {
  try {
    await attempt();
  } catch (error) {
    return error.message;
  }
  return "";
}

const userOf = (userName, password = tokens[userName]) => ({ type: UserTokenType.UserName, userName, password });

let session; // of Panel 1
const index = (uri) => session.getNamespaceIndex(uri);
const own = (id) => `ns=${index("urn:truepose:opcua")};s=${id}`;
const read = (id, attributeId = AttributeIds.Value) => session.read({ nodeId: own(id), attributeId });
const valueOf = async (id) => (await read(id)).value.value;
const isState = (state) => async () => (await valueOf("state")) === state;

/** Calls a method of the cell. Returns {status, and each output by its name}. */
async function call(name, inputs = [], by = session) {
  const methodId = own(`method.${name}`);
  const { outputArguments: described } = await by.getArgumentDefinition(methodId);
  const inputArguments = inputs.map((value) => ({ dataType: DataType.String, value }));
  const result = await by.call({ objectId: own("truepose"), methodId, inputArguments });
  const outputs = (result.outputArguments ?? []).map((output, at) => [described[at].name, output.value]);
  return { status: result.statusCode, ...Object.fromEntries(outputs) };
}

async function succeeds(name, inputs, by) {
  const result = await call(name, inputs, by);
  assert.equal(result.status, StatusCodes.Good, `${name}: ${result.Message}`);
  assert.equal(result.Code, "ok");
  return result;
}

/** The value at a path of names below Objects; T: stands for our namespace, R: for Robotics', D: for Devices'. */
async function valueAt(names) {
  const foundation = "http://opcfoundation.org/UA/";
  const uris = { T: "urn:truepose:opcua", R: `${foundation}Robotics/`, D: `${foundation}DI/` };
  const qualified = names.replace(/\b([TRD]):/g, (_, letter) => `${index(uris[letter])}:`);
  const found = await session.translateBrowsePath(opcua.makeBrowsePath("ObjectsFolder", qualified));
  assert.equal(found.statusCode, StatusCodes.Good, names);
  return (await session.read({ nodeId: found.targets[0].targetId })).value.value;
}

/** Collects events of the cell. */
async function eventsOf(type, fields) {
  const subscription = await session.createSubscription2({ requestedPublishingInterval: 50, publishingEnabled: true });
  const filter = opcua.constructEventFilter(fields, opcua.ofType(type));
  const item = await subscription.monitor(
    { nodeId: own("truepose"), attributeId: AttributeIds.EventNotifier },
    { samplingInterval: 0, queueSize: 1000, filter },
    opcua.TimestampsToReturn.Both,
  );
  const events = [];
  const name = (field) => field.split(".").at(-1) + (field.includes("State.Id") ? field.split(".").at(-2) : "");
  item.on("changed", (values) => events.push(Object.fromEntries(values.map(({ value }, at) => [name(fields[at]), value]))));
  return events;
}

// ---- The daemon ----

test("In the clear the daemon's own token is proved, and sent only to a server that can prove it too", async () => {
  const { host, port, token } = cell.place;
  const session = await ControlSession.open({ host, port }, token);
  assert.equal(session.hello.name, "token file");
  assert.equal((await session.call("cell.status")).cell, "demo");
  session.close();
  await assert.rejects(ControlSession.open({ host, port }, "0".repeat(32)), { code: "E_UNAUTHENTICATED" });

  const heard = [];
  const squatter = net.createServer((socket) => {
    socket.setEncoding("utf8").on("data", (line) => {
      heard.push(line);
      const result = { nonce: "0".repeat(32), proof: "0".repeat(64), name: "token file" };
      socket.write(JSON.stringify({ jsonrpc: "2.0", id: JSON.parse(line).id, result }) + "\n");
    });
  });
  await new Promise((resolve) => squatter.listen(0, host, resolve));
  await assert.rejects(ControlSession.open({ host, port: squatter.address().port }, token), /does not know the token/);
  assert.ok(!heard.join("").includes(token));
  squatter.close();
});

test("Over TLS a daemon of another CA is none", async () => {
  await cell.offline("tls", "init", "--dir", tls("other"), "--host", "127.0.0.1");
  const { host, tls_port: port } = cell.place;
  const daemon = { host, port, tls: { ca: readFileSync(tls("other/ca.pem")) } };
  await assert.rejects(ControlSession.open(daemon, tokens.Anna), { code: "E_UNREACHABLE" });
});

// ---- Who is let in ----

test("A client whose certificate is not in the trust list is refused, until it is put there", async () => {
  assert.match(await refusal(() => ours.connect(endpoint)), /certificate|BadSecurityChecksFailed/i);
  const rejected = path.join(pki, "rejected");
  await until(() => readdirSync(rejected).length === 1);
  const [file] = readdirSync(rejected);
  renameSync(path.join(rejected, file), path.join(pki, "trusted/certs", file));
  await until(async () => (await refusal(() => ours.connect(endpoint))) === "");
});

test("The files decide: moved into the trust list a certificate is trusted at once, taken out of it at once no more", async () => {
  const at = path.join(folder, "store");
  const store = await storeOf(at);
  const verdict = () => store.verifyCertificate(ours.getCertificate());
  assert.equal(await store.isCertificateTrusted(ours.getCertificate()), "BadCertificateUntrusted");
  const [file] = readdirSync(path.join(at, "rejected"));
  const [rejected, trusted] = [path.join(at, "rejected", file), path.join(at, "trusted/certs", file)];
  renameSync(rejected, trusted);
  assert.deepEqual(await Promise.all([verdict(), verdict(), verdict()]), ["Good", "Good", "Good"]);
  renameSync(trusted, rejected);
  assert.equal(await verdict(), "BadCertificateUntrusted");
  await store.dispose();
});

test("A client that goes on trying takes no certificate away from those that are trusted", async () => {
  const at = path.join(folder, "tried");
  const certificate = ours.getCertificate();
  const store = await storeOf(at);
  await store.isCertificateTrusted(certificate);
  const [file] = readdirSync(path.join(at, "rejected"));
  renameSync(path.join(at, "rejected", file), path.join(at, "trusted/certs", file));
  await store.rejectCertificate(certificate);
  assert.deepEqual(readdirSync(path.join(at, "trusted/certs")), [file]);
  assert.deepEqual(readdirSync(path.join(at, "rejected")), []);
  assert.equal(await store.verifyCertificate(certificate), "Good");
  await store.dispose();
});

test("Without encryption no session is opened", async () => {
  const none = { securityMode: MessageSecurityMode.None, securityPolicy: SecurityPolicy.None };
  const open = await clientOf("open", none);
  const refused = await refusal(async () => {
    await open.connect(endpoint);
    await open.createSession(userOf("Panel 1"));
  });
  assert.notEqual(refused, "");
  const offered = await ours.getEndpoints();
  assert.deepEqual([...new Set(offered.map(({ securityMode }) => securityMode))], [MessageSecurityMode.SignAndEncrypt]);
});

test("Nobody is let in without a name, with a wrong token, or with somebody else's", async () => {
  for (const user of [undefined, userOf("Panel 1", "access-0"), userOf("Panel 1", tokens.Anna)])
    assert.match(await refusal(() => ours.createSession(user)), /BadIdentityToken|BadUserAccessDenied|find ANONYMOUS/);
  session = await ours.createSession(userOf("Panel 1"));
  await session.readNamespaceArray();
});

test("Each of twenty clients has a session over a connection of its own, and one more gets the reason that there are too many", async () => {
  const others = Array.from({ length: 20 }, () => clientWith(ours.clientCertificateManager, "panel"));
  for (const client of others) await client.connect(endpoint);
  const open = [];
  for (const client of others.slice(0, 19)) open.push(await client.createSession(userOf("Panel 1")));
  assert.match(await refusal(() => others[19].createSession(userOf("Panel 1"))), /BadTooManySessions/);
  await Promise.all(open.map((one) => one.close()));
  await Promise.all(others.map((client) => client.disconnect()));
  await session.readNamespaceArray();
});

// ---- What it shows ----

test("The cell's state is shown with types, units and descriptions of the control port's schema", async () => {
  await until(isState("disconnected"));
  assert.equal(await valueOf("cell"), "demo");
  assert.deepEqual(await valueOf("allowed"), ["cell.connect", "campaign.start"]);
  assert.match((await read("stream.correction_deg", AttributeIds.Description)).value.value.text, /Correction sent/);
  assert.equal((await valueAt("/T:truepose/T:Stream/T:MaxStep.EngineeringUnits")).displayName.text, "°");
  assert.equal((await read("stream.cycles")).value.dataType, DataType.Int64);
});

test("What is not known is no number", async () => {
  assert.equal((await read("stream.robot.override_percent")).statusCode, StatusCodes.BadWaitingForInitialData);
  assert.equal((await read("campaign.done")).statusCode, StatusCodes.BadWaitingForInitialData);
  assert.equal(await valueOf("stream.reason"), "");
});

test("The arm is found where OPC UA for Robotics has it", async () => {
  assert.equal((await succeeds("Connect")).State, "ready");
  await until(isState("ready"));
  const below = (names) => valueAt(`/D:DeviceSet/T:MotionDeviceSystem/${names}`);
  assert.equal((await below("R:MotionDevices/T:MotionDevice/D:Model")).text, "#KR210R2700_2 C4 FLR");
  assert.equal((await below("R:MotionDevices/T:MotionDevice/D:Manufacturer")).text, "KUKA");
  assert.equal(await below("R:MotionDevices/T:MotionDevice/D:SerialNumber"), "210001");
  assert.equal(await below("R:MotionDevices/T:MotionDevice/R:Axes/T:A2/D:ParameterSet/R:ActualPosition"), -90);
  assert.match(await below("R:Controllers/T:Controller/R:Software/T:SystemSoftware/D:SoftwareRevision"), /KSS/);
  await until(async () => (await below("R:SafetyStates/T:SafetyState/D:ParameterSet/R:OperationalMode")) === 4);
  assert.equal(await below("R:SafetyStates/T:SafetyState/D:ParameterSet/R:EmergencyStop"), false);
  const operation = "R:Controllers/T:Controller/R:TaskControls/T:RobotInterpreter/R:TaskControlOperation";
  assert.equal((await below(`${operation}/R:TaskControlStateMachine/CurrentState`)).text, "Executing");
});

// ---- What it does ----

test("A campaign is started, paused, resumed and followed to its model", async () => {
  const events = await eventsOf(own("TrueposeEventType"), ["Message"]);
  const started = await succeeds("StartCampaign", [JSON.stringify({ kind: "calibration", ...SMALL })]);
  assert.equal(started.Total[1], JSON.parse(started.Result).total);
  assert.equal(await valueOf("state"), "campaign");
  await succeeds("PauseCampaign");
  await until(isState("paused"));
  assert.equal((await succeeds("ResumeCampaign", [""])).Id, started.Id);
  await until(isState("ready"));
  await until(() => events.some(({ Message }) => /campaign done/.test(Message.text)));
});

test("Only a user with the role may activate a model, and the daemon's reason is reported", async () => {
  const { Result } = await succeeds("Call", ["model.list", '{"limit": 1}']);
  const { id } = JSON.parse(Result).models[0];
  const refused = await call("ActivateModel", [id]);
  assert.equal(refused.status, StatusCodes.BadUserAccessDenied);
  assert.equal(refused.Code, "E_FORBIDDEN");
  assert.match(refused.Message, /needs the role engineer; Panel 1 is operator/);
  assert.equal(await valueOf("last.message"), refused.Message);
  const anna = await ours.createSession(userOf("Anna"));
  assert.equal((await succeeds("ActivateModel", [id], anna)).Id, id);
  await anna.close();
  await until(async () => (await valueOf("model.id")) === id);
});

test("What the state does not allow, or cannot be, is refused by its own status", async () => {
  const paused = await call("PauseCampaign");
  assert.equal(paused.status, StatusCodes.BadInvalidState);
  assert.match(paused.Message, /state ready; allowed: .*campaign\.start/);
  const resumed = await call("ResumeCampaign", [""]);
  assert.equal(resumed.Message.match(/campaign\.start/g).length, 1, resumed.Message);
  assert.equal((await call("StartCampaign", ["[1]"])).status, StatusCodes.BadInvalidArgument);
  const unknown = await call("StartCampaign", ['{"poses_of": 1}']);
  assert.equal(unknown.status, StatusCodes.BadInvalidArgument);
  assert.equal(unknown.Message.match(/params\.poses_of/g).length, 1, unknown.Message);
  const nowhere = JSON.stringify({ id: "00000000-0000-4000-8000-000000000000" });
  assert.equal((await call("Call", ["model.get", nowhere])).status, StatusCodes.BadNotFound);
  assert.equal((await call("Call", ["session.hello", ""])).status, StatusCodes.BadNotSupported);
});

test("The stream is armed and disarmed, a drift check runs, and a campaign is aborted", async () => {
  await succeeds("CheckDrift", ['{"poses": 3}']);
  await until(isState("ready"));
  await succeeds("StartCampaign", [""]);
  await succeeds("Abort", [""]);
  await until(async () => (await valueOf("state")) !== "campaign"); // its devices may not have been connected yet
  assert.equal((await succeeds("Arm")).State, "waiting");
  await until(isState("armed"));
  await succeeds("Disarm");
  await until(async () => !["armed"].includes(await valueOf("state")));
});

// ---- Faults ----

test("A fault is an alarm, and who acknowledges it acknowledges it at the daemon", async () => {
  const fields = ["EventId", "ConditionName", "Message", "Severity", "ActiveState.Id", "AckedState.Id", "Retain"];
  const alarms = await eventsOf("AlarmConditionType", fields);
  if ((await valueOf("state")) !== "ready") await succeeds("Connect");
  await succeeds("StartStream");
  await until(isState("streaming"));
  await cell.order({ do: "steer", line: { kind: "rsi-silence", lasts_ms: 1000 } });
  const isStanding = ({ ConditionName, IdActiveState }) => ConditionName === "E_CELL" && IdActiveState;
  await until(() => alarms.some(isStanding));
  const alarm = alarms.find(isStanding);
  assert.equal(alarm.Severity, 800);
  assert.match(alarm.Message.text, /no RSI packet/);
  assert.equal(alarm.IdAckedState, false);

  const unknown = await session.acknowledgeCondition(own("alarm.E_CELL"), Buffer.from("0"), "seen");
  assert.equal(unknown, StatusCodes.BadEventIdUnknown);
  const seen = await session.acknowledgeCondition(own("alarm.E_CELL"), alarm.EventId, "seen");
  assert.equal(seen, StatusCodes.Good);
  await until(isState("disconnected"));
  await until(() => alarms.some(({ IdActiveState, IdAckedState }) => !IdActiveState && IdAckedState));
});

/** Follows the alarm that stands while nothing is known of the daemon. Returns whether it ever became so, in `text`. */
async function lostAlarm() {
  const alarms = await eventsOf("AlarmConditionType", ["ConditionName", "Message", "ActiveState.Id"]);
  return (active, text = /./) =>
    alarms.some(
      ({ ConditionName, Message, IdActiveState }) =>
        ConditionName === "E_DAEMON_LOST" && IdActiveState === active && text.test(Message.text),
    );
}

test("Of a daemon that does not answer nothing is good, until it does", async () => {
  const isLost = await lostAlarm();
  await cell.order({ do: "freeze" });
  await until(async () => (await read("state")).statusCode === StatusCodes.BadNoCommunication);
  assert.equal((await read("stream.cycles")).statusCode, StatusCodes.BadNoCommunication);
  await until(() => isLost(true, /did not answer cell\.status within 5 s/));
  await cell.order({ do: "thaw" });
  await until(isState("disconnected"));
  await until(() => isLost(false));
});

test("While the daemon is away all is bad and an alarm says so; then it returns by itself", async () => {
  const isLost = await lostAlarm();
  await cell.order({ do: "stop" });
  await until(async () => (await read("state")).statusCode === StatusCodes.BadNoCommunication);
  assert.equal(await valueOf("state"), "unknown");
  assert.equal((await read("stream.cycles")).statusCode, StatusCodes.BadNoCommunication);
  await until(() => isLost(true));
  const refused = await call("Connect");
  assert.equal(refused.status, StatusCodes.BadNoCommunication);
  assert.match(refused.Message, /the daemon at 127\.0\.0\.1:\d+ cannot be reached/);
  await cell.order({ do: "start" });
  await until(isState("disconnected"));
  assert.equal(await valueOf("stream.state"), "off");
  await until(() => isLost(false));
  await succeeds("Connect");
  await succeeds("Disconnect");
});

test("The audit trail of the daemon says who commanded what", async () => {
  const records = JSON.parse((await cell.truepose("call", "audit.list", '{"limit": 100}')).out).records;
  const commands = records.filter(({ who }) => who).map(({ who, role, method }) => `${who} (${role}) ${method}`);
  const methods = ["cell.connect", "campaign.start", "stream.arm", "cell.acknowledge"];
  for (const expected of [...methods.map((method) => `Panel 1 (operator) ${method}`), "Anna (engineer) model.activate"])
    assert.ok(commands.includes(expected), `${expected} is not among ${commands.join("; ")}`);
  assert.ok(!commands.some((command) => command.startsWith("Gateway")));
});

test("Whose access is revoked can command no more", async () => {
  await cell.offline("access", "revoke", "Panel 1", "--cell", cell.place.cell_file);
  assert.equal((await call("Disconnect")).status, StatusCodes.BadUserAccessDenied);
});
