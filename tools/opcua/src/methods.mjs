/** Which methods the cell's object has: every command of the control port, with arguments of OPC UA's types. */
import { DataType } from "node-opcua";
import { nodeName } from "./schema.mjs";

/** What is called otherwise here than there; a command of a later daemon has its own name (ModelRollback). */
const NAMES = {
  "cell.connect": "Connect",
  "cell.disconnect": "Disconnect",
  "cell.acknowledge": "Acknowledge",
  "campaign.start": "StartCampaign",
  "campaign.pause": "PauseCampaign",
  "campaign.resume": "ResumeCampaign",
  "campaign.abort": "Abort",
  "drift.check": "CheckDrift",
  "model.activate": "ActivateModel",
  "model.deactivate": "DeactivateModel",
  "stream.arm": "Arm",
  "stream.disarm": "Disarm",
  "stream.start": "StartStream",
  "stream.stop": "StopStream",
};
/** Of results that are described elsewhere too, the members that come as arguments of their own. */
const TOLD = new Set(["id", "state", "phase", "total", "holder"]);
/** Parameters that are given to each command by us, or of no use where a method of OPC UA answers when it is done. */
const OURS = new Set(["command_id", "job"]);

/**
 * What may be left out stands in one JSON object: OPC UA's arguments are all to be given, and a later daemon's further
 * parameter changes no method's arguments.
 */
function optionsArgument(params) {
  const list = params.map(({ name, schema }) => `${name} (${schema.type ?? "object"}): ${schema.description ?? ""}`);
  return {
    name: "Options",
    dataType: DataType.String,
    description: `Empty, or a JSON object with any of: ${list.join("; ")}`,
  };
}

function describe(schema, method) {
  const params = method.params
    .filter(({ name }) => !OURS.has(name))
    .map((param) => ({ ...param, schema: schema.resolve(param.schema) }));
  const typed = params.filter((param) => param.required && schema.typeOf(param.schema));
  const options = params.filter((param) => !typed.includes(param));
  const result = schema.resultOf(method.name).properties ?? {};
  return {
    rpc: method.name,
    name: NAMES[method.name] ?? nodeName(method.name),
    summary: method.summary ?? "",
    typed: typed.map(({ name, schema: one }) => ({
      param: name,
      name: nodeName(name),
      ...schema.typeOf(one),
      description: one.description ?? "",
    })),
    options: options.length > 0 ? optionsArgument(options) : undefined,
    results: Object.keys(result)
      .filter((member) => TOLD.has(member) && schema.typeOf(result[member]))
      .map((member) => ({
        member,
        name: nodeName(member),
        ...schema.typeOf(result[member]),
        description: schema.resolve(result[member]).description ?? "",
      })),
  };
}

/**
 * @param schema  of the control port
 * @returns of each command {rpc, name, summary, inputs, results, params}: results are the members of its result that come as
 *   arguments of their own; params() makes the daemon's parameters of input values (SyntaxError: Options is no JSON object)
 */
export function commandsOf(schema) {
  return schema.methods
    .filter((method) => method["x-role"] !== "viewer")
    .map((method) => {
      const { typed, options, ...command } = describe(schema, method);
      const inputs = options ? [...typed, options] : typed;
      return { ...command, inputs, params: (values) => paramsOf(typed, values) };
    });
}

function paramsOf(typed, values) {
  const given = typed.map(({ param }, at) => [param, values[at]]);
  return { ...parseOptions(values[typed.length]), ...Object.fromEntries(given) };
}

/** @throws SyntaxError */
export function parseOptions(text) {
  if (!text?.trim()) return {};
  const options = JSON.parse(text);
  if (options === null || typeof options !== "object" || Array.isArray(options))
    throw new SyntaxError("expected a JSON object");
  return options;
}
