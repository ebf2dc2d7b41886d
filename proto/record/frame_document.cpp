#include "proto/record/frame_document.hpp"

#include <algorithm>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/fit/orientation_spread.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "proto/krl/frame_data.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::record {

void layout(Io& io, FrameDocument::Reading& x) {
  io.about("In the order of measuring, from 1, as in the exported file")("row", x.row, kCount);
  io("point", x.point);
  io.about("From where all together say")("error_mm", x.error_mm, kNotNegative);
  io.about("The same of its orientation, of a 6-D target")
      .optional("orientation_error_deg", x.orientation_error_deg, kNotNegative);
}
void layout(Io& io, FrameDocument::Point& x) {
  io("name", x.name);
  io.about("Its coordinates in the frame, where they were stated").optional("p", x.p_mm, kPoint);
  io.about("From where those have it").optional("residual_mm", x.residual_mm, kNotNegative);
}
void layout(Io& io, FrameDocument::Shift& x) {
  io.about("Robot base frame")("p", x.p_mm, kPoint);
  io.about("Of x, y, z")("sigma_mm", x.sigma_mm);
  io.about("More than chance: the frame cannot be used")("significant", x.significant);
}
void layout(Io& io, FrameDocument& x) {
  io.record("FrameDocument",
            "What `truepose tool --json` and `truepose base --json` print, and the file of tool or base. "
            "mm and deg");
  io("kind", x.kind, kFrameKinds);
  io.about("In TOOL_DATA or BASE_DATA")("number", x.number, kNumber);
  io.about("In the flange, or in the robot base; KUKA's angles")("frame", x.X, KukaPose{});
  io.about("Of x, y, z")("sigma_mm", x.sigma_mm);
  io.about("Of turns about the axes of flange or base; left out where the orientation was not measured")
      .optional("sigma_deg", x.sigma_deg);
  io.about("Scatter of the readings in multiples of their noise; left out where none is spare")
      .optional("sigma0", x.sigma0, kNotNegative);
  io("readings", x.readings);
  io("points", x.points);
  io.about("Rows that the others contradict; with one the frame cannot be used")("outliers", x.outliers);
  io.about(
        "Of a tool: how far base or tracker stand from where the model has them; left out where the "
        "readings do not show it")
      .optional("base_shift", x.base_shift);
  io.about(
        "Of a base: number of the tool that touched its points with its TCP; left out where the tracker "
        "read them")
      .optional("touched_by", x.touched_by, kNumber);
  io("notes", x.notes);
  io.about("Statement for the controller")("krl", x.krl);
  io.about("Its file; left out where it cannot be used").optional("yaml", x.yaml);
}

namespace {

/// What the orientations in which a tool was measured leave in its TCP; empty where they differ enough.
std::string orientation_note(const FrameReadings& data, const RobotModel& robot) {
  constexpr double kEnough_rad = 15 * kRadPerDeg;
  std::vector<Eigen::Matrix3d> turns;
  for (const FrameReading& reading : data.readings)
    turns.push_back(forward_kinematics(robot, reading.q).linear());
  const OrientationSpread spread = orientation_spread(turns);
  if (spread.tilt_rad >= kEnough_rad) return {};
  return formatted(
      "The orientations tilt the flange's direction (%.2f %.2f %.2f) by %.1f deg only: what arm and base err along "
      "it stays in the TCP. Tilt the tool by 30 deg or more to several sides.",
      spread.stiff_F.x(), spread.stiff_F.y(), spread.stiff_F.z(), spread.tilt_rad * kDegPerRad);
}

/// Whether the readings would show that base or tracker have moved since the model was made; empty where they
/// would.
std::string shift_note(const std::optional<BaseShift>& shift) {
  constexpr double kLittle_mm = 0.5;
  if (!shift)
    return "The readings do not show whether base or tracker have moved since the model was made: check the drift "
           "before the reflector is moved.";
  if (shift->unseen_mm() < kLittle_mm) return {};
  return formatted(
      "Base or tracker may have moved by %.1f mm since the model was made without a trace in the readings: check the "
      "drift before the reflector is moved.",
      shift->unseen_mm());
}

/// That the arm is not what its model has it to be; empty where it may be.
std::string scatter_note(const std::optional<double>& sigma0) {
  constexpr double kFar = 5;
  if (!sigma0 || *sigma0 < kFar) return {};
  return formatted(
      "The readings scatter %.0f times as far as their noise, so the arm differs from its model: check "
      "the drift, or calibrate it with reflectors at several places of the flange.",
      *sigma0);
}

}  // namespace

