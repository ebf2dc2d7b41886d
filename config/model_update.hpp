#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>

#include "config/model_file.hpp"
#include "core/change/drift_update.hpp"

namespace truepose::config {

/// The model of the same arm with its drives so warm, the reference from then on. Without an answer to warmth
/// the model as it is.
///
/// @param temperature_c  one a joint
ModelFile at_temperatures(ModelFile model, std::span<const double> temperature_c);

/// An updated model. The old model stays; the new one names it.
///
/// What it says of its validation is how well the points that it was updated by are predicted, each by the
/// others alone.
///
/// @param updates  the old model, by id or file
/// @param created  RFC 3339
ModelFile updated_model(const ModelFile& old, const DriftUpdate& update, std::string updates,
                        std::string created);

/// The model as another tracker sees it, or the same that was moved.
///
/// @param X_now_first  pose of the model's tracker in the frame of that one; the identity changes no digit
ModelFile seen_from(ModelFile model, const Eigen::Isometry3d& X_now_first);

}  // namespace truepose::config
