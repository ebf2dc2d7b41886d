/** The daemon's faults as OPC UA alarms. They are acknowledged there, by cell.acknowledge, and by whom it is done here. */
import { NodeId, StatusCodes } from "node-opcua";
import { ControlError } from "./control_session.mjs";
import { userOf } from "./cell_methods.mjs";
import { statusCodeOf } from "./status_codes.mjs";

const SEVERITIES = { warning: 500, error: 800 };
/** Ours: while it stands nothing is known of the others. */
export const LOST = "E_DAEMON_LOST";

export class Alarms {
  #namespace;
  #cell;
  #acknowledge;
  #alarms = new Map(); // of each code

  /**
   * @param cell         the object whose alarms they are
   * @param acknowledge  of a user's name: has the daemon clear what can be cleared; throws ControlError
   */
  constructor(namespace, cell, acknowledge) {
    [this.#namespace, this.#cell, this.#acknowledge] = [namespace, cell, acknowledge];
    const type = namespace.addressSpace.findEventType("AcknowledgeableConditionType");
    this.#bind(type.getMethodByName("Acknowledge"));
  }

  /** @param faults  those that stand, as cell.status has them */
  show(faults) {
    const standing = new Map(faults.map((fault) => [fault.code, fault]));
    standing.forEach((fault) => this.begin(fault));
    for (const code of this.#alarms.keys()) if (!standing.has(code)) this.end(code);
  }

  /** @param fault  {code, severity, text, since} */
  begin({ code, severity, text, since }) {
    const alarm = this.#alarms.get(code) ?? this.#make(code);
    if (alarm.text === text && alarm.since === since) return;
    Object.assign(alarm, { text, since });
    const { node } = alarm;
    node.setTime(new Date(since));
    node.ackedState.setValue(false);
    node.activateAlarm();
    node.raiseNewCondition({ severity: SEVERITIES[severity] ?? SEVERITIES.error, message: text, retain: true });
  }

  end(code) {
    const alarm = this.#alarms.get(code);
    if (alarm?.since === undefined) return;
    const { node, text } = alarm;
    alarm.since = undefined;
    // The daemon has no fault that is gone and waits to be seen.
    node.ackedState.setValue(true);
    node.deactivateAlarm(false);
    node.raiseNewCondition({ message: `gone: ${text}`, retain: false });
  }

  #make(code) {
    const node = this.#namespace.instantiateAlarmCondition("AlarmConditionType", {
      browseName: code,
      nodeId: `s=alarm.${code}`,
      componentOf: this.#cell,
      conditionOf: this.#cell,
      conditionSource: this.#cell,
      conditionName: code,
      inputNode: NodeId.nullNodeId, // no value of ours makes it active
    });
    this.#bind(node.acknowledge);
    const alarm = { node, text: undefined, since: undefined };
    this.#alarms.set(code, alarm);
    return alarm;
  }

  #bind(method) {
    method.bindMethod(async (variants, context) => ({
      statusCode: await this.#acknowledged(context.object, variants[0].value, variants[1].value, context),
    }));
  }

  async #acknowledged(node, eventId, comment, context) {
    const branch = node.findBranchForEventId?.(eventId);
    if (!branch) return StatusCodes.BadEventIdUnknown;
    if (branch.getAckedState()) return StatusCodes.BadConditionBranchAlreadyAcked;
    const user = userOf(context);
    try {
      if (node.browseName.name !== LOST) await this.#acknowledge(user);
    } catch (error) {
      return error instanceof ControlError ? statusCodeOf(error.code) : StatusCodes.BadInternalError;
    }
    // The daemon may have said meanwhile that it is gone.
    if (!branch.getAckedState()) node.acknowledgeAndAutoConfirmBranch(branch, comment);
    branch.setClientUserId(user ?? "");
    if (node.activeState.getValue()) branch.setRetain(true);
    return StatusCodes.Good;
  }
}
