/** live_cell.py for tests in JavaScript: the simulated cell and its daemon. */
import { spawn } from "node:child_process";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

/** Of the cell, where a test runs on another machine: how a command is run there, and its address. */
export const CELL_NETWORK = process.env.TRUEPOSE_CELL_NETWORK?.split(" ") ?? [];
export const CELL_HOST = process.env.TRUEPOSE_CELL_HOST ?? "127.0.0.1";

/** Starts a program on the machine of the cell. */
export function spawnAtCell(program, words, options) {
  const [first, ...rest] = [...CELL_NETWORK, program, ...words];
  return spawn(first, rest, options);
}

export class LiveCell {
  /** @param options  of live_cell.py, as --tls */
  static async start(bin, source, ...options) {
    const cell = new LiveCell();
    const script = fileURLToPath(new URL("live_cell.py", import.meta.url));
    cell.process = spawnAtCell("python3", [script, bin, source, ...options], { stdio: ["pipe", "pipe", "inherit"] });
    cell.lines = createInterface({ input: cell.process.stdout })[Symbol.asyncIterator]();
    cell.place = await cell.#answer();
    return cell;
  }

  async order(line) {
    this.process.stdin.write(JSON.stringify(line) + "\n");
    return this.#answer();
  }

  /** Runs the command line against the daemon. Returns {exit_code, out, err}. */
  truepose(...words) {
    return this.order({ do: "truepose", arguments: words });
  }

  /** Runs the command line on files. Returns what it printed. */
  async offline(...words) {
    const { exit_code, out, err } = await this.order({ do: "truepose", arguments: words, online: false });
    if (exit_code !== 0) throw new Error(err);
    return out.trim();
  }

  /** Gives a client access. Returns his token. */
  access(name, role, ...options) {
    return this.offline("access", "add", name, "--role", role, ...options, "--cell", this.place.cell_file);
  }

  /** Waits until all that it started has ended. */
  async end() {
    this.process.stdin.end();
    await new Promise((resolve) => this.process.once("exit", resolve));
  }

  async #answer() {
    const { value, done } = await this.lines.next();
    if (done) throw new Error("the simulated cell has ended");
    return JSON.parse(value);
  }
}
