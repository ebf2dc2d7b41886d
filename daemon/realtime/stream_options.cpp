#include "daemon/realtime/stream_options.hpp"

#include <algorithm>

#include "config/ethernet_file.hpp"
#include "config/text_file.hpp"

namespace truepose::daemon {
namespace {

std::optional<std::string> why_unfit(const rsi::EthernetConfig& ethernet) {
  if (ethernet.only_send)
    return "the RSI configuration has ONLYSEND=TRUE: the controller takes no correction";
  if (!ethernet.axis_correction)
    return "the RSI configuration receives no axis correction (an element with A1 to A6)";
  for (const rsi::Element& element : ethernet.receive) {
    if (element.tag.starts_with(*ethernet.axis_correction + ".A") && !element.hold_on)
      return "the RSI configuration gives " + element.tag +
             " HOLDON=\"0\": one lost packet would take the whole correction away in one cycle; give it "
             "HOLDON=\"1\"";
  }
  if (!ethernet.sends("ASPos") && !ethernet.sends("AIPos"))
    return "the RSI configuration sends neither DEF_ASPos nor DEF_AIPos: the commanded axes are unknown";
  if (!ethernet.sends("Delay"))
    return "the RSI configuration does not send DEF_Delay: a lost reply would look like one "
           "that was taken, and the next would be a jump; add it to the SEND list";
  return std::nullopt;
}

std::optional<std::string> why_unfit(const StreamOptions& options) {
  const double greatest = 90 * kRadPerDeg;
  const double grid = CorrectionBounds{}.resolution;
  if (!(options.max_step_rad >= grid && options.max_step_rad <= greatest) ||
      !(options.max_total_rad >= grid && options.max_total_rad <= greatest) || options.ramp_cycles < 1)
    return "step, total and ramp of the correction must be positive, and the first two at most 90 deg";
  if (options.cycle < std::chrono::milliseconds{1} || options.timeout_cycles < 1)
    return "cycle and timeout of the controller must be positive";
  return std::nullopt;
}

}  // namespace

std::optional<std::string> why_unfit(const RobotModel& nominal) {
  const auto revolute = [](const Joint& joint) { return joint.type == JointType::Revolute; };
  if (nominal.joint_count() == 6 && std::ranges::all_of(nominal.joints, revolute)) return std::nullopt;
  return "the daemon drives six revolute joints, but " + nominal.name +
         " has others: its files are calibrated and compensated by `truepose` alone";
}

StreamOptions StreamOptions::of(const config::CellConfig& cell) {
  const config::StreamConfig& config = cell.stream;
  const auto cycles = [&](std::chrono::milliseconds time) {
    return std::max(1, static_cast<int>(time / config.cycle));
  };
  using namespace std::chrono_literals;
  return {.max_step_rad = config.max_step_deg * kRadPerDeg,
          .max_total_rad = config.max_total_deg * kRadPerDeg,
          .limit_margin_rad = config.limit_margin_deg * kRadPerDeg,
          .singular_below_rad = config.singularity_threshold_deg * kRadPerDeg,
          .ramp_cycles = cycles(config.ramp),
          .broken_cycles = cycles(1s),
          .timeout_cycles = config.timeout_cycles,
          .cycle = config.cycle,
          .disarm_after = config.rearm == config::Rearm::Automatic ? std::nullopt : std::optional{kSilence},
          .max_fk_deviation_mm = cell.robot.max_fk_deviation_mm};
}

CorrectionBounds StreamOptions::bounds(const RobotModel& robot) const {
  CorrectionBounds bounds{.max_step = max_step_rad,
                          .max_total = max_total_rad,
                          .min = JointVector(robot.joint_count()),
                          .max = JointVector(robot.joint_count()),
                          .limit_margin = limit_margin_rad};
  for (Eigen::Index i = 0; i < robot.joint_count(); ++i) {
    bounds.min[i] = robot.joints[static_cast<std::size_t>(i)].min;
    bounds.max[i] = robot.joints[static_cast<std::size_t>(i)].max;
  }
  return bounds;
}

std::optional<std::string> why_unfit(const RobotModel& nominal, const rsi::EthernetConfig& ethernet,
                                     const StreamOptions& options) {
  if (auto why = why_unfit(nominal)) return why;
  if (auto why = why_unfit(ethernet)) return why;
  return why_unfit(options);
}

std::expected<rsi::EthernetConfig, std::string> read_ethernet(const std::filesystem::path& file) try {
  return config::load_ethernet(file);
} catch (const config::ConfigError& error) {
  return std::unexpected(error.what());
}

}  // namespace truepose::daemon
