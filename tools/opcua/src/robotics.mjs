/** The cell by OPC 40010-1, OPC UA for Robotics: what the daemon knows of the arm, its controller and its safety. */
import { DataType, standardUnits } from "node-opcua";
const ROBOTICS = "http://opcfoundation.org/UA/Robotics/";
const DI = "http://opcfoundation.org/UA/DI/";

const scalar = (dataType) => ({ dataType, isArray: false });
const TEXT = scalar(DataType.String);
const LOCALIZED = scalar(DataType.LocalizedText);
const FLAG = scalar(DataType.Boolean);
const NUMBER = scalar(DataType.Double);
const ENUMERATION = scalar(DataType.Int32);

const ARTICULATED_ROBOT = 1; // MotionDeviceCategoryEnumeration
const ROTARY = 1; // AxisMotionProfileEnumeration
const MODES = { T1: 1, T2: 2, AUT: 3, EXT: 4 }; // OperationalModeEnumeration
/** The robot interpreter's states as those of the TaskControlStateMachine. */
const TASK_STATES = { free: "Idle", reset: "Ready", stopped: "Ready", ended: "Ready", active: "Executing" };

const reported = (status) => status.stream?.robot; // as the controller reports it
const manufacturer = () => "KUKA";
const model = ({ robot }) => robot?.model;
/** The specification asks for it, and the controller does not tell it. */
const notTold = () => "";

/** Of each object below the system: its place, type and optional members, and of its variables path, type and value. */
const OBJECTS = [
  {
    id: "MotionDevice",
    parent: "MotionDevices",
    type: "MotionDeviceType",
    shows: [
      [["Manufacturer"], LOCALIZED, manufacturer],
      [["Model"], LOCALIZED, model],
      [["ProductCode"], TEXT, model],
      [["SerialNumber"], TEXT, ({ robot }) => robot?.serial],
      [["MotionDeviceCategory"], ENUMERATION, () => ARTICULATED_ROBOT],
      [["ParameterSet", "SpeedOverride"], NUMBER, (status) => reported(status)?.override_percent],
    ],
  },
  {
    id: "Controller",
    parent: "Controllers",
    type: "ControllerType",
    shows: [
      [["Manufacturer"], LOCALIZED, manufacturer],
      [["Model"], LOCALIZED, notTold],
      [["ProductCode"], TEXT, notTold],
      [["SerialNumber"], TEXT, notTold],
      [["CurrentUser", "Level"], TEXT, notTold],
    ],
  },
  {
    id: "SystemSoftware",
    parent: "Software",
    type: "SoftwareType",
    shows: [
      [["Manufacturer"], LOCALIZED, manufacturer],
      [["Model"], LOCALIZED, () => "KUKA System Software"],
      [["SoftwareRevision"], TEXT, ({ robot }) => robot?.software],
    ],
  },
  {
    id: "RobotInterpreter",
    parent: "TaskControls",
    type: "TaskControlType",
    optionals: ["TaskControlOperation"],
    shows: [
      [["ComponentName"], LOCALIZED, () => "Robot interpreter"],
      [["ParameterSet", "TaskProgramName"], TEXT, notTold],
      [["ParameterSet", "TaskProgramLoaded"], FLAG, (status) => loaded(reported(status)?.program)],
    ],
  },
  {
    id: "SafetyState",
    parent: "SafetyStates",
    type: "SafetyStateType",
    shows: [
      [["ParameterSet", "OperationalMode"], ENUMERATION, (status) => MODES[reported(status)?.mode]],
      [["ParameterSet", "EmergencyStop"], FLAG, (status) => reported(status)?.emergency_stop],
      [["ParameterSet", "ProtectiveStop"], FLAG, (status) => reported(status)?.gate_open],
    ],
  },
];

const loaded = (program) => (program ? program !== "free" : undefined);

export class Robotics {
  #namespace;
  #mirror;
  #indices; // of the specifications' namespaces
  #axes = 0;
  #nodes = {}; // of each id

  /** Makes all but the axes, which show() makes once it is known how many there are. */
  constructor(namespace, mirror) {
    [this.#namespace, this.#mirror] = [namespace, mirror];
    const { addressSpace } = namespace;
    this.#indices = [ROBOTICS, DI].map((uri) => addressSpace.getNamespaceIndex(uri));
    const devices = addressSpace.rootFolder.objects.getFolderElementByName("DeviceSet", this.#indices[1]);
    this.#nodes.System = this.#make("MotionDeviceSystemType", "MotionDeviceSystem", devices);
    for (const object of OBJECTS) this.#add(object);
    this.#refer("Controller", "Controls", "MotionDevice");
    this.#refer("Controller", "HasSafetyStates", "SafetyState");
    this.#refer("RobotInterpreter", "Controls", "MotionDevice");
    this.#addTaskState();
  }

  show(status) {
    const count = status.robot?.q_deg?.length ?? 0;
    while (this.#axes < count) this.#addAxis(this.#axes++);
  }

  #make(type, browseName, componentOf, optionals = []) {
    const { addressSpace } = this.#namespace;
    const [found] = this.#indices.map((index) => addressSpace.findObjectType(type, index)).filter(Boolean);
    return found.instantiate({ browseName, namespace: this.#namespace, nodeId: `s=${browseName}`, componentOf, optionals });
  }

  #add({ id, parent, type, optionals, shows }) {
    const folder = child(this.#nodes.System, parent) ?? child(this.#nodes.Controller, parent);
    this.#nodes[id] = this.#make(type, id, folder, optionals);
    for (const [path, valueType, read] of shows) this.#mirror.add(below(this.#nodes[id], path), valueType, read);
  }

  #addAxis(index) {
    const axis = this.#make("AxisType", `A${index + 1}`, child(this.#nodes.MotionDevice, "Axes"));
    this.#mirror.add(below(axis, ["MotionProfile"]), ENUMERATION, () => ROTARY);
    const position = below(axis, ["ParameterSet", "ActualPosition"]);
    const unit = { dataType: DataType.ExtensionObject, value: standardUnits.degree };
    child(position, "EngineeringUnits").setValueFromSource(unit);
    this.#mirror.add(position, NUMBER, ({ robot }) => robot?.q_deg?.[index]);
  }

  /** What the interpreter does; nobody starts or stops it from here, so its optional methods are left out. */
  #addTaskState() {
    const path = ["TaskControlOperation", "TaskControlStateMachine", "CurrentState"];
    const state = below(this.#nodes.RobotInterpreter, path);
    const type = this.#namespace.addressSpace.findObjectType("TaskControlStateMachineType", this.#indices[0]);
    const name = (status) => TASK_STATES[reported(status)?.program];
    this.#mirror.add(state, LOCALIZED, name);
    const id = (status) => name(status) && child(type, name(status)).nodeId;
    this.#mirror.add(child(state, "Id"), scalar(DataType.NodeId), id);
  }

  #refer(from, type, to) {
    const referenceType = this.#namespace.addressSpace.findReferenceType(type, this.#indices[0]);
    this.#nodes[from].addReference({ referenceType, nodeId: this.#nodes[to] });
  }
}

/** A component or property by its name, whichever namespace that is from. */
function child(node, name) {
  return node?.findReferencesExAsObject("Aggregates").find(({ browseName }) => browseName.name === name);
}

function below(node, path) {
  const found = path.reduce(child, node);
  if (!found) throw new Error(`the companion specification's types have no ${path.join("/")} in ${node.browseName}`);
  return found;
}
