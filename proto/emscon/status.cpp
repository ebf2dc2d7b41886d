#include "proto/emscon/status.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace truepose::emscon {
namespace {

using namespace status;

enum class Kind { Fault, Busy, NotReady, BadParameter };

/// What codes from `first` to `last` mean, and what to do about them; nothing where the campaign tries again
/// by itself.
struct Meaning {
  std::int32_t first, last;
  Kind kind;
  std::string_view sentence;
  std::string_view remedy;
};

constexpr std::string_view kSetUp = "look at the tracker with its maker's software";
constexpr std::string_view kService = "have the tracker serviced";

constexpr std::array kMeanings{
    Meaning{kAllOk, kAllOk, Kind::Fault, "no error", ""},
    Meaning{kServerBusy, kServerBusy, Kind::Busy, "the tracker is busy with another command", ""},
    Meaning{kNotImplemented, kNotImplemented, Kind::Fault, "the tracker does not offer this command",
            "see whether its firmware is one that speaks emScon 3.5 or later"},
    Meaning{kWrongParameter1, 22, Kind::BadParameter, "a parameter is wrong or out of range",
            "see whether the point is in the tracker's reach"},
    Meaning{kWrongReflector, kWrongReflector, Kind::Fault,
            "another reflector is selected than the one in the beam", "see tracker.reflector"},
    Meaning{kNoTrackerProcessor, kNoTrackerProcessor, Kind::Fault,
            "the controller finds no tracker processor", "check the cable to the sensor, and restart both"},
    Meaning{kNoWeatherMonitor, kNoWeatherMonitor, Kind::Fault, "no weather station is connected",
            "connect it, or enter the air: tracker.air"},
    Meaning{kNoLastMeasuredPoint, kNoLastMeasuredPoint, Kind::Fault, "there is no last measured point", ""},
    Meaning{kNoAdm, kNoAdm, Kind::Fault, "the tracker has no absolute distance meter",
            "lead the reflector from the home nest"},
    Meaning{kUsageConflict, kUsageConflict, Kind::Fault,
            "the command conflicts with what the tracker is doing",
            "close other programs that use the tracker"},
    Meaning{kUnknown, kUnknown, Kind::Fault, "the tracker does not know this command",
            "see whether its firmware is one that speaks emScon 3.5 or later"},
    Meaning{kNoDistanceSet, kNoDistanceSet, Kind::Fault, "no distance is set: lock a reflector first", ""},
    Meaning{kNoTrackerConnected, kNoTrackerConnected, Kind::NotReady,
            "no tracker is connected to the controller", "check the cable to the sensor, and restart both"},
    Meaning{kNotInitialized, kNotInitialized, Kind::NotReady, "the tracker is not initialised", ""},
    Meaning{40, 43, Kind::NotReady, "a module of the tracker failed", kService},
    Meaning{47, 55, Kind::BadParameter, "a parameter is wrong or out of range", kSetUp},
    Meaning{kWeatherOutOfRange, kWeatherOutOfRange, Kind::Fault,
            "temperature, pressure or humidity is out of range",
            "check the weather station, or tracker.air and its units"},
    Meaning{kCompensationMode, kCompensationMode, Kind::NotReady, "the tracker is in compensation mode",
            "end that with the maker's software"},
    Meaning{kInternalProcessActive, kInternalProcessActive, Kind::Busy,
            "an internal process of the tracker is active", ""},
    Meaning{92, 92, Kind::Fault, "the tracker measures in 6D", "select a reflector instead of a probe"},
    Meaning{94, 96, Kind::Fault, "temperature, pressure or humidity is not available",
            "connect the weather station, or enter the air: tracker.air"},
    Meaning{97, 97, Kind::Fault, "the tracker measures in 6D", "select a reflector instead of a probe"},
    Meaning{kInvalidInput, kInvalidInput, Kind::BadParameter, "the input is not valid", kSetUp},
    Meaning{kNoValidAdmCompensation, kNoValidAdmCompensation, Kind::Fault,
            "the distance meter has no valid compensation", "compensate it with the maker's software"},
    Meaning{kPressureSensor, kPressureSensor, Kind::Fault, "the pressure sensor failed",
            "enter the air instead: tracker.air"},
    Meaning{kMeasurementStatusNotReady, kMeasurementStatusNotReady, Kind::NotReady,
            "the tracker is not ready to measure", ""},
    Meaning{kStartUpBusy, kStartUpBusy, Kind::Busy, "the distance meter is still starting up", ""},
    Meaning{kNoStationaryResult, kNoStationaryResult, Kind::Fault, "the measurement gave no result",
            "see whether the arm vibrates"},
    Meaning{kNotLevelled, kNotLevelled, Kind::NotReady, "the tracker is not levelled", "level it"},
    Meaning{kSecondConnectionRefused, kSecondConnectionRefused, Kind::Fault,
            "another program is connected to the tracker", "close it"},
    Meaning{kNotWarmedUp, kNotWarmedUp, Kind::NotReady, "the tracker is not warmed up",
            "leave it switched on; it is connected once it is"},
    Meaning{kNotStable, kNotStable, Kind::NotReady, "the tracker does not stand still",
            "set it up firmly, and see what shakes it"},
    Meaning{kSystemNotReady, kSystemNotReady, Kind::NotReady, "the tracker is not ready to measure", ""},
    Meaning{kSensorCommunication, kSensorCommunication, Kind::NotReady,
            "the controller cannot reach the sensor", "check the cable to the sensor, and restart both"},
    Meaning{kBattery, kBattery, Kind::NotReady, "the battery is low", "charge or change it"},
    Meaning{kNotLevelledForInitialization, kNotLevelledForInitialization, Kind::NotReady,
            "the tracker is not levelled", "level it"},
    Meaning{kAdmHardware, kAdmHardware, Kind::NotReady, "the distance meter failed", kService},
    Meaning{kAtrHardware, kAtrHardware, Kind::NotReady, "the target recognition failed", kService},
};

/// Of a number that real trackers send without a public name.
constexpr Meaning kNameless{0, 0, Kind::Fault, "the tracker reports a fault that has no public name", ""};

const Meaning& meaning(std::int32_t code) {
  const auto found = std::ranges::find_if(
      kMeanings, [code](const Meaning& each) { return code >= each.first && code <= each.last; });
  return found == kMeanings.end() ? kNameless : *found;
}

}  // namespace

namespace status {

bool is_busy(std::int32_t status) { return meaning(status).kind == Kind::Busy; }

bool is_not_ready(std::int32_t status) { return meaning(status).kind == Kind::NotReady; }

bool is_bad_parameter(std::int32_t status) { return meaning(status).kind == Kind::BadParameter; }

}  // namespace status

std::string describe_status(std::int32_t status) {
  const Meaning& is = meaning(status);
  std::string text = std::string{is.sentence} + " (status " + std::to_string(status) + ")";
  if (!is.remedy.empty()) text.append(": ").append(is.remedy);
  return text;
}

}  // namespace truepose::emscon
