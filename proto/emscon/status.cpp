#include "proto/emscon/status.hpp"

#include <string_view>

namespace truepose::emscon {
namespace {

std::string_view sentence(std::int32_t code) {
  using namespace status;
  switch (code) {
    case kAllOk:
      return "no error";
    case kServerBusy:
      return "the tracker is busy with another command";
    case kNotImplemented:
      return "the tracker does not offer this command";
    case kWrongReflector:
      return "another reflector is selected than the one in the beam";
    case kNoTrackerProcessor:
      return "the controller finds no tracker processor";
    case kNoWeatherMonitor:
      return "no weather station is connected";
    case kNoLastMeasuredPoint:
      return "there is no last measured point";
    case kNoAdm:
      return "the tracker has no absolute distance meter";
    case kUsageConflict:
      return "the command conflicts with what the tracker is doing";
    case kUnknown:
      return "the tracker does not know this command";
    case kNoDistanceSet:
      return "no distance is set: lock a reflector first";
    case kNoTrackerConnected:
      return "no tracker is connected to the controller";
    case kNotInitialized:
      return "the tracker is not initialised";
    case kWeatherOutOfRange:
      return "temperature, pressure or humidity is out of range";
    case kCompensationMode:
      return "the tracker is in compensation mode";
    case kInternalProcessActive:
      return "an internal process of the tracker is active";
    case 94:
    case 95:
    case 96:
      return "temperature, pressure or humidity is not available";
    case kInvalidInput:
      return "the input is not valid";
    case kNoValidAdmCompensation:
      return "the distance meter has no valid compensation";
    case kPressureSensor:
      return "the pressure sensor failed";
    case kMeasurementStatusNotReady:
    case kSystemNotReady:
      return "the tracker is not ready to measure";
    case kStartUpBusy:
      return "the distance meter is still starting up";
    case kNoStationaryResult:
      return "the measurement gave no result";
    case kNotLevelled:
    case kNotLevelledForInitialization:
      return "the tracker is not levelled";
    case kSecondConnectionRefused:
      return "another program is connected to the tracker";
    case kNotWarmedUp:
      return "the tracker is not warmed up";
    case kNotStable:
      return "the tracker does not stand still";
    case kSensorCommunication:
      return "the controller cannot reach the sensor";
    case kBattery:
      return "the battery is low";
    case kAdmHardware:
      return "the distance meter failed";
    case kAtrHardware:
      return "the target recognition failed";
    default:
      break;
  }
  if (is_bad_parameter(code)) return "a parameter is wrong or out of range";
  if (code >= 40 && code <= 43) return "a module of the tracker failed";
  return "the tracker reports a fault that has no public name";
}

}  // namespace

namespace status {

bool is_busy(std::int32_t status) {
  return status == kServerBusy || status == kInternalProcessActive || status == kStartUpBusy;
}

bool is_not_ready(std::int32_t status) {
  switch (status) {
    case kNoTrackerConnected:
    case kNotInitialized:
    case kCompensationMode:
    case kMeasurementStatusNotReady:
    case kNotLevelled:
    case kNotWarmedUp:
    case kNotStable:
    case kSystemNotReady:
    case kSensorCommunication:
    case kBattery:
    case kNotLevelledForInitialization:
    case kAdmHardware:
    case kAtrHardware:
      return true;
    default:
      return status >= 40 && status <= 43;
  }
}

bool is_bad_parameter(std::int32_t status) {
  return (status >= kWrongParameter1 && status <= 22) || (status >= 47 && status <= 55) ||
         status == kInvalidInput;
}

}  // namespace status

std::string describe_status(std::int32_t status) {
  return std::string{sentence(status)} + " (status " + std::to_string(status) + ")";
}

}  // namespace truepose::emscon
