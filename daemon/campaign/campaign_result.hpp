#pragma once

#include <boost/asio/awaitable.hpp>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "core/calibration/calibrate.hpp"
#include "core/evaluation/drift_check.hpp"
#include "daemon/campaign/cell_devices.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

/// What a campaign is for.
enum class CampaignKind {
  Calibration,
  DriftCheck,  ///< whether the active model is still right, by a few poses
};

struct CampaignResult {
  CampaignKind kind = CampaignKind::Calibration;
  Identities identities;
  // Of a drift check:
  std::optional<DriftReference> drift_reference;
  std::optional<DriftCheck> drift;
  // Of a calibration:
  Calibration calibration;
  MeasurementNoise noise;                             ///< of a point about the calibrated model
  double elapsed_s = 0;                               ///< time that the identification took
  MeasurementData data;                               ///< what was identified and validated from
  std::optional<ErrorStatistics> remeasured;          ///< validation poses reached with compensated joints
  std::vector<Eigen::Vector3d> remeasured_errors_mm;  ///< measured minus asked for, tracker frame
  /// Distances of the reference pose from where it was measured first, in the order of measuring.
  std::vector<double> reference_drift_mm;
  std::vector<StoredPoint> points;
  std::vector<SkippedPose> skipped;
  /// The calibrated arm is nearer to the validation points than the nominal one: it may be activated.
  bool improves = false;
};

enum class CampaignFault { Device, WrongArm, Planning, Store, Calibration, Aborted, Internal };

struct CampaignError {
  CampaignFault fault;
  std::string detail;  ///< one sentence for the operator
};

/// What a step of a campaign comes to.
template <typename T>
using CampaignOutcome = boost::asio::awaitable<std::expected<T, CampaignError>>;

}  // namespace truepose::daemon
