/** A session with the control port of a daemon: JSON-RPC 2.0, one object a line (proto/control/openrpc.json). */
import { createHmac, randomBytes, timingSafeEqual } from "node:crypto";
import { EventEmitter } from "node:events";
import net from "node:net";
import tls from "node:tls";

const MAX_LINE = 1024 * 1024; // the daemon's own bound is 64 KiB
/** With what the daemon answers at once; a command may take long, as moving an arm does. */
export const SHORT_PATIENCE_MS = 5_000;
const LONG_PATIENCE_MS = 120_000;
/** Tokens that begin so are known to the daemon by their hash alone, which can check no proof. */
const ACCESS_TOKEN_START = "access-";
/** Symbols of errors that come without one. */
const SYMBOLS = { "-32700": "E_PARSE", "-32600": "E_REQUEST", "-32601": "E_METHOD", "-32602": "E_PARAMS" };

/** What the daemon refused, or why it could not be asked. */
export class ControlError extends Error {
  /**
   * @param {string} code  the error's stable name: E_STATE; of our own: E_UNREACHABLE, E_LOST, E_TIMEOUT
   * @param {string} message  one sentence
   */
  constructor(code, message) {
    super(message);
    this.code = code;
  }
}

/** @param error  of a JSON-RPC reply; most messages say themselves what the state allows, and all where they are about */
function refusal(error) {
  const { code, state, allowed = [] } = error.data ?? {};
  let message = error.message ?? "refused";
  if (allowed.length > 0 && !message.includes("allowed: "))
    message += `; the state is ${state}, which allows ${allowed.join(", ")}`;
  return new ControlError(code ?? SYMBOLS[error.code] ?? "E_INTERNAL", message);
}

/** HMAC that shows the daemon that a client knows its token, and a client that the daemon does. */
function proof(token, prover, endpoint, clientNonce, serverNonce) {
  const text = ["truepose session 1", prover, endpoint, clientNonce, serverNonce, ""].join("\n");
  return createHmac("sha256", token).update(text).digest("hex");
}

/** Emits "event" ({seq, time, topic, data}) and, once, "closed" (why). */
export class ControlSession extends EventEmitter {
  #socket;
  #where;
  #input = "";
  #waiting = new Map(); // of each request's id: {resolve, reject, timer}
  #lastId = 0;
  #farewell = "";
  #closed = ""; // why

  /**
   * Connects and says hello.
   *
   * @param daemon  {host, port, tls}: tls is left out, or {ca} and perhaps {cert, key}, all PEM
   * @param token   left out where the certificate is known by the daemon
   * @returns the session; `hello` holds the daemon's welcome (name, role, next_seq, ...)
   */
  static async open(daemon, token) {
    const session = new ControlSession();
    await session.#connect(daemon, token);
    try {
      session.hello = await session.#sayHello(daemon, token);
    } catch (error) {
      session.close();
      throw error;
    }
    return session;
  }

  /** @throws ControlError */
  call(method, params = {}, patience_ms = LONG_PATIENCE_MS) {
    if (this.#closed) return Promise.reject(new ControlError("E_LOST", this.#closed));
    const id = ++this.#lastId;
    return new Promise((resolve, reject) => {
      const late = `${this.#where} did not answer ${method} within ${patience_ms / 1000} s`;
      const expire = () => this.#settle(id, "reject", new ControlError("E_TIMEOUT", late));
      this.#waiting.set(id, { resolve, reject, timer: setTimeout(expire, patience_ms) });
      this.#socket.write(JSON.stringify({ jsonrpc: "2.0", id, method, params }) + "\n");
    });
  }

  close() {
    this.#end("the connection to the daemon was closed");
  }

  #connect(daemon, token) {
    this.#where = `the daemon at ${daemon.host}:${daemon.port}`;
    const { ca, cert, key } = daemon.tls ?? {};
    // Whoever shows a token is known by that: not by the certificate of this server.
    const identity = token === undefined ? { cert, key } : {};
    const at = { host: daemon.host, port: daemon.port };
    this.#socket = daemon.tls ? tls.connect({ ...at, ca, ...identity, minVersion: "TLSv1.3" }) : net.connect(at);
    this.#socket.setNoDelay(true).setKeepAlive(true, 10_000).setEncoding("utf8");
    this.#socket.on("data", (text) => this.#read(text));
    this.#socket.on("close", () => this.#end(this.#farewell || `${this.#where} closed the connection`));
    return new Promise((resolve, reject) => {
      const fail = (why) => {
        this.#end(why);
        reject(new ControlError("E_UNREACHABLE", `${this.#where} cannot be reached: ${why}`));
      };
      this.#socket.setTimeout(SHORT_PATIENCE_MS, () => fail("no answer"));
      this.#socket.on("error", (error) => fail(error.message));
      this.#socket.once(daemon.tls ? "secureConnect" : "connect", () => {
        this.#socket.setTimeout(0);
        resolve();
      });
    });
  }

  #sayHello(daemon, token) {
    if (token === undefined) return this.call("session.hello", { protocol: 1 }, SHORT_PATIENCE_MS);
    if (daemon.tls || token.startsWith(ACCESS_TOKEN_START))
      return this.call("session.hello", { protocol: 1, token }, SHORT_PATIENCE_MS);
    return this.#helloByProof(token);
  }

  // Another server at the daemon's port learns nothing from it, and is detected unless it knows the token too.
  async #helloByProof(token) {
    const endpoint = `${this.#socket.remoteAddress} ${this.#socket.remotePort}`;
    const { nonce: theirs } = await this.call("session.challenge", {}, SHORT_PATIENCE_MS);
    const ours = randomBytes(16).toString("hex");
    const hello = await this.call(
      "session.hello",
      { protocol: 1, nonce: ours, proof: proof(token, "client", endpoint, ours, theirs) },
      SHORT_PATIENCE_MS,
    );
    const expected = Buffer.from(proof(token, "server", endpoint, ours, theirs));
    const given = Buffer.from(String(hello.proof));
    if (given.length !== expected.length || !timingSafeEqual(given, expected))
      throw new ControlError("E_UNREACHABLE", `whoever answers as ${this.#where} does not know the token`);
    return hello;
  }

  #read(text) {
    this.#input += text;
    const lines = this.#input.split("\n");
    this.#input = lines.pop();
    if (this.#input.length > MAX_LINE) return this.#end(`${this.#where} sends lines without end`);
    for (const line of lines) this.#take(line);
  }

  #take(line) {
    let message;
    try {
      message = JSON.parse(line);
    } catch {
      return this.#end(`${this.#where} does not speak JSON`);
    }
    if (message.method === "event") return void this.emit("event", message.params);
    if (message.method !== undefined) return; // a notification of a later protocol: its greeting, say
    if (message.id === null || message.id === undefined) this.#farewell = message.error?.message ?? this.#farewell;
    else if (message.error) this.#settle(message.id, "reject", refusal(message.error));
    else this.#settle(message.id, "resolve", message.result);
  }

  #settle(id, how, value) {
    const waiting = this.#waiting.get(id);
    if (!waiting) return;
    this.#waiting.delete(id);
    clearTimeout(waiting.timer);
    waiting[how](value);
  }

  #end(why) {
    if (this.#closed) return;
    this.#closed = why;
    this.#socket.destroy();
    for (const id of [...this.#waiting.keys()]) this.#settle(id, "reject", new ControlError("E_LOST", why));
    this.emit("closed", why);
  }
}
