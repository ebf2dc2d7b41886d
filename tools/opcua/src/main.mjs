#!/usr/bin/env node
/** truepose-opcua: shows a cell to OPC UA clients, and carries out what they command. */
import "./web_crypto.mjs";
import { existsSync, renameSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { Alarms, LOST } from "./alarms.mjs";
import { CellEvents } from "./cell_events.mjs";
import { CellLink } from "./cell_link.mjs";
import { CellMethods } from "./cell_methods.mjs";
import { CellObject } from "./cell_object.mjs";
import { Mirror } from "./mirror.mjs";
import { OptionError, USAGE, readOptions } from "./options.mjs";
import { Robotics } from "./robotics.mjs";
import { Schema } from "./schema.mjs";
import { makeServer, ownNamespace } from "./server.mjs";
import { UserSessions } from "./user_sessions.mjs";

const BAD_USAGE = 2, UNREACHABLE = 3;

const log = (text) => process.stderr.write(`truepose-opcua: ${text}\n`);

/** The daemon's own description of its methods: next to this file if installed, else where the sources have it. */
function openrpcFile() {
  const files = ["../openrpc.json", "../../../proto/control/openrpc.json"];
  return files.map((file) => fileURLToPath(new URL(file, import.meta.url))).find(existsSync);
}

/** Nobody sees a part of it. */
function writeWhole(file, text) {
  writeFileSync(`${file}.new`, text);
  renameSync(`${file}.new`, file);
}

/** Lets the address space follow the cell. */
function follow(link, mirror, robotics, alarms, events) {
  let reachable;
  link.on("status", (status) => {
    if (reachable !== true) log("the daemon answers");
    reachable = true;
    robotics.show(status);
    mirror.show(status);
    alarms.show(status.faults ?? []);
  });
  link.on("lost", (why) => {
    if (reachable === false) return;
    reachable = false;
    log(why);
    mirror.lose();
    alarms.begin({ code: LOST, severity: "error", text: why, since: new Date().toISOString() });
  });
  link.on("event", (event) => {
    if (event.topic === "fault") event.data.active ? alarms.begin(event.data) : alarms.end(event.data.code);
    events.raise(event);
  });
  link.on("missed", (missed) => events.raiseMissed(missed));
}

async function run(options) {
  const schema = Schema.read(openrpcFile());
  const users = new UserSessions(options.daemon);
  const server = await makeServer(options, users, log);
  const namespace = ownNamespace(server);
  const mirror = new Mirror();
  const link = new CellLink(options.daemon, options.token);
  const { node: cell } = new CellObject(namespace, mirror, schema);
  new CellMethods(namespace, cell, users, schema, () => link.refresh());
  const acknowledge = (user) => users.call(user, "cell.acknowledge", {}, true);
  follow(
    link,
    mirror,
    new Robotics(namespace, mirror),
    new Alarms(namespace, cell, acknowledge),
    new CellEvents(namespace, cell),
  );

  await server.start();
  const [{ endpointUrl: endpoint }] = server.endpoints[0].endpointDescriptions();
  log(`serves ${endpoint}; trust list ${options.pki}/trusted/certs`);
  if (options.readyFile) writeWhole(options.readyFile, JSON.stringify({ endpoint, pki: options.pki }));
  const stop = async () => {
    link.stop();
    users.close();
    await server.shutdown(0);
    process.exit(0);
  };
  process.once("SIGTERM", stop).once("SIGINT", stop);
  await link.run();
}

try {
  const options = readOptions(process.argv.slice(2));
  if (options.help) process.stdout.write(USAGE);
  else await run(options);
} catch (error) {
  log(error.message);
  process.exit(error instanceof OptionError ? BAD_USAGE : error.code === "EADDRINUSE" ? UNREACHABLE : 1);
}
