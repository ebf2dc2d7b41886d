#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/change/cell_change.hpp"
#include "core/change/change_evidence.hpp"

namespace truepose {

/// False-alarm rate of a test that asks whether residuals are chance.
inline constexpr double kSignificance = 0.005;

/// How a change continues over time.
enum class TimeProfile : std::uint8_t {
  BetweenChecks,  ///< made between two checks: the calibration and the points, two measurements of the nests
  Step,           ///< from one point on
  TwoSteps,       ///< from one point on, and again from another, which may lead back
  Linear,         ///< evenly, from the first point to the last
  Exponential,    ///< as an arm warms up that was cold at the first point
  FarStretch,     ///< from one point on, or up to one, by more than the others leave unexplained
  ByAngle,        ///< with the angle of a joint, and so by the order of the poses alone
};

/// What may have changed, and how over time.
struct ChangeHypothesis {
  Change what;
  TimeProfile profile = TimeProfile::BetweenChecks;

  bool operator==(const ChangeHypothesis&) const = default;
};

/// A change as an engine found it.
struct ChangeFound : ChangeHypothesis {
  double evidence = 0;  ///< logarithm of the marginal likelihood over that of no change
  /// Of the base (mm; turn about the tracker's axes, rad), the reflector (mm, flange frame), the joint (rad,
  /// mm), the reading (mm, tracker frame) or all lengths (share); of what moved while it was measured in the
  /// units of directions_of(), one step after the other; empty of what is only compared.
  Eigen::VectorXd moved, sigma;
};

/// The test that decides on a hypothesis, apart from its evidence.
enum class ChangeScorer : std::uint8_t {
  Evidence,   ///< ChangeEvidence::best() above the prior, all changes weighed together
  Gain,       ///< ChangeEvidence::chance() below the false-alarm rate; the evidence chooses among those found
  Compared,   ///< its evidence against those that are found: it is no finding of its own
  FarPoints,  ///< far_stretch(): points that nothing explains have no linear model
  Scatter,    ///< two F tests of moved_reference(), at a level that is exact for two readings
};

/// What is the same of each hypothesis of a kind and profile.
struct HypothesisRow {
  ChangeKind kind;
  TimeProfile profile;
  ChangeScorer scorer;
  double prior;                 ///< odds against no change; of a Gain, against a base that moved once
  double most_false_alarms;     ///< in an unchanged cell, of one check or campaign
  std::string_view counted_by;  ///< test that counts them
};

/// Every hypothesis. Mostly it is the tracker that moves; of several things at once a single one is suspected
/// first; calibrate() has left out most of a warm-up.
inline constexpr auto kHypotheses = [] {
  using enum ChangeKind;
  using enum TimeProfile;
  using enum ChangeScorer;
  constexpr std::string_view checks = "DriftCheckOverManyArms.LeavesUnchangedOnesAloneAtItsStatedLevel",
                             updates = "DriftUpdateOverManyArms.IsNotOfferedForChance*",
                             campaigns = "MovementOverManyCampaigns.IsSeldomReportedWhereNothingChanged",
                             references = "ReferencePoseOfACampaign.IsSeldomSaidToHaveMovedInAnUnchangedCell";
  return std::to_array<HypothesisRow>({
      {Base, BetweenChecks, Evidence, kOddsOfAChange, 0.03, checks},
      {Reflector, BetweenChecks, Evidence, kOddsOfAChange, 0.03, checks},
      {JointZero, BetweenChecks, Evidence, kOddsOfAChange, 0.03, checks},
      {Reading, BetweenChecks, Evidence, kOddsOfAChange, 0.03, checks},
      {AllZeros, BetweenChecks, Evidence, kOddsOfAChange, 0.02, updates},
      {Growth, BetweenChecks, Evidence, kOddsOfAChange, 0.02, updates},
      {Link, BetweenChecks, Evidence, kOddsOfAChange, 0.02, updates},
      {Base, Step, Gain, 1, 1e-3, campaigns},
      {Base, TwoSteps, Gain, 1e-2, 1e-5, campaigns},
      {Base, Linear, Gain, 1, 1e-3, campaigns},
      {Base, FarStretch, FarPoints, 1, 1e-3, campaigns},
      {JointZero, Step, Gain, 1e-3, 1e-3, campaigns},
      {Reflector, Step, Gain, 1e-3, 1e-3, campaigns},
      {Reflector, Linear, Gain, 5e-4, 1e-3, campaigns},
      {Growth, Step, Gain, 1e-4, 1e-3, campaigns},
      {AllZeros, Step, Gain, 1e-6, 1e-3, campaigns},
      {Load, Step, Gain, 1e-6, 1e-3, campaigns},
      {WarmUp, Exponential, Compared, 2e-2, 1e-3, campaigns},
      {JointErrors, ByAngle, Compared, 1e-3, 1e-3, campaigns},
      {Pose, Step, Scatter, 1, 7.5e-3, references},
  });
}();

/// That of a hypothesis, which must have one.
constexpr const HypothesisRow& row_of(const ChangeHypothesis& change) {
  return *std::ranges::find_if(kHypotheses, [&](const HypothesisRow& row) {
    return row.kind == change.what.kind && row.profile == change.profile;
  });
}

/// What happened, without an amount: "axis 3's zero moved" between two checks, "the encoder offset of joint 3
/// changed" while it was measured.
///
/// @param points  of which a reading is one
std::string name_of(const ChangeHypothesis& change, const CalibratedCell& cell,
                    std::span<const Measurement> points);
/// The same by how much: "axis 3's zero moved by 0.0120 deg", "the tracker or the base moved by 0.21 mm and
/// 0.0030 deg".
std::string described(const ChangeFound& found, const CalibratedCell& cell,
                      std::span<const Measurement> points);
/// And how well that is known: "axis 3's zero moved by 0.0123 deg (sigma 0.0005 deg)".
std::string described_with_sigma(const ChangeFound& found, const CalibratedCell& cell,
                                 std::span<const Measurement> points);
/// What to do about a change between two checks, as an order: "fit the frame again".
std::string_view remedy(ChangeKind kind);

}  // namespace truepose
