/** The object that shows a cell: each member of cell.status is a variable. */
import { DataType } from "node-opcua";
import { nodeName, splitUnit } from "./schema.mjs";

const TEXT = { dataType: DataType.String, isArray: false };

export class CellObject {
  #namespace;
  #mirror;
  #schema;

  /**
   * @param namespace  in which the nodes are made
   * @param mirror     keeps the variables up to date
   * @param schema     of the control port
   */
  constructor(namespace, mirror, schema) {
    [this.#namespace, this.#mirror, this.#schema] = [namespace, mirror, schema];
    const { objects } = namespace.addressSpace.rootFolder;
    this.node = namespace.addObject({
      browseName: "truepose",
      nodeId: "s=truepose",
      organizedBy: objects,
      eventSourceOf: objects.server,
      eventNotifier: 1,
    });
    this.#addVariables(this.node, schema.resultOf("cell.status"), "", (status) => status);
    const whole = this.#addVariable(this.node, "Status", "status", TEXT, "All of it: the result of cell.status, JSON");
    mirror.add(whole, TEXT, (status) => JSON.stringify(status));
  }

  #addVariables(parent, schema, path, read, unitOfAll) {
    for (const [member, described] of Object.entries(schema.properties ?? {})) {
      const resolved = this.#schema.resolve(described);
      const { stem, unit = unitOfAll } = splitUnit(member);
      const readMember = (status) => read(status)?.[member];
      const type = this.#schema.typeOf(resolved);
      const id = path ? `${path}.${member}` : member;
      if (type) {
        const variable = this.#addVariable(parent, nodeName(stem), id, type, resolved.description, unit);
        this.#mirror.add(variable, type, readMember, id === "state" ? "unknown" : undefined);
      } else if (resolved.properties) {
        const object = this.#namespace.addObject({
          componentOf: parent,
          browseName: nodeName(stem),
          nodeId: `s=${id}`,
          description: resolved.description,
        });
        this.#addVariables(object, resolved, id, readMember, unit);
      }
    }
  }

  #addVariable(parent, name, id, { dataType, isArray }, description, unit) {
    const variable = this.#namespace.addVariable({
      componentOf: parent,
      browseName: name,
      nodeId: `s=${id}`,
      description,
      dataType,
      valueRank: isArray ? 1 : -1,
      typeDefinition: unit ? "AnalogUnitType" : "BaseDataVariableType",
      minimumSamplingInterval: 100,
      accessLevel: "CurrentRead",
      userAccessLevel: "CurrentRead",
    });
    if (unit)
      this.#namespace.addVariable({
        propertyOf: variable,
        browseName: { name: "EngineeringUnits", namespaceIndex: 0 },
        typeDefinition: "PropertyType",
        dataType: "EUInformation",
        value: { dataType: DataType.ExtensionObject, value: unit },
      });
    return variable;
  }
}
