#pragma once

#include <Eigen/Geometry>
#include <array>
#include <boost/json/object.hpp>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "core/frames/frame_readings.hpp"
#include "core/named.hpp"
#include "proto/record/layout.hpp"

namespace truepose::record {

enum class FrameKind {
  Tool,  ///< the TCP in the flange
  Base,  ///< a work frame in the robot base
};
inline constexpr std::array kFrameKinds{Named{"tool", FrameKind::Tool}, Named{"base", FrameKind::Base}};

/// The document of `truepose tool --json`, of `truepose base --json`, and of the campaigns that measure the
/// same. mm and deg.
struct FrameDocument {
  struct Reading {
    int row = 0;        ///< of the file of readings, from 1
    std::string point;  ///< its name
    double error_mm = 0;
    std::optional<double> orientation_error_deg{};  ///< of a 6-D target
  };
  struct Point {
    std::string name;
    std::optional<Eigen::Vector3d> p_mm;  ///< its coordinates in the frame, where they were stated
    std::optional<double> residual_mm;    ///< from where those have it
  };

  struct Shift {
    Eigen::Vector3d p_mm;  ///< robot base frame
    Eigen::Vector3d sigma_mm;
    bool significant;  ///< more than chance: the frame is not to be used
  };

  FrameKind kind = FrameKind::Tool;
  int number = 1;                                       ///< of TOOL_DATA or BASE_DATA
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  ///< rounded to the digits of KUKA's display
  Eigen::Vector3d sigma_mm{0, 0, 0};
  std::optional<Eigen::Vector3d> sigma_deg;  ///< of turns about the outer axes; none: not measured
  std::optional<double> sigma0;              ///< scatter in multiples of the noise; none: no reading is spare
  std::vector<Reading> readings;
  std::vector<Point> points;
  std::vector<int> outliers;  ///< rows that the others contradict; with one the frame is not to be used
  /// Of a tool: how far base or tracker stand from where the model has them; none: the readings do not tell.
  std::optional<Shift> base_shift;
  /// Of a base: number of the tool whose TCP touched its points; none: the tracker read them, or the tool has
  /// no number.
  std::optional<int> touched_by{};
  std::vector<std::string> notes;
  std::string krl;   ///< statement for the controller
  std::string yaml;  ///< its file, of a frame that a campaign has measured; else empty
};
void layout(Io& io, FrameDocument& x);

/// The document of a measured frame.
/// @param X_controller  rounded to the digits of KUKA's display
/// @param by      how it was measured
FrameDocument frame_document_of(FrameKind kind, int number, const FrameReadings& data,
                                const MeasuredFrame& frame, const Eigen::Isometry3d& X_controller,
                                const MeasuringCell& by);

boost::json::object frame_document(const FrameDocument& document);
/// @return the document, or one sentence that names the member
std::expected<FrameDocument, std::string> read_frame_document(const boost::json::value& document);

/// The KRL statement that sets a tool.
std::string tool_statement(int number, const Eigen::Isometry3d& X_controller);

/// Why the frame is not to be used: rows that the others contradict, or a model that they do. Empty where it
/// is.
std::string why_not_usable(const FrameDocument& document);

}  // namespace truepose::record
