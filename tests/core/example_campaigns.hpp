#pragma once

#include <expected>

#include "core/calibrate/calibrate.hpp"
#include "core/simulate/measurement_campaign.hpp"

/// Campaigns on a simulated KR 210 with the published errors, and how well a fit of them predicts.
namespace truepose::example {

/// An arm 4 m from the tracker, its reflector off axis 6, with the usual repeatability.
TrueArmSetup true_arm(NonGeometricErrors errors = {});

/// Readings at random poses drawn from `options.seed`.
SimulatedCampaign campaign(const TrueArmSetup& setup, int identify, int validate, CampaignOptions options);

/// Mean distance (mm) between what a cell predicts for the validation poses and where the arm truly stands
/// there.
double mean_miss(const CalibratedCell& cell, const SimulatedCampaign& campaign);
/// The same of a calibration, which must have succeeded.
double mean_miss(const std::expected<Calibration, CalibrationError>& calibration,
                 const SimulatedCampaign& campaign);

}  // namespace truepose::example
