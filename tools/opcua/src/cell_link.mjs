/** Follows a cell: asks the daemon for its state, hears its events, and comes back whenever the connection is lost. */
import { EventEmitter } from "node:events";
import { setTimeout as delay } from "node:timers/promises";
import { ControlSession, SHORT_PATIENCE_MS } from "./control_session.mjs";

const AGAIN_MS = 1_000; // from one attempt to reach the daemon to the next
const LOOK_MS = 1_000; // from one look at what no event tells (the axes) to the next
const LEAST_MS = 100; // between two looks, however many events come
/** After which the state is asked for at once. */
const CHANGING = new Set(["cell", "campaign", "model", "fault", "stream"]);

/**
 * Emits "status" (cell.status) whenever it was asked for, "event" ({seq, time, topic, data}) for each event of the
 * daemon, once and in order, those that came while the connection was lost included, "missed" (how many events are gone
 * for good; 0: unknown), and "lost" (why) at every attempt that fails.
 */
export class CellLink extends EventEmitter {
  #daemon;
  #token;
  #session;
  #lastSeq; // of the last event; undefined until the first session
  #ended = false;
  #changed = false; // since the state was asked for
  #waiting = []; // for a state that is asked for from now on
  #wake = () => {};

  constructor(daemon, token) {
    super();
    this.#daemon = daemon;
    this.#token = token;
  }

  /** Ends when stop() is called. */
  async run() {
    while (!this.#ended) {
      try {
        await this.#live();
      } catch (error) {
        if (!this.#ended) this.emit("lost", error.message);
      }
      this.#session?.close();
      this.#release(this.#waiting.splice(0));
      if (!this.#ended) await delay(AGAIN_MS);
    }
  }

  stop() {
    this.#ended = true;
    this.#session?.close();
    this.look();
  }

  /** Ends when a state has been emitted that the daemon had from now on, or it cannot be asked. */
  refresh() {
    const shown = new Promise((resolve) => this.#waiting.push(resolve));
    this.look();
    return shown;
  }

  /** Looks at the state now. */
  look() {
    this.#changed = true;
    this.#wake();
  }

  async #live() {
    const session = (this.#session = await ControlSession.open(this.#daemon, this.#token));
    session.on("event", (event) => this.#hear(event));
    session.on("closed", () => this.look());
    await this.#subscribe();
    while (!this.#ended) {
      const waiting = this.#waiting.splice(0);
      try {
        this.emit("status", await this.#ask("cell.status"));
      } finally {
        this.#release(waiting);
      }
      await delay(LEAST_MS);
      await this.#untilChanged(LOOK_MS - LEAST_MS);
    }
  }

  #ask(method, params) {
    return this.#session.call(method, params, SHORT_PATIENCE_MS);
  }

  #release(waiting) {
    for (const resolve of waiting) resolve();
  }

  async #subscribe() {
    const next = this.#session.hello.next_seq;
    const after = this.#lastSeq ?? next - 1;
    // A daemon with another store restarts its count.
    const another = after >= next;
    this.#lastSeq = another ? next - 1 : after;
    const { complete, oldest } = await this.#ask("events.subscribe", { after: this.#lastSeq });
    if (another) this.emit("missed", 0);
    else if (!complete) this.emit("missed", oldest - after - 1);
  }

  #hear(event) {
    if (event.seq <= this.#lastSeq) return;
    this.#lastSeq = event.seq;
    this.emit("event", event);
    if (CHANGING.has(event.topic)) this.look();
  }

  /** Waits until somebody has looked since, or for so long. */
  async #untilChanged(ms) {
    if (!this.#changed)
      await new Promise((resolve) => {
        const timer = setTimeout(resolve, ms);
        this.#wake = () => {
          clearTimeout(timer);
          resolve();
        };
      });
    this.#changed = false;
  }
}
