/** The command line. What it says of the daemon is said as to `truepose`. */
import { readFileSync } from "node:fs";
import os from "node:os";
import path from "node:path";
import { parseArgs } from "node:util";

// tools/man-pages reads it here.
export const USAGE = `OPC UA server in front of the control port of a truepose daemon.
Usage: truepose-opcua [OPTIONS]

Options:
  --daemon HOST:PORT   the daemon; default $TRUEPOSE_DAEMON, else 127.0.0.1:7210
  --token-file FILE    with the token by which this server itself looks at the cell: a viewer's is enough; default
                       $TRUEPOSE_TOKEN_FILE
  --tls-ca FILE        HOST:PORT is the daemon's TLS port; its certificate is from this CA (PEM); default $TRUEPOSE_TLS_CA
  --cert FILE          certificate to be known by (PEM) instead of a token, with --key FILE
  --listen HOST:PORT   where OPC UA clients connect; default $TRUEPOSE_OPCUA_LISTEN, else 127.0.0.1:4840
  --pki DIR            own certificate and trust list; default $STATE_DIRECTORY/pki, else ~/.local/state/truepose-opcua/pki
  --policies LIST      security policies, with commas; default Basic256Sha256
  --anonymous          lets clients read without a user's name
  --ready-file FILE    is written once clients can connect: {"endpoint": ..., "pki": ...}
`;

/** What is wrong with the command line or a file that it names, one sentence. */
export class OptionError extends Error {}

const DEFAULTS = {
  daemon: { type: "string" },
  "token-file": { type: "string" },
  "tls-ca": { type: "string" },
  cert: { type: "string" },
  key: { type: "string" },
  listen: { type: "string" },
  pki: { type: "string" },
  policies: { type: "string", default: "Basic256Sha256" },
  anonymous: { type: "boolean", default: false },
  "ready-file": { type: "string" },
  help: { type: "boolean", short: "h", default: false },
};

function endpoint(option, text) {
  const [, host, port] = /^\[?([^\]]+)\]?:(\d{1,5})$/.exec(text) ?? [];
  if (!host || Number(port) > 65535) throw new OptionError(`--${option}: expected HOST:PORT, found '${text}'`);
  return { host, port: Number(port) };
}

function read(option, file) {
  try {
    return readFileSync(file, "utf8").trim();
  } catch (error) {
    throw new OptionError(`--${option}: ${file}: ${error.message}`);
  }
}

function parse(words) {
  try {
    return parseArgs({ args: words, options: DEFAULTS }).values;
  } catch (error) {
    throw new OptionError(`${error.message}; see --help`);
  }
}

/**
 * @param words  of the command line
 * @returns {help} or {daemon: {host, port, tls}, token, listen: {host, port}, pki, policies, anonymous, readyFile}
 * @throws OptionError
 */
export function readOptions(words, environment = process.env) {
  const given = parse(words);
  if (given.help) return { help: true };
  const daemon = endpoint("daemon", given.daemon ?? environment.TRUEPOSE_DAEMON ?? "127.0.0.1:7210");
  const ca = given["tls-ca"] ?? environment.TRUEPOSE_TLS_CA;
  if (given.cert && !(ca && given.key)) throw new OptionError("--cert: needs --key and --tls-ca");
  if (ca) daemon.tls = { ca: read("tls-ca", ca) };
  if (given.cert) Object.assign(daemon.tls, { cert: read("cert", given.cert), key: read("key", given.key) });
  const tokenFile = given.cert ? undefined : given["token-file"] ?? environment.TRUEPOSE_TOKEN_FILE;
  if (!given.cert && !tokenFile)
    throw new OptionError("no token: give --token-file FILE, or --cert and --key, or set TRUEPOSE_TOKEN_FILE");
  const state = environment.STATE_DIRECTORY ?? path.join(os.homedir(), ".local/state/truepose-opcua");
  return {
    daemon,
    token: tokenFile && read("token-file", tokenFile),
    listen: endpoint("listen", given.listen ?? environment.TRUEPOSE_OPCUA_LISTEN ?? "127.0.0.1:4840"),
    pki: path.resolve(given.pki ?? path.join(state, "pki")),
    policies: given.policies.split(","),
    anonymous: given.anonymous,
    readyFile: given["ready-file"],
  };
}
