#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "proto/record/frame_document.hpp"

namespace truepose::tools {

/// KUKA's numbers of a frame with their sigmas, those of turns about the outer axes; none: not measured.
std::string pose_text(const Eigen::Isometry3d& X, const Eigen::Vector3d& sigma_mm,
                      const std::optional<Eigen::Vector3d>& sigma_deg);

/// A measured tool or base for people: the frame with its sigmas, each reading, the controller's statement.
std::string frame_text(const record::FrameDocument& document);

}  // namespace truepose::tools
