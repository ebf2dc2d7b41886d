/** Variables that show what the daemon says. */
import { DataType, StatusCodes, Variant, VariantArrayType } from "node-opcua";

/** A value of JSON as OPC UA has it. */
export function variantOf({ dataType, isArray }, value) {
  const convert = (one) => (dataType === DataType.DateTime ? new Date(one) : one);
  if (isArray) return new Variant({ dataType, arrayType: VariantArrayType.Array, value: value.map(convert) });
  return new Variant({ dataType, value: convert(value) });
}

const CHECKS = {
  [DataType.String]: (value) => typeof value === "string",
  [DataType.LocalizedText]: (value) => typeof value === "string",
  [DataType.DateTime]: (value) => !Number.isNaN(Date.parse(value)),
  [DataType.Boolean]: (value) => typeof value === "boolean",
  [DataType.Double]: (value) => typeof value === "number",
  [DataType.Int32]: Number.isInteger,
  [DataType.Int64]: Number.isSafeInteger,
  [DataType.NodeId]: () => true,
};

/** A later daemon may say something else where this one has a number. */
function fits({ dataType, isArray }, value) {
  return isArray ? Array.isArray(value) && value.every(CHECKS[dataType]) : CHECKS[dataType](value);
}

// Texts are empty while they are not known, as at the control port; no number or time stands for "not known".
function dataValueOf(type, value, time) {
  const known = value !== undefined && value !== null && !(type.isArray && value.includes?.(null));
  if (known && !fits(type, value)) return { statusCode: StatusCodes.BadTypeMismatch, sourceTimestamp: time };
  if (known) return { value: variantOf(type, value), statusCode: StatusCodes.Good, sourceTimestamp: time };
  const isText = type.dataType === DataType.String && !type.isArray;
  if (isText) return { value: variantOf(type, ""), statusCode: StatusCodes.Good, sourceTimestamp: time };
  return { statusCode: StatusCodes.BadWaitingForInitialData, sourceTimestamp: time };
}

export class Mirror {
  #shown = []; // {variable, type, read, lost, last}

  /**
   * @param variable  of the address space
   * @param type      {dataType, isArray}
   * @param read      of cell.status: the value; null or undefined where it is not known
   * @param lost      shown, with a bad status, while nothing is known of the daemon
   */
  add(variable, type, read, lost) {
    this.#shown.push({ variable, type, read, lost });
    this.#set(this.#shown.at(-1), { statusCode: StatusCodes.BadWaitingForInitialData });
  }

  /** @param status  result of cell.status */
  show(status) {
    const time = new Date(status.time);
    for (const one of this.#shown) {
      const value = one.read(status);
      const text = JSON.stringify(value) ?? "";
      if (text === one.last) continue;
      one.last = text;
      this.#set(one, dataValueOf(one.type, value, time));
    }
  }

  /** The daemon cannot be asked any more. */
  lose() {
    for (const one of this.#shown) {
      one.last = undefined;
      const value = one.lost === undefined ? undefined : variantOf(one.type, one.lost);
      this.#set(one, { value, statusCode: StatusCodes.BadNoCommunication });
    }
  }

  #set({ variable }, { value, statusCode, sourceTimestamp = new Date() }) {
    variable.setValueFromSource(value ?? { dataType: DataType.Null }, statusCode, sourceTimestamp);
  }
}
