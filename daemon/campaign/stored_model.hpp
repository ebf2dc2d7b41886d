#pragma once

#include <expected>
#include <span>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "config/model_file.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/plan/scene.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

/// A stored model that may be worked with.
struct StoredModel {
  config::ModelFile file;
  std::string unchecked;  ///< what could not be checked and why, one sentence; empty: all was
};

/// The poses that a model has to be right at: those that it was identified and validated from.
std::vector<JointVector> poses_of_task(std::span<const StoredPoint> points);

/// A stored model with the hash that it was stored with.
/// @return or one sentence: which model, what is wrong with its text, and what to do
std::expected<config::ModelFile, std::string> unaltered_model(const ModelRecord& record);

/// Whether a stored model still is the one that was made. A disk may give back other bits, a backup other
/// rows, and a person may have edited it: one digit can lead an arm wrong by hundreds of millimetres. So
/// - its text has the hash that it was stored with,
/// - its own validation points give the validation error that it was made with (config::other_error()), and
/// - it corrects no joint at the poses that it was made from by more than it did then
///   (config::larger_correction()).
///
/// Models that were stored before they carried the hash and the correction are judged by their points alone.
///
/// @param points  of the campaign that made it
/// @return or one sentence: which model, what disagrees, and what to do
std::expected<StoredModel, std::string> checked_model(const ModelRecord& record,
                                                      std::span<const StoredPoint> points,
                                                      const config::CellConfig& config);

/// The nominal arm where an active model says that the base and the reflector are: what targets refer to.
CalibratedCell known_cell(const config::CellConfig& config, const CalibratedCell& model);

/// The joints at which the model's arm stands where the nominal one would at q. Next to the wrist singularity
/// the reflector's position is kept: it is what will be measured.
/// @param directions  in which each joint comes there: -1, 1; 0 or empty: not known
TargetCompensation::Result compensated(const JointVector& q, const std::vector<std::int8_t>& directions,
                                       const config::CellConfig& config, const CalibratedCell& model);

/// What poses that a user asks for are judged by: the placement is known, and no margins are kept.
Scene known_scene(const config::CellConfig& config, const CalibratedCell& model);

}  // namespace truepose::daemon
