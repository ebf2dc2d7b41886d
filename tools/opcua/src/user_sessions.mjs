/** The users of the OPC UA server at the daemon: each has sessions of his own there, so that the audit trail names him. */
import { randomUUID } from "node:crypto";
import { ControlError, ControlSession } from "./control_session.mjs";

export class UserSessions {
  #daemon;
  #users = new Map(); // of each name: {token, holders: OPC UA sessions, idle: ControlSession[]}

  /** @param daemon  as ControlSession.open takes it */
  constructor(daemon) {
    this.#daemon = daemon;
  }

  /**
   * Lets the daemon judge a user.
   *
   * @param holder  the OPC UA session that he opens; release() it at its end
   * @param token   the user's token at the control port
   * @throws ControlError
   */
  async enter(holder, name, token) {
    const session = await ControlSession.open(this.#daemon, token);
    if (session.hello.name !== name) {
      session.close();
      throw new ControlError("E_UNAUTHENTICATED", `the token is not that of ${name}`);
    }
    const user = this.#users.get(name) ?? { holders: new Set(), idle: [] };
    this.#users.set(name, user);
    user.token = token;
    user.holders.add(holder);
    this.#keep(user, session);
  }

  /** An OPC UA session has ended: with a user's last one all that is known of him is forgotten. */
  release(holder) {
    for (const [name, user] of this.#users) {
      if (!user.holders.delete(holder) || user.holders.size > 0) continue;
      this.#users.delete(name);
      for (const session of user.idle) session.close();
    }
  }

  close() {
    for (const user of this.#users.values()) for (const holder of user.holders) this.release(holder);
  }

  /**
   * Calls a method of the control port as this user. Calls of one user do not wait for each other.
   *
   * @param isCommand  is given an id, so that the daemon carries it out once however often it is sent
   * @throws ControlError
   */
  async call(name, method, params, isCommand) {
    const user = this.#users.get(name);
    if (!user) throw new ControlError("E_FORBIDDEN", "only a user with a name and a token may call methods");
    const all = isCommand ? { ...params, command_id: randomUUID() } : params;
    const idle = user.idle.pop();
    if (!idle) return this.#callIn(user, await ControlSession.open(this.#daemon, user.token), method, all);
    try {
      return await this.#callIn(user, idle, method, all);
    } catch (error) {
      // It may have been closed for long without our knowing.
      if (error.code !== "E_LOST") throw error;
      return this.#callIn(user, await ControlSession.open(this.#daemon, user.token), method, all);
    }
  }

  async #callIn(user, session, method, params) {
    try {
      return await session.call(method, params);
    } finally {
      this.#keep(user, session);
    }
  }

  // One is enough for a user who does one thing after the other; the daemon's sessions are few.
  #keep(user, session) {
    if (user.idle.length > 0 || user.holders.size === 0) return session.close();
    user.idle.push(session);
    session.removeAllListeners("closed");
    session.once("closed", () => (user.idle = user.idle.filter((other) => other !== session)));
  }
}
