/** Reads proto/control/openrpc.json: methods, members, types and units, which are not listed here again. */
import { readFileSync } from "node:fs";
import { DataType, standardUnits } from "node-opcua";

const TYPES = {
  string: DataType.String,
  integer: DataType.Int64,
  number: DataType.Double,
  boolean: DataType.Boolean,
};
/** A member's name ends with its unit. */
const UNITS = {
  mm: standardUnits.millimetre,
  deg: standardUnits.degree,
  s: standardUnits.second,
  ms: standardUnits.millisecond,
  us: standardUnits.microsecond,
  percent: standardUnits.percent,
  kB: standardUnits.kilobyte,
};

/** "model.rollback" and "max_step" as names of nodes: ModelRollback, MaxStep. */
export const nodeName = (name) => name.replace(/(?:^|[._])(\w)/g, (_, letter) => letter.toUpperCase());

/** @returns {stem, unit} of a member's name: "error_mm" is {stem: "error", unit: millimetre} */
export function splitUnit(name) {
  const at = name.lastIndexOf("_");
  const unit = at > 0 ? UNITS[name.slice(at + 1)] : undefined;
  return unit ? { stem: name.slice(0, at), unit } : { stem: name, unit: undefined };
}

export class Schema {
  #document;

  static read(file) {
    return new Schema(JSON.parse(readFileSync(file, "utf8")));
  }

  constructor(document) {
    this.#document = document;
  }

  get methods() {
    return this.#document.methods;
  }

  /** @returns the schema itself, where this one refers to it, and of one that may be null the other */
  resolve(schema) {
    if (schema.$ref) {
      const { $ref, ...own } = schema;
      const target = $ref.split("/").slice(1).reduce((node, key) => node[key], this.#document);
      return { ...this.resolve(target), ...own };
    }
    const other = schema.oneOf?.find((one) => one.type !== "null");
    return other ? { ...this.resolve(other), ...(schema.description && { description: schema.description }) } : schema;
  }

  /**
   * @param schema  of a value
   * @returns {dataType, isArray} in OPC UA; undefined for what has no type of its own there, as an object
   */
  typeOf(schema) {
    const resolved = this.resolve(schema);
    const name = [resolved.type].flat().find((type) => type !== "null");
    if (name === "array") {
      const element = this.typeOf(resolved.items ?? {});
      return element && !element.isArray ? { ...element, isArray: true } : undefined;
    }
    if (name === "string" && resolved.format === "date-time") return { dataType: DataType.DateTime, isArray: false };
    return TYPES[name] && { dataType: TYPES[name], isArray: false };
  }

  /** @returns the schema of a method's result */
  resultOf(method) {
    return this.resolve(this.methods.find((one) => one.name === method).result.schema);
  }
}
