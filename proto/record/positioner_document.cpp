#include "proto/record/positioner_document.hpp"

#include "core/arm/forward.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "proto/krl/frame_data.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::record {

void layout(Io& io, PositionerDocument::Axis& x) {
  io("joint", x.joint, kNumber);
  io("point", x.p_mm, kPoint);
  io("direction", x.direction, Xyz{});
}
void layout(Io& io, PositionerDocument::Link& x) {
  io("name", x.name);
  io("unit", x.unit);
  io("nominal", x.nominal);
  io("value", x.value);
  io("sigma", x.sigma, kNotNegative);
}
void layout(Io& io, PositionerDocument& x) {
  io("number", x.number, kNumber);
  io("root", x.X_BR, KukaPose{});
  io("sigma_mm", x.sigma_mm);
  io("sigma_deg", x.sigma_deg);
  io("axes", x.axes);
  io("links", x.links);
  io("notes", x.notes);
  io("krl", x.krl);
}

namespace {

std::vector<PositionerDocument::Axis> axes_of(const MeasuringCell& arm, const MeasuringCell& table) {
  LinkFrames X_R;
  link_frames(table.cell.robot, JointVector::Zero(table.cell.robot.joint_count()), X_R);
  const Eigen::Isometry3d X_BR = inverse_of(arm.cell.base.isometry()) * table.cell.base.isometry();
  std::vector<PositionerDocument::Axis> axes;
  for (int joint = 1; joint <= table.cell.robot.joint_count(); ++joint) {
    const Eigen::Isometry3d X_B = X_BR * X_R[static_cast<std::size_t>(joint)];
    const double sign = table.cell.robot.joints[static_cast<std::size_t>(joint - 1)].sign;
    axes.push_back({joint, X_B.translation(), sign * X_B.linear().col(2)});
  }
  return axes;
}

std::vector<PositionerDocument::Link> links_of(const std::vector<IdentifiedParameter>& parameters) {
  std::vector<PositionerDocument::Link> links;
  for (const IdentifiedParameter& known : parameters) {
    if (!known.identified || !known.name.starts_with("link")) continue;
    const bool length = known.name.ends_with(".a") || known.name.ends_with(".d");
    const double unit = length ? 1 : kDegPerRad;
    links.push_back(
        {known.name, length ? "mm" : "deg", unit * known.nominal, unit * known.value, unit * known.sigma});
  }
  return links;
}

/// That the root is so far from where it was given that something else may have been measured; empty where it
/// is not.
std::string distance_note(const Eigen::Isometry3d& X_BR, const Eigen::Isometry3d& X_given) {
  constexpr double kFar_mm = 50, kFar_rad = 3 * kRadPerDeg;
  const double far_mm = (X_BR.translation() - X_given.translation()).norm();
  const double turned_rad = angle_between(X_given.linear(), X_BR.linear());
  if (far_mm < kFar_mm && turned_rad < kFar_rad) return {};
  return formatted(
      "The root is %.0f mm and %.1f deg from where --root has it: were arm and table measured from one and the same "
      "station of the tracker, and is that the root of this positioner?",
      far_mm, turned_rad * kDegPerRad);
}

}  // namespace

PositionerDocument positioner_document_of(int number, const PositionerRoot& root,
                                          const Eigen::Isometry3d& X_controller, const MeasuringCell& arm,
                                          const MeasuringCell& table,
                                          const std::vector<IdentifiedParameter>& parameters,
                                          const std::optional<Eigen::Isometry3d>& X_given) {
  const Eigen::Matrix<double, 6, 1> sigmas = root.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  PositionerDocument document{.number = number,
                              .X_BR = X_controller,
                              .sigma_mm = sigmas.head<3>(),
                              .sigma_deg = kDegPerRad * sigmas.tail<3>(),
                              .axes = axes_of(arm, table),
                              .links = links_of(parameters),
                              .krl = krl::frame_statement("MACHINE_DEF", number, X_controller, ".ROOT")};
  if (table.cell.robot.joint_count() == 1)
    document.notes.push_back(
        std::string("No reading shows the root's turn about the axis and its place along it: it is ") +
        (X_given ? "as --root has it."
                 : "as near to the robot's base as may be; --root says where the controller has it."));
  if (X_given)
    if (const std::string note = distance_note(X_controller, *X_given); !note.empty())
      document.notes.push_back(note);
  if (arm.covariance.size() == 0 || table.covariance.size() == 0)
    document.notes.push_back("A model has no covariance, so sigma is too small; calibrate again to have it.");
  return document;
}

boost::json::object positioner_document(const PositionerDocument& document) {
  boost::json::object json = to_json(document);
  if (document.workpiece) json["workpiece"] = frame_document(*document.workpiece);
  return json;
}

}  // namespace truepose::record
