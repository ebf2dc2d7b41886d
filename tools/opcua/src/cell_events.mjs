/** What the daemon tells, as OPC UA events of the cell's object. Faults are alarms, figures variables: they are not here. */
import { DataType } from "node-opcua";

const SEVERITIES = { info: 100, warning: 400, error: 600 };
/** Topics that come as something else. */
const ELSEWHERE = new Set(["fault", "stream", "measurement"]);

const FIELDS = {
  Topic: { dataType: DataType.String, of: ({ topic }) => topic },
  Seq: { dataType: DataType.Int64, of: ({ seq }) => seq },
  Data: { dataType: DataType.String, of: ({ data }) => JSON.stringify(data) },
};

/** One sentence of an event whose topic may be a later daemon's. */
function sentence({ topic, data }) {
  if (topic === "cell") return `${data.from} -> ${data.state}: ${data.reason}`;
  if (topic === "campaign") return `campaign ${data.phase}, ${data.done} of ${data.total} poses`;
  if (topic === "model") return `model ${data.model?.id} ${data.change}`;
  if (topic === "control") return [data.by, data.change, data.method, data.result].filter(Boolean).join(" ");
  return data.text ?? data.reason ?? topic;
}

export class CellEvents {
  #cell;
  #type;

  /** @param cell  the node that they come from */
  constructor(namespace, cell) {
    this.#cell = cell;
    this.#type = namespace.addEventType({
      browseName: "TrueposeEventType",
      nodeId: "s=TrueposeEventType",
      subtypeOf: "BaseEventType",
    });
    for (const [browseName, { dataType }] of Object.entries(FIELDS))
      namespace.addVariable({
        propertyOf: this.#type,
        browseName,
        dataType,
        typeDefinition: "PropertyType",
        modellingRule: "Mandatory",
      });
  }

  /** @param event  {seq, time, topic, data} */
  raise(event) {
    if (ELSEWHERE.has(event.topic)) return;
    const fields = Object.entries(FIELDS).map(([name, { dataType, of }]) => [
      name[0].toLowerCase() + name.slice(1),
      { dataType, value: of(event) },
    ]);
    this.#cell.raiseEvent(this.#type, {
      ...Object.fromEntries(fields),
      message: { dataType: DataType.LocalizedText, value: { text: sentence(event) } },
      severity: { dataType: DataType.UInt16, value: SEVERITIES[event.data?.level] ?? SEVERITIES.info },
      time: { dataType: DataType.DateTime, value: new Date(event.time) },
    });
  }

  /** @param missed  how many events are gone; 0: that is not known */
  raiseMissed(missed) {
    const text = `${missed || "Some"} events of the daemon were missed for good`;
    this.raise({ seq: 0, time: Date.now(), topic: "gateway", data: { level: "warning", text } });
  }
}
