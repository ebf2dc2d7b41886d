#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "core/named.hpp"

namespace truepose {

/// How much a finding weighs, the least first.
enum class Severity {
  Note,     ///< worth knowing, and harmless
  Advice,   ///< what the data cannot show
  Warning,  ///< a test that failed: look at it before the model is used
  Error,    ///< the model is not to be used
};
inline constexpr std::array kSeverityNames{Named{"note", Severity::Note}, Named{"advice", Severity::Advice},
                                           Named{"warning", Severity::Warning},
                                           Named{"error", Severity::Error}};

/// What a verdict may find, in the order of its table.
enum class FindingKind {
  NotConverged,
  NoBetter,
  LeavesMuch,
  HardlyBetter,
  LeavesMore,
  LeavesSome,
  ManyOutliers,
  Outliers,
  FieldSubset,
  NoiseUnstated,

  NotValidated,
  FewValidated,
  ValidationOff,
  LayersUnsure,
  Tolerance,
  BelowNoise,
  ValidationOutliersMatter,
  ValidationOutliers,
  CorrectedInPart,
  UnknownElsewhere,

  ReferenceMoved,
  BaseMoved,
  ZeroChanged,
  Mastered,
  ReflectorMoved,
  LoadChanged,
  LengthsChanged,
  ChangeUnsure,
  ChangeSmall,
  StillWarming,

  StaleJoints,
  StaleJointsLeftOut,
  Duplicates,
  ClockSet,
  CoarseJoints,
  RoundedJoints,
  NarrowPoses,
  BeyondLimits,
  ReflectorOnAxis,
  WarmthOpen,

  SplitsTolerance,
  SplitsRefused,
  SplitsDoubted,
  SplitsDoubtedSome,

  TwoFace,
  TwoFaceUnexplained,
  NestsCorrected,
  NestsMoved,
  NestsDoubtful,
  LeftOutMoving,
  Resumed,
  ReflectorUnidentified,

