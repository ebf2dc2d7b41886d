/** The methods of the cell's object: each is called at the control port by whoever calls it here. */
import { DataType, StatusCodes, Variant } from "node-opcua";
import { ControlError } from "./control_session.mjs";
import { commandsOf, parseOptions } from "./methods.mjs";
import { variantOf } from "./mirror.mjs";
import { statusCodeOf } from "./status_codes.mjs";

const TEXT = { dataType: DataType.String, isArray: false };
/** Methods that are about the connection, which a user here has none of. */
const NOT_FOR_USERS = /^(session|events|rpc)\./;
/** What every method tells, after what it tells of its own. Texts come with a bad status too: most clients show them. */
const OUTPUTS = [
  { name: "Code", ...TEXT, description: "ok, or the error's stable name (E_STATE)" },
  { name: "Message", ...TEXT, description: "Why it was refused, else empty" },
  { name: "Result", ...TEXT, description: "The whole answer, JSON; empty where it was refused" },
];

const argument = ({ name, dataType, isArray, description }) => ({
  name,
  dataType,
  valueRank: isArray ? 1 : -1,
  description: { text: description },
});

/** @returns the name of a user whom the daemon knows; undefined for an anonymous session */
export function userOf(context) {
  const token = context.session?.userIdentityToken;
  return token?.schema?.name === "UserNameIdentityToken" ? token.userName : undefined;
}

export class CellMethods {
  #namespace;
  #node;
  #users;
  #refresh;
  #last; // what the last command came to: of each variable its node

  /**
   * @param cell     the cell's node
   * @param users    UserSessions
   * @param schema   of the control port
   * @param refresh  waits until the variables show what has become of a command
   */
  constructor(namespace, cell, users, schema, refresh) {
    [this.#namespace, this.#node, this.#users, this.#refresh] = [namespace, cell, users, refresh];
    this.#last = this.#addLast();
    for (const command of commandsOf(schema))
      this.#add(command, (values) => ({ rpc: command.rpc, params: command.params(values), isCommand: true }));
    this.#addCall(schema);
  }

  /** For clients that do not read the output arguments of a call that was refused. */
  #addLast() {
    const componentOf = this.#namespace.addObject({
      componentOf: this.#node,
      browseName: "LastCommand",
      nodeId: "s=last",
      description: "What the last call of a method came to",
    });
    const add = (browseName) =>
      this.#namespace.addVariable({
        componentOf,
        browseName,
        nodeId: `s=last.${browseName.toLowerCase()}`,
        dataType: DataType.String,
        value: { dataType: DataType.String, value: "" },
      });
    return { Method: add("Method"), User: add("User"), Code: add("Code"), Message: add("Message") };
  }

  /** Any method by its name, those that only read included. */
  #addCall(schema) {
    const isCommand = (method) => schema.methods.some((one) => one.name === method && one["x-role"] !== "viewer");
    const inputs = [
      { name: "Method", ...TEXT, description: "Of the control port: report.get" },
      { name: "Params", ...TEXT, description: "Empty, or a JSON object" },
    ];
    this.#add({ name: "Call", summary: "Calls any method of the control port", inputs, results: [] }, ([method, text]) => {
      if (NOT_FOR_USERS.test(method)) throw new ControlError("E_METHOD", `${method} cannot be called from here`);
      return { rpc: method, params: parseOptions(text), isCommand: isCommand(method) };
    });
  }

  /** @param request  of input values: {rpc, params, isCommand}; throws where they cannot be right */
  #add({ name, summary, inputs, results }, request) {
    const outputs = [...results, ...OUTPUTS];
    const method = this.#namespace.addMethod(this.#node, {
      browseName: name,
      nodeId: `s=method.${name}`,
      description: summary,
      inputArguments: inputs.map(argument),
      outputArguments: outputs.map(argument),
    });
    method.bindMethod(async (variants, context) => {
      const user = userOf(context);
      const { code, message, result } = await this.#call(user, name, variants, request);
      const own = results.map(({ member }) => result?.[member] ?? null);
      const values = [...own, code, message, result ? JSON.stringify(result) : ""];
      const variant = (one, at) => (values[at] === null ? new Variant() : variantOf(one, values[at]));
      const outputArguments = outputs.map(variant);
      return { statusCode: code === "ok" ? StatusCodes.Good : statusCodeOf(code), outputArguments };
    });
  }

  async #call(user, name, variants, request) {
    let asked = name, outcome;
    try {
      const { rpc, params, isCommand } = request(variants.map((variant) => variant.value));
      asked = rpc;
      outcome = { code: "ok", message: "", result: await this.#users.call(user, rpc, params, isCommand) };
      if (isCommand) await this.#refresh();
    } catch (error) {
      outcome = { ...this.#reason(error), result: undefined };
    }
    this.#tell(asked, user ?? "", outcome);
    return outcome;
  }

  #reason(error) {
    if (error instanceof ControlError) return { code: error.code, message: error.message };
    if (error instanceof SyntaxError) return { code: "E_PARAMS", message: `JSON: ${error.message}` };
    return { code: "E_INTERNAL", message: error.message };
  }

  #tell(Method, User, { code: Code, message: Message }) {
    for (const [name, value] of Object.entries({ Method, User, Code, Message }))
      this.#last[name].setValueFromSource({ dataType: DataType.String, value });
  }
}
