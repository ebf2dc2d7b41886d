#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

#include "config/yaml_layout.hpp"
#include "core/frames/frame_readings.hpp"

/// How YAML files say what a frame was measured by.
namespace truepose::config {

/// As many joints as an arm may have.
struct JointList {
  std::vector<double> form_of(const JointVector& q) const { return {q.begin(), q.end()}; }
  JointVector value_of(const std::vector<double>& q) const {
    return Eigen::Map<const Eigen::VectorXd>(q.data(), std::min(std::ssize(q), Eigen::Index{kMaxJoints}));
  }
  std::string_view fault(const std::vector<double>& q) const {
    return q.size() > kMaxJoints ? "more joints than an arm may have" : "";
  }
};

/// The number of a point, counted from 1 in the file.
struct PointNumber {
  int form_of(std::size_t index) const { return static_cast<int>(index) + 1; }
  std::size_t value_of(int number) const { return static_cast<std::size_t>(number - 1); }
};

constexpr Whole kFrameNumber{1, 1000};

// ---- Layouts; frames in KUKA's mm and deg, all else in mm and rad

}  // namespace truepose::config

namespace truepose::record {

using config::JointList;
using config::kFrameNumber;
using config::PointNumber;

inline void layout(Io& io, FramePoint& x) {
  io("name", x.name);
  io.optional("p", x.p_mm, kPoint);
}

inline void layout(Io& io, MeasuredOrientation& x) {
  io("axes", x.R_WT, KukaAngles{});
  io("sigma", x.sigma_rad, Degrees{}, Range{1e-9, 10});
}

inline void layout(Io& io, FrameReading& x) {
  io("point", x.point, PointNumber{}, kFrameNumber);
  io("q", x.q, JointList{});
  io.optional("seen", x.p_WS_mm, Xyz{kMm});
  io.optional("turned", x.orientation);
}

}  // namespace truepose::record

namespace truepose::config {}  // namespace truepose::config
