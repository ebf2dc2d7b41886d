#pragma once

#include <cstdint>
#include <string>

/// Result codes of answers, errors and measurement results. Real trackers also send numbers that have no name
/// here, so a status travels as the raw int32.
namespace truepose::emscon::status {

inline constexpr std::int32_t kAllOk = 0;
inline constexpr std::int32_t kServerBusy = 1;
inline constexpr std::int32_t kNotImplemented = 2;
inline constexpr std::int32_t kWrongParameter1 = 3;
inline constexpr std::int32_t kWrongReflector = 23;
inline constexpr std::int32_t kNoTrackerProcessor = 26;
inline constexpr std::int32_t kNoWeatherMonitor = 27;
inline constexpr std::int32_t kNoLastMeasuredPoint = 28;
inline constexpr std::int32_t kNoAdm = 30;
inline constexpr std::int32_t kUsageConflict = 35;
inline constexpr std::int32_t kUnknown = 36;
inline constexpr std::int32_t kNoDistanceSet = 37;
inline constexpr std::int32_t kNoTrackerConnected = 38;
inline constexpr std::int32_t kNotInitialized = 39;
inline constexpr std::int32_t kWeatherOutOfRange = 57;
inline constexpr std::int32_t kCompensationMode = 58;
inline constexpr std::int32_t kInternalProcessActive = 59;
inline constexpr std::int32_t kInvalidInput = 98;
inline constexpr std::int32_t kNoValidAdmCompensation = 10002;
inline constexpr std::int32_t kPressureSensor = 10003;
inline constexpr std::int32_t kMeasurementStatusNotReady = 10004;
inline constexpr std::int32_t kStartUpBusy = 10005;
inline constexpr std::int32_t kNoStationaryResult = 10009;
inline constexpr std::int32_t kNotLevelled = 10010;
inline constexpr std::int32_t kSecondConnectionRefused = 10011;
inline constexpr std::int32_t kNotWarmedUp = 10012;
inline constexpr std::int32_t kNotStable = 10013;
inline constexpr std::int32_t kSystemNotReady = 10014;
inline constexpr std::int32_t kSensorCommunication = 10015;
inline constexpr std::int32_t kBattery = 10016;
inline constexpr std::int32_t kNotLevelledForInitialization = 10019;
inline constexpr std::int32_t kAdmHardware = 10020;
inline constexpr std::int32_t kAtrHardware = 10021;

/// The command was refused for now: another one is pending or an internal process runs.
bool is_busy(std::int32_t status);
/// The tracker must first be initialised, levelled, warmed up or ready.
bool is_not_ready(std::int32_t status);
/// An argument of the command was wrong or out of range.
bool is_bad_parameter(std::int32_t status);

}  // namespace truepose::emscon::status

namespace truepose::emscon {

/// One sentence for the operator, with the number, and what to do: "the tracker is not levelled (status
/// 10010): level it".
std::string describe_status(std::int32_t status);

}  // namespace truepose::emscon
