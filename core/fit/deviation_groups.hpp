#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/arm/joint_deviation.hpp"
#include "core/data/measurement.hpp"
#include "core/fit/evidence.hpp"

namespace truepose {

/// Why joints stand elsewhere than their encoders say. The coefficients of one cause scatter equally far.
enum class DeviationCause {
  Gears,              ///< harmonics of a revolute joint
  GravityCompliance,  ///< gravity: the robot's masses, or where these are not known unit weights at the
                      ///< origins of links
  MassMoments,  ///< gravity: masses anywhere, by the first moments of every link
  Backlash,     ///< the side from which a joint arrived
  Pitch,        ///< scale of a prismatic joint
  Bends,        ///< of a guide: what shifts a carriage off its way
  Twists,       ///< of a guide: what turns a carriage on its way
};
inline constexpr int kDeviationCauses = 7;

/// How far the deviations of a cause usually scatter: rad of the joint where its basis is largest (Pitch:
/// mm/m), mm or rad of the carriage.
WidthExpectation usual_width(DeviationCause cause);

/// Terms of one joint and cause: "joint2.harmonic1" (sine and cosine), "joint2.gravity", "joint2.moments",
/// "joint2.approach", "joint1.scale", "joint1.straightness", "joint1.guide" (turns of the carriage).
struct DeviationGroup {
  std::string name;
  DeviationCause cause = DeviationCause::Gears;
  std::vector<DeviationTerm> terms;  ///< coefficients 0
  double unit = 1;      ///< coefficient that moves the joint by 1 (rad) where the basis is largest
  bool smooth = false;  ///< the higher its order, the smaller a coefficient

  double unit_of(const DeviationTerm& term) const { return smooth ? unit / term.order : unit; }
};

/// Every group that the arm may have: harmonics of the given orders, whether or not the poses show enough of
/// a wave to tell them; gravity in both ways; approach where it was recorded and varies; guides along which
/// the arm was measured far enough.
std::vector<DeviationGroup> deviation_groups(const RobotModel& robot, std::span<const Measurement> points,
                                             std::span<const int> harmonics);

}  // namespace truepose