  NoVerdict,
};

/// What is the same of each finding of a kind. docs/verdict.md has the table; a test compares them.
struct FindingRow {
  FindingKind kind;
  std::string_view code;  ///< stable, for programs
  Severity severity;
  std::string_view condition;   ///< what is found, with its threshold
  std::string_view source;      ///< of the threshold
  double most_false_alarms;     ///< share of sound campaigns that may have it by chance; a test counts them
  std::string_view what_to_do;  ///< in the imperative; empty where there is nothing to do
};

/// Sources of several thresholds.
inline constexpr std::string_view kBySignificance = "chance below 1 in 200 (kSignificance), and large";
inline constexpr std::string_view kByDefinition = "a fact, without a threshold";
inline constexpr std::string_view kByExperience = "experience with simulated and real arms";
inline constexpr std::string_view kMovement = "likelihood against no change, chance below 1 in 1000";

inline constexpr std::array kFindings{
    FindingRow{FindingKind::NotConverged, "V_NOT_CONVERGED", Severity::Error, "no convergence",
               "steps below 1e-6 of the residual", 0, "check the robot file and the measurements"},
    FindingRow{FindingKind::NoBetter, "V_NO_BETTER", Severity::Error, "no better than the nominal arm",
               kByDefinition, 0, "check the robot file, the mounting of the reflector and the tracker"},
    FindingRow{FindingKind::LeavesMuch, "V_LEAVES_MUCH", Severity::Error,
               "a residual above 50 times the noise",
               "gears, bearings and loads leave tenths of a mm, noise hundredths", 0,
               "check the measurements, or measure again"},
    FindingRow{FindingKind::HardlyBetter, "V_HARDLY_BETTER", Severity::Warning,
               "a residual above 3 times the noise and half of the nominal errors", kByExperience, 0,
               "look for what changed while it was measured"},
    FindingRow{FindingKind::LeavesMore, "V_LEAVES_MORE", Severity::Warning,
               "a residual above 10 times the noise", kByExperience, 0.005,
               "identify with --non-geometric auto, or look for what the model does not know"},
    FindingRow{FindingKind::LeavesSome, "V_LEAVES_SOME", Severity::Advice,
               "a residual above 3 times the noise", kByExperience, 0.005,
               "identify with --non-geometric auto, or look for what the model does not know"},
    FindingRow{FindingKind::ManyOutliers, "V_MANY_OUTLIERS", Severity::Warning, "more than 10 % outliers",
               kByExperience, 0.001, "check tracker, reflector and joint readings"},
    FindingRow{FindingKind::Outliers, "V_OUTLIERS", Severity::Note, "points beyond six sigma, left out",
               "six sigma", 1, ""},
    FindingRow{FindingKind::FieldSubset, "V_FIELD_SUBSET", Severity::Note,
               "more than 2000 poses for a residual field", "its time grows with their cube", 1, ""},
    FindingRow{FindingKind::NoiseUnstated, "V_NOISE_UNSTATED", Severity::Note, "no stated noise",
               kByDefinition, 1,
               "state --tracker-noise and --repeatability to have the residuals judged by them"},

    FindingRow{FindingKind::NotValidated, "V_NOT_VALIDATED", Severity::Warning, "no validation",
               kByDefinition, 0, "validate on other poses (--split, --folds or --validate)"},
    FindingRow{FindingKind::FewValidated, "V_FEW_VALIDATED", Severity::Warning,
               "fewer than 5 unseen validation poses", kByExperience, 0,
               "validate on at least 5 poses that the identification has not seen"},
    FindingRow{FindingKind::ValidationOff, "V_VALIDATION_OFF", Severity::Error,
               "validation errors beyond the predicted ones", kBySignificance, 0.001,
               "find what changed, and measure again"},
    FindingRow{FindingKind::LayersUnsure, "V_LAYERS_UNSURE", Severity::Advice,
               "the same, with layers that make it better", kBySignificance, 0.005, "use it"},
    FindingRow{FindingKind::Tolerance, "V_TOLERANCE", Severity::Error, "a largest error beyond --tolerance",
               "the user's", 0, "add layers or poses, or allow more"},
    FindingRow{FindingKind::BelowNoise, "V_BELOW_NOISE", Severity::Warning,
               "a mean error below half of what the noise alone makes", kByExperience, 0.001,
               "identify from more poses, or correct the stated noise"},
    FindingRow{FindingKind::ValidationOutliersMatter, "V_VALIDATION_OUTLIERS_MATTER", Severity::Warning,
               "validation outliers that change the errors by 10 %", "six sigma", 0.005,
               "measure them again"},
    FindingRow{FindingKind::ValidationOutliers, "V_VALIDATION_OUTLIERS", Severity::Note,
               "other validation outliers", "six sigma", 1, "measure them again"},
    FindingRow{FindingKind::CorrectedInPart, "V_CORRECTED_IN_PART", Severity::Note,
               "a compensated pose off, by the model, by more than any validation pose", kByDefinition, 1,
               "keep the arm away from there where its position matters"},
    FindingRow{FindingKind::UnknownElsewhere, "V_UNKNOWN_ELSEWHERE", Severity::Advice,
               "an uncertainty above the mean nominal error", kByDefinition, 0.005,
               "use it only where poses were measured, or measure poses over the workspace"},

    FindingRow{FindingKind::ReferenceMoved, "V_REFERENCE_MOVED", Severity::Error,
               "a reference pose that did not stay", kBySignificance, 0.001,
               "fix tracker, base and reflector, and measure again"},
    FindingRow{FindingKind::BaseMoved, "V_BASE_MOVED", Severity::Error, "a tracker or base that moved",
               kMovement, 0.001, "fix the mounting, or measure nests, and measure again"},
    FindingRow{FindingKind::ZeroChanged, "V_ZERO_CHANGED", Severity::Error, "a changed encoder offset",
               kMovement, 0.001, "check the mastering of the joint, and measure again"},
    FindingRow{FindingKind::Mastered, "V_MASTERED", Severity::Error, "several encoder offsets changed",
               kMovement, 0.001, "measure again"},
    FindingRow{FindingKind::ReflectorMoved, "V_REFLECTOR_MOVED", Severity::Error,
               "an exchanged or moved reflector", kMovement, 0.001,
               "give it another name from there on (column smr), or measure again"},
    FindingRow{FindingKind::LoadChanged, "V_LOAD_CHANGED", Severity::Error, "another load on the flange",
               kMovement, 0.001, "state the payloads (columns payload_*), or measure again"},
    FindingRow{FindingKind::LengthsChanged, "V_LENGTHS_CHANGED", Severity::Error,
               "lengths that changed with temperature", kMovement, 0.001,
               "warm the arm up, and measure again"},
    FindingRow{FindingKind::ChangeUnsure, "V_CHANGE_UNSURE", Severity::Warning,
               "one of these, but which or whether is open", kMovement, 0.003,
               "look for it, or measure again in another order"},
    FindingRow{FindingKind::ChangeSmall, "V_CHANGE_SMALL", Severity::Note, "a small one of these", kMovement,
               1, ""},
    FindingRow{FindingKind::StillWarming, "V_STILL_WARMING", Severity::Warning, "an arm still warming up",
               kByExperience, 0.003, "warm the arm up before it is measured"},

    FindingRow{FindingKind::StaleJoints, "V_STALE_JOINTS", Severity::Warning,
               "the same joints for points farther than 50 mm apart", kByDefinition, 0,
               "leave out the wrong ones of them"},
    FindingRow{FindingKind::StaleJointsLeftOut, "V_STALE_JOINTS_LEFT_OUT", Severity::Note,
               "the same, and all were left out", kByDefinition, 1, "leave out the wrong ones of them"},
    FindingRow{FindingKind::Duplicates, "V_DUPLICATES", Severity::Warning, "repeated readings", kByDefinition,
               0, "leave them out"},
    FindingRow{FindingKind::ClockSet, "V_CLOCK_SET", Severity::Warning, "times that go back", kByDefinition,
               0, "correct the times"},
    FindingRow{FindingKind::CoarseJoints, "V_COARSE_JOINTS", Severity::Warning,
               "joints rounded to 0.1 deg or coarser", "half to twice of it", 0.001,
               "give the joints with four decimals"},
    FindingRow{FindingKind::RoundedJoints, "V_ROUNDED_JOINTS", Severity::Advice, "joints rounded to 0.01 deg",
               "half to twice of it", 0.005, "give the joints with four decimals"},
    FindingRow{FindingKind::NarrowPoses, "V_NARROW_POSES", Severity::Warning,
               "most joints measured over less than a quarter of their range", kByExperience, 0,
               "measure poses over the whole range, or state that it is used there alone (--local, or the "
               "task of the cell file)"},
    FindingRow{FindingKind::BeyondLimits, "V_BEYOND_LIMITS", Severity::Advice,
               "poses beyond the limits of the robot file", kByDefinition, 0,
               "correct min and max of the robot file"},
    FindingRow{FindingKind::ReflectorOnAxis, "V_REFLECTOR_ON_AXIS", Severity::Advice,
               "reflectors on the last axis", "five usual deviations of its zero do not show", 0.001,
               "mount them at least 50 mm off it"},
    FindingRow{FindingKind::WarmthOpen, "V_WARMTH_OPEN", Severity::Note, "validation points without a time",
               kByDefinition, 1, "give all points a time"},

    FindingRow{FindingKind::SplitsTolerance, "V_SPLITS_TOLERANCE", Severity::Error,
               "errors of some splits beyond --tolerance", "the user's", 0,
               "add layers or poses, or allow more"},
    FindingRow{FindingKind::SplitsRefused, "V_SPLITS_REFUSED", Severity::Error, "another split with an error",
               kByDefinition, 0, "see that finding"},
    FindingRow{FindingKind::SplitsDoubted, "V_SPLITS_DOUBTED", Severity::Warning,
               "more than half of the splits with a warning", "Markov's inequality: 1 in 100", 0.01,
               "see that finding"},
    FindingRow{FindingKind::SplitsDoubtedSome, "V_SPLITS_DOUBTED_SOME", Severity::Note,
               "fewer splits with a warning", "Markov's inequality: 1 in 100", 1, ""},

    FindingRow{FindingKind::TwoFace, "V_TWO_FACE", Severity::Note, "what was seen in both faces",
               kByDefinition, 1, ""},
    FindingRow{FindingKind::TwoFaceUnexplained, "V_TWO_FACE_UNEXPLAINED", Severity::Advice,
               "faces that differ by more than aiming constants explain", kBySignificance, 0.001,
               "have the tracker checked and compensated"},
    FindingRow{FindingKind::NestsCorrected, "V_NESTS_CORRECTED", Severity::Note,
               "a corrected shift of the tracker", kBySignificance, 1, ""},
    FindingRow{FindingKind::NestsMoved, "V_NESTS_MOVED", Severity::Warning,
               "the same without correct_by_nests", kBySignificance, 0.001,
               "set correct_by_nests, or measure again"},
    FindingRow{FindingKind::NestsDoubtful, "V_NESTS_DOUBTFUL", Severity::Advice,
               "nests that contradict each other", kBySignificance, 0.001, "fix the nests"},
    FindingRow{FindingKind::LeftOutMoving, "V_LEFT_OUT_MOVING", Severity::Note,
               "poses measured while the tracker moved", kBySignificance, 1, ""},
    FindingRow{FindingKind::Resumed, "V_RESUMED", Severity::Note, "an interrupted campaign", kByDefinition, 1,
               ""},
    FindingRow{FindingKind::ReflectorUnidentified, "V_REFLECTOR_UNIDENTIFIED", Severity::Advice,
               "a reflector without a pose to identify from", kByDefinition, 0, "add poses that see it"},

    FindingRow{FindingKind::NoVerdict, "V_NO_VERDICT", Severity::Error, "a document without a verdict",
               kByDefinition, 0, "make it again with truepose calibrate"},
};

constexpr const FindingRow& row_of(FindingKind kind) { return kFindings[static_cast<std::size_t>(kind)]; }
static_assert(std::ranges::is_sorted(kFindings, {}, &FindingRow::kind) &&
              kFindings.size() == static_cast<std::size_t>(FindingKind::NoVerdict) + 1);

/// One finding of a verdict.
struct Finding {
  Severity severity = Severity::Note;
  std::string sentence;    ///< what was found, with its figures; without a capital or a full stop
  std::string code;        ///< stable, for programs
  std::string what_to_do;  ///< in the imperative, likewise; may be empty

  bool operator==(const Finding&) const = default;
};

/// @param sentence  of this case
inline Finding finding(FindingKind kind, std::string sentence) {
  const FindingRow& row = row_of(kind);
  return {row.severity, std::move(sentence), std::string{row.code}, std::string{row.what_to_do}};
}

}  // namespace truepose
