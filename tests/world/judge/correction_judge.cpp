#include "tests/world/judge/correction_judge.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <string_view>

#include "core/math/units.hpp"
#include "tests/world/answers.hpp"
#include "tests/world/judge/rsi_attribute.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

constexpr int kRampedIn = 1000;  // cycles, several times the ramp
// In so many cycles the correction has come to rest behind an arm that stands.
constexpr int kAtRest = 50;
constexpr double kLargestError_mm = 0.005;
constexpr double kNoCorrection_rad = 2e-5;

std::optional<std::array<double, 6>> axes_rad(std::string_view text, const std::string& element) {
  std::array<double, 6> axes{};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto deg = rsi_attribute(text, element, "A" + std::to_string(i + 1));
    if (!deg) return std::nullopt;
    axes[i] = *deg * kRadPerDeg;
  }
  return axes;
}

}  // namespace

asio::awaitable<void> CorrectionJudge::armed(Client& client) {
  const json::value answer = co_await client.ask("model.get");
  if (!is_result(answer)) co_return;
  serial_ = text_at(result_of(answer).at("model").as_object(), "robot_serial");
  model_ = arm_of(result_of(answer).at("parameters").as_array(), nominal_);
  model_->base = model_->base_turn = model_->reflector = {};
}

void CorrectionJudge::see(const RsiCycle& cycle) {
  judge_robot_file(cycle.reply);
  const bool goes_on = cycle.session == session_ && !cycle.reply.empty() && model_ && !log_.is_disturbed();
  session_ = cycle.session;
  cycles_ = goes_on ? cycles_ + 1 : 0;
  const auto wanted = axes_rad(cycle.datagram, "ASPos");
  at_rest_ = goes_on && wanted == wanted_ ? at_rest_ + 1 : 0;
  wanted_ = wanted;
  if (cycles_ >= kRampedIn && at_rest_ == kAtRest && wanted_) judge(cycle.reply);
}

void CorrectionJudge::judge_robot_file(std::string_view reply) {
  // What is in effect when a daemon ends is ramped out by the next one.
  constexpr std::chrono::minutes kRampedOut{1};
  const config::CellConfig* const config = cell_.pc.running();
  if (config == nullptr || log_.now() - cell_.pc.started() < kRampedOut) return;
  if (config->robot.model.joints.at(1).a_mm == nominal_.joints.at(1).a_mm) return;
  const auto correction = axes_rad(reply, "AK");
  if (correction &&
      std::ranges::any_of(*correction, [](double rad) { return std::abs(rad) > kNoCorrection_rad; }))
    log_.broken("a daemon corrects whose robot file is another arm's");
}

void CorrectionJudge::judge(std::string_view reply) {
  const auto correction = axes_rad(reply, "AK");
  if (!correction) return;
  if (serial_ != std::to_string(cell_.scenario.robot_serial))
    log_.broken("the arm " + std::to_string(cell_.scenario.robot_serial) +
                " is corrected by a model of arm " + serial_);
  std::array<double, 6> corrected = *wanted_;
  for (std::size_t i = 0; i < corrected.size(); ++i) corrected[i] += (*correction)[i];
  const Arm::Vector is = model_->point(corrected), should = nominal_arm(nominal_).point(*wanted_);
  const double error_mm = std::hypot(is[0] - should[0], is[1] - should[1], is[2] - should[2]);
  ++compared;
  largest_error_mm = std::max(largest_error_mm, error_mm);
  if (error_mm > kLargestError_mm)
    log_.broken("the corrected flange is " + std::to_string(error_mm) +
                " mm from where the active model has it");
}

}  // namespace truepose::world
