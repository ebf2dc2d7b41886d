#pragma once

#include <boost/json/object.hpp>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/change/drift_check.hpp"
#include "core/change/drift_update.hpp"
#include "core/named.hpp"
#include "proto/record/layout.hpp"

namespace truepose::record {

inline constexpr std::array kDriftVerdicts{Named{"ok", DriftVerdict::Ok},
                                           Named{"warning", DriftVerdict::Warning},
                                           Named{"failed", DriftVerdict::Failed}};
inline constexpr std::array kDriftCauses{
    Named{"base", ChangeKind::Base}, Named{"reflector", ChangeKind::Reflector},
    Named{"joint_zero", ChangeKind::JointZero}, Named{"reading", ChangeKind::Reading}};
/// Whether the check took the model's parameters as uncertain.
inline constexpr std::array kParameterTrust{Named{"uncertain", true}, Named{"taken as exact", false}};

/// The model brought up to date by the points.
struct ModelUpdate {
  bool offered = false;                         ///< nothing speaks against it
  std::vector<std::string> moved;               ///< sentences, with standard deviations
  std::vector<std::string> rejected, warnings;  ///< readings left out; why it is not offered
  double before = 0, after = 0;  ///< mean error of the points with the old and the new model, mm
  double leave_one_out = 0;      ///< and each predicted by the others alone
  double p_value = 0;            ///< that an unchanged cell gives as much as the new model leaves
};

/// The document of `truepose drift --json` and of drift.check: verdict, reason, errors point by point (mm,
/// predicted less measured, by their rows), and what the points say of the cause.
struct DriftDocument {
  struct Error {
    int row = 0;
    Eigen::Vector3d error{0, 0, 0};
    double length = 0;
  };
  struct Cause {
    ChangeKind kind = ChangeKind::Base;
    std::string smr;  ///< of a reflector
    int joint = 0;    ///< from 1, of a joint
    int row = 0;      ///< of a reading
    std::string text;
    Eigen::VectorXd moved, sigma;
    double p_value = 0;
    bool explains = false;
  };

  DriftVerdict verdict = DriftVerdict::Ok;
  std::string reason;
  double mean = 0, max = 0, reference = 0;  ///< mm
  double chi2 = 0;
  int degrees_of_freedom = 0;
  double p_value = 0;
  bool uncertain_parameters = false;
  std::vector<Error> points;
  std::vector<Cause> causes, alternatives;
  std::optional<ModelUpdate> update;  ///< where one was asked for
};
void layout(Io& io, DriftDocument& x);

/// What a check found of these points.
DriftDocument drift_of(const DriftCheck& check, const DriftReference& reference,
                       std::span<const Measurement> points);
ModelUpdate update_of(const DriftUpdate& update, std::span<const Measurement> points);
boost::json::object drift_document(const DriftDocument& document);

}  // namespace truepose::record