FrameDocument frame_document_of(FrameKind kind, int number, const FrameReadings& data,
                                const MeasuredFrame& frame, const Eigen::Isometry3d& X_controller,
                                const MeasuringCell& by) {
  const Eigen::Matrix<double, 6, 1> sigmas = frame.covariance.diagonal().cwiseSqrt();
  FrameDocument document{
      .kind = kind,
      .number = number,
      .X = X_controller,
      .sigma_mm = sigmas.head<3>(),
      .sigma0 = frame.sigma0,
      .krl = krl::frame_statement(kind == FrameKind::Tool ? "TOOL_DATA" : "BASE_DATA", number, X_controller)};
  if (frame.is_orientation_known) document.sigma_deg = kDegPerRad * sigmas.tail<3>();
  for (std::size_t i = 0; i < data.readings.size(); ++i) {
    document.readings.push_back(
        {data.readings[i].row, data.points[data.readings[i].point].name, frame.error_mm[i]});
    if (!frame.turn_error_rad.empty())
      document.readings.back().orientation_error_deg = frame.turn_error_rad[i] * kDegPerRad;
  }
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    document.points.push_back({data.points[i].name, data.points[i].p_mm, std::nullopt});
    if (!frame.misfit_mm.empty()) document.points.back().residual_mm = frame.misfit_mm[i];
  }
  for (const std::size_t i : frame.doubtful) document.outliers.push_back(data.readings[i].row);
  if (frame.shift)
    document.base_shift = {frame.shift->p_B_mm, frame.shift->covariance.diagonal().cwiseSqrt(),
                           frame.shift->is_real()};
  if (by.covariance.size() == 0)
    document.notes.push_back(
        "The model has no covariance, so sigma is of the readings alone; calibrate again to have it.");
  if (!frame.is_orientation_known)
    document.notes.push_back("A, B, C were not measured, but taken as given (--orientation).");
  if (kind == FrameKind::Tool)
    if (const std::string note = orientation_note(data, by.cell.robot); !note.empty())
      document.notes.push_back(note);
  const bool is_explained = !frame.doubtful.empty() || (frame.shift && frame.shift->is_real());
  if (is_explained || !frame.is_contradictory())
    if (const std::string note = scatter_note(frame.sigma0); !note.empty()) document.notes.push_back(note);
  if (frame.coordinates_off_mm > 0)
    document.notes.push_back(
        formatted("The points are not where their stated coordinates have them, by more than the "
                  "readings scatter: sigma takes these as wrong by %.3f mm.",
                  frame.coordinates_off_mm));
  const bool seen = std::ranges::any_of(
      data.readings, [](const FrameReading& reading) { return reading.p_WS_mm.has_value(); });
  if (kind == FrameKind::Tool && seen)
    if (const std::string note = shift_note(frame.shift); !note.empty()) document.notes.push_back(note);
  return document;
}

boost::json::object frame_document(const FrameDocument& document) { return to_json(document); }

std::expected<FrameDocument, std::string> read_frame_document(const boost::json::value& document) {
  return from_json<FrameDocument>(document);
}

std::string tool_statement(int number, const Eigen::Isometry3d& X_controller) {
  return krl::frame_statement("TOOL_DATA", number, X_controller);
}

std::string why_not_usable(const FrameDocument& document) {
  const auto& shift = document.base_shift;
  if (shift && shift->significant) {
    // The only base that is measured as a tool is, on a table that turns it, is a positioner's workpiece.
    const bool on_table = document.kind == FrameKind::Base;
    return formatted(
        "the %s or the tracker stands %.2f mm from where the model has it (standard deviation %.2f mm): %s",
        on_table ? "positioner's root" : "robot's base", shift->p_mm.norm(), shift->sigma_mm.norm(),
        on_table ? "calibrate the positioner again, then measure the workpiece from the same station"
                 : "check the drift, make a model of today, then measure the tool again");
  }
  if (document.outliers.empty()) {
    std::vector<double> error_mm;
    for (const FrameDocument::Reading& reading : document.readings) error_mm.push_back(reading.error_mm);
    if (contradict(error_mm, document.sigma0))
      return formatted(
          "the readings scatter %.0f times as far as their noise: they do not belong together, or not to this model; look "
          "for rows out of step, swapped columns, other units, or a reflector or tracker that moved meanwhile",
          document.sigma0.value_or(0));
    return {};
  }
  std::string rows;
  for (const int row : document.outliers) rows += (rows.empty() ? "row " : ", ") + std::to_string(row);
  return rows +
         ": more than five standard deviations from where the other rows say; measure again, or leave the row "
         "out";
}

}  // namespace truepose::record
