#pragma once

#include <Eigen/Geometry>
#include <array>
#include <expected>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/rsi/context.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::sim {

/// What leads from the controller into the signal flow.
struct FlowSources {
  std::function<int(int index)> sen_pint;                             ///< $SEN_PINT
  std::function<double(int index)> sen_prea = [](int) { return 0; };  ///< $SEN_PREA
  std::function<bool(int index)> in = [](int) { return false; };      ///< $IN
  std::function<bool(int index)> out = [](int) { return false; };     ///< $OUT
  rsi::Axes axes_deg{};                                               ///< actual
  double time_s = 0;
  int mode = rsi::kModeExt;
  int program_state = rsi::kProgramActive;
  int override_percent = 100;
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< $BASE, in the robot root
  Eigen::Isometry3d tool = Eigen::Isometry3d::Identity();  ///< $TOOL, on the flange
};

/// How POSCORR moves the TCP, within its limits.
struct PoseCorrection {
  enum class System { World, Base, RobRoot, Tool };
  System system = System::World;
  Eigen::Vector3d mm{0, 0, 0};
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();

  /// @param X  of the TCP in the robot root, without the correction. World and robot root are one here
  Eigen::Isometry3d applied_to(const Eigen::Isometry3d& X, const Eigen::Isometry3d& base) const;
};

/// What the signal flow does to the controller in one cycle.
struct FlowEffects {
  rsi::Axes correction_deg{};  ///< of AXISCORR, within its limits
  std::optional<PoseCorrection> pose_correction = {};
  bool clamped = false;             ///< one of them was larger
  std::optional<int> monitor_axis;  ///< the axis whose correction AXISCORRMON does not allow, from 1
  bool monitor_pose = false;        ///< the correction of the TCP is larger than POSCORRMON allows
  bool leaves_movecorr = false;     ///< STOP of mode 4
  std::map<int, int> sen_pint;      ///< values for $SEN_PINT, by index
  std::map<int, double> sen_prea;   ///< values for $SEN_PREA, by index
  std::map<int, bool> outputs;      ///< values for $OUT, by index
  std::map<int, double> analog;     ///< values for $ANOUT, by index
};

/// Values of the ETHERNET object, by the numbers of its inputs or outputs.
using ChannelValues = std::map<int, double>;

/// A parameter of an object that is a number, as programs name it (RSI_SetPublicPar): in any letter case.
struct RsiParameter {
  std::string object, parameter;  ///< "AxisCorr_1", "LowerLimA1"
  double value = 0;
};
/// What it is in the context; none where that has no such object, or the object no such parameter.
std::optional<double> value_of(const rsi::Context& context, const RsiParameter& parameter);
/// Of one that the context has.
void set_parameter(rsi::Context& context, const RsiParameter& parameter);

class RsiSignals;

/// The signal flow of a context, executed once in each cycle of RSI. Objects: AXISCORR, AXISCORRMON, POSCORR
/// (but along the path), POSCORRMON, STOP, MAP2SEN_PINT, MAP2SEN_PREA, MAP2DIGOUT, MAP2ANOUT, MONITOR (which
/// changes nothing), and those that RsiSignals knows.
class RsiFlow {
 public:
  /// Errors: the object, or its setting, that is not simulated.
  static std::expected<RsiFlow, std::string> of(rsi::Context context);

  int timeout_cycles() const;  ///< of the ETHERNET object
  int decimals() const;        ///< its Precision
  std::string ethernet_file() const;

  /// What ETHERNET sends, by its inputs.
  ChannelValues sent(const FlowSources& sources) const;
  /// @param received  by the outputs of ETHERNET; what is not there is 0
  /// @param total     of #RELATIVE: the corrections so far, to which these are added; of #ABSOLUTE none
  FlowEffects effects(const FlowSources& sources, const ChannelValues& received,
                      const FlowEffects& total = {}) const;

 private:
  /// @param context  with all parameters
  explicit RsiFlow(rsi::Context context) : context_{std::move(context)} {}
  const rsi::ContextObject& ethernet() const { return *context_.of_type("ETHERNET"); }
  void correct(const rsi::ContextObject& object, const RsiSignals& signals, FlowEffects& effects) const;
  void monitor(FlowEffects& effects) const;
  PoseCorrection pose_correction(const rsi::ContextObject& object, const RsiSignals& signals,
                                 const std::optional<PoseCorrection>& total, bool& clamped) const;
  bool stops_at(const PoseCorrection& correction) const;

  rsi::Context context_;
};

}  // namespace truepose::sim
