/** What an error of the control port is to an OPC UA client. */
import { StatusCodes } from "node-opcua";

const CODES = {
  E_UNAUTHENTICATED: StatusCodes.BadUserAccessDenied,
  E_FORBIDDEN: StatusCodes.BadUserAccessDenied,
  E_CONTROL: StatusCodes.BadLocked,
  E_STATE: StatusCodes.BadInvalidState,
  E_NOT_FOUND: StatusCodes.BadNotFound,
  E_DEVICE: StatusCodes.BadDeviceFailure,
  E_BUSY: StatusCodes.BadResourceUnavailable,
  E_RATE: StatusCodes.BadServerTooBusy,
  E_PARAMS: StatusCodes.BadInvalidArgument,
  E_METHOD: StatusCodes.BadNotSupported,
  E_UNREACHABLE: StatusCodes.BadNoCommunication,
  E_LOST: StatusCodes.BadNoCommunication,
  E_TIMEOUT: StatusCodes.BadTimeout,
};

/** @param code  symbol of an error (E_STATE); one of a later daemon is Bad too */
export const statusCodeOf = (code) => CODES[code] ?? StatusCodes.BadUnexpectedError;
