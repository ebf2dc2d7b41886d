#pragma once

#include <Eigen/Geometry>
#include <boost/json/object.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/frames/positioner.hpp"
#include "proto/record/frame_document.hpp"

namespace truepose::record {

/// The document of `truepose positioner --json`. mm and deg, in the robot's base.
struct PositionerDocument {
  /// Where an axis truly is with all joints at zero.
  struct Axis {
    int joint = 1;  ///< from 1
    Eigen::Vector3d p_mm, direction;
  };
  /// What the table's readings show of its links.
  struct Link {
    std::string name, unit;  ///< "link2.a", "mm"
    double nominal = 0, value = 0, sigma = 0;
  };

  int number = 2;                                          ///< of MACHINE_DEF
  Eigen::Isometry3d X_BR = Eigen::Isometry3d::Identity();  ///< ROOT, rounded to the digits of KUKA's display
  Eigen::Vector3d sigma_mm{0, 0, 0}, sigma_deg{0, 0, 0};   ///< of turns about the axes of the base
  std::vector<Axis> axes;
  std::vector<Link> links;
  std::vector<std::string> notes;
  std::string krl;                         ///< statement for the controller
  std::optional<FrameDocument> workpiece;  ///< on the table by its nominal chain, as BASE_DATA has it
};

/// @param X_controller  the root, rounded to the digits of KUKA's display
/// @param parameters  of the table's model
/// @param X_given     root where the controller has it, if that was said
PositionerDocument positioner_document_of(int number, const PositionerRoot& root,
                                          const Eigen::Isometry3d& X_controller, const MeasuringCell& arm,
                                          const MeasuringCell& table,
                                          const std::vector<IdentifiedParameter>& parameters,
                                          const std::optional<Eigen::Isometry3d>& X_given);

boost::json::object positioner_document(const PositionerDocument& document);

}  // namespace truepose::record
