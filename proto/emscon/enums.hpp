#pragma once

#include <cstdint>

/// Numbers of the emScon wire protocol (TPI 3.6). Every enumeration travels as int32 and may hold a value not
/// named here.
namespace truepose::emscon {

enum class PacketType : std::int32_t {
  Command = 0,
  Error = 1,
  SingleMeasResult = 2,
  MultiMeasResult = 3,
  NivelResult = 6,
  ReflectorPosResult = 7,
  SystemStatusChange = 8,
  SingleMeasResult2 = 9,
};

enum class CommandCode : std::int32_t {
  ExitApplication = 0,
  GetSystemStatus = 1,
  GetTrackerStatus = 2,
  SetUnits = 5,
  GetUnits = 6,
  Initialize = 7,
  ReleaseMotors = 8,
  Park = 10,
  SetStationOrientationParams = 12,
  GetStationOrientationParams = 13,
  SetTransformationParams = 14,
  GetTransformationParams = 15,
  SetEnvironmentParams = 20,
  GetEnvironmentParams = 21,
  SetRefractionParams = 22,
  GetRefractionParams = 23,
  SetMeasurementMode = 24,
  GetMeasurementMode = 25,
  SetCoordinateSystemType = 26,
  GetCoordinateSystemType = 27,
  SetStationaryModeParams = 28,
  GetStationaryModeParams = 29,
  SetContinuousTimeModeParams = 30,
  GetContinuousTimeModeParams = 31,
  SetContinuousDistanceModeParams = 32,
  GetContinuousDistanceModeParams = 33,
  SetReflector = 40,
  GetReflector = 41,
  GetReflectors = 42,
  SetSearchParams = 43,
  GetSearchParams = 44,
  SetAdmParams = 45,
  GetAdmParams = 46,
  SetSystemSettings = 47,
  GetSystemSettings = 48,
  StartMeasurement = 49,
  StartNivelMeasurement = 51,
  StopMeasurement = 52,
  ChangeFace = 53,
  GoBirdBath = 54,
  GoPosition = 55,
  GoPositionHvd = 56,
  PositionRelativeHv = 57,
  PointLaser = 58,
  PointLaserHvd = 59,
  MoveHv = 60,
  GoLastMeasuredPoint = 62,
  FindReflector = 63,
  Unknown = 64,  ///< in an Error that no command caused
  LookForTarget = 65,
  GetDirection = 66,
  SetStatisticMode = 80,
  GetStatisticMode = 81,
  CheckBirdBath = 87,
  GoBirdBath2 = 95,
  GetFace = 98,
  SetLongSystemParameter = 120,
  GetLongSystemParameter = 121,
  GetMeasurementStatusInfo = 122,
  SetDoubleSystemParameter = 125,
  GetDoubleSystemParameter = 126,
  GetObjectTemperature = 127,
  ClearCommandQueue = 130,
  GetTrackerInfo = 132,
  GoAndMeasure = 135,
  GetAt4xxInfo = 140,
  GetSystemSoftwareVersion = 142,
};

enum class LengthUnit : std::int32_t {
  Meter = 0,
  Millimeter = 1,
  Micrometer = 2,
  Foot = 3,
  Yard = 4,
  Inch = 5
};
enum class AngleUnit : std::int32_t { Radian = 0, Degree = 1, Gon = 2 };
enum class TemperatureUnit : std::int32_t { Celsius = 0, Fahrenheit = 1 };
enum class PressureUnit : std::int32_t {
  Mbar = 0,
  HPascal = 1,
  KPascal = 2,
  MmHg = 3,
  Psi = 4,
  InH2O = 5,
  InHg = 6
};
enum class HumidityUnit : std::int32_t { RelativePercent = 0 };

/// Right-handed Cartesian, left-handed with one axis reversed, cylindrical and spherical (clockwise,
/// counter-clockwise).
enum class CoordinateSystem : std::int32_t {
  Rhr = 0,
  LhrX = 1,
  LhrY = 2,
  LhrZ = 3,
  Ccw = 4,
  Ccc = 5,
  Scw = 6,
  Scc = 7
};

enum class MeasurementMode : std::int32_t { Stationary = 0, ContinuousTime = 1, ContinuousDistance = 2 };
enum class WeatherMonitor : std::int32_t { NotConnected = 0, ReadOnly = 1, ReadAndCompute = 2 };
enum class TargetKind : std::int32_t { Unknown = 0, CornerCube = 1, CatsEye = 2, GlassPrism = 3 };
enum class TrackerReadiness : std::int32_t { NotReady = 0, Busy = 1, Ready = 2 };
enum class StatisticKind : std::int32_t { Standard = 0, Extended = 1 };

enum class ProcessorStatus : std::int32_t {
  NotFound = 0,
  Found = 1,
  NetworkBufferOpen = 2,
  Booted = 3,
  CompensationSet = 4,
  Initialized = 5,
};

enum class LaserStatus : std::int32_t {
  CommunicationFailed = 0,
  NotAvailable = 1,
  HeatingUp = 2,
  Ready = 3,
  UnableToStabilize = 4,
  Off = 5,
};

enum class AdmStatus : std::int32_t {
  None = 0,
  CommunicationFailed = 1,
  Ready = 2,
  Busy = 3,
  HardwareError = 4,
  SecurityLock = 5,
  NotCompensated = 6,
};

enum class SystemEvent : std::int32_t {
  LaserWarmedUp = 1,
  EnvironmentChanged = 2,
  RefractionChanged = 3,
  SearchParamsChanged = 4,
  AdmParamsChanged = 5,
  UnitsChanged = 6,
  ReflectorChanged = 7,
  SystemSettingsChanged = 8,
  CoordinateSystemChanged = 12,
  StationOrientationChanged = 15,
  TransformationChanged = 16,
  MeasurementModeChanged = 17,
  StationaryParamsChanged = 18,
  ContinuousTimeParamsChanged = 19,
  ContinuousDistanceParamsChanged = 20,
  StatisticModeChanged = 24,
  MeasurementNotReady = 25,  ///< among other causes: the beam is broken
  MeasurementBusy = 26,
  MeasurementReady = 27,
  InitializationChanged = 151,
  ServerClosing = 998,
};

/// Bits of MeasurementStatusInfo::mask.
inline constexpr std::int32_t kTrackerFoundBit = 1;
inline constexpr std::int32_t kReflectorFoundBit = 2048;
inline constexpr std::int32_t kInitializedBit = 65536;

}  // namespace truepose::emscon
