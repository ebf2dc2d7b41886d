#include "tools/sim/motion/tcp_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/angles.hpp"

namespace truepose::sim {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

// As fast as the path's own speed turns a metre.
constexpr double kRadius_mm = 1000;
// Points between which a curve's length is taken as that of a line.
constexpr std::size_t kTable = 128;

Vector3d normalised(const Vector3d& v) {
  return v.norm() > 1e-9 ? Vector3d{v.normalized()} : Vector3d{0, 0, 0};
}

/// The direction at the middle one of three points: of the parabola through them.
Vector3d through(const Vector3d& before, const Vector3d& at, const Vector3d& after) {
  const double a = (at - before).norm(), b = (after - at).norm();
  if (a == 0 || b == 0) return normalised(after - before);
  return normalised(b / a * (at - before) + a / b * (after - at));
}

}  // namespace

TcpPath::TcpPath(const Isometry3d& from, const Isometry3d& to)
    : from_{from}, to_{to.translation()}, turn_{turn_between(from.linear(), to.linear())} {}

TcpPath TcpPath::line(const Isometry3d& from, const Isometry3d& to) { return {from, to}; }

TcpPath TcpPath::arc(const Isometry3d& from, const Vector3d& via, const Isometry3d& to) {
  TcpPath path{from, to};
  path.bend(via);
  return path;
}

std::expected<TcpPath, std::string> TcpPath::arc(const Isometry3d& from, const Vector3d& via,
                                                 const Isometry3d& to, double angle_rad) {
  TcpPath path{from, to};
  if (!path.bend(via)) return std::unexpected("CA needs three points that are not in one line");
  path.angle_ = angle_rad;
  return path;
}

TcpPath TcpPath::curve(const Isometry3d& from, const Isometry3d& to, const Vector3d& leaving,
                       const Vector3d& arriving) {
  TcpPath path{from, to};
  const double chord_mm = (path.to_ - from.translation()).norm();
  path.leaving_ = chord_mm * leaving;
  path.arriving_ = chord_mm * arriving;
  path.covered_mm_.push_back(0);
  for (std::size_t i = 1; i <= kTable; ++i) {
    const auto at = [&](std::size_t k) { return path.on_curve(static_cast<double>(k) / kTable); };
    path.covered_mm_.push_back(path.covered_mm_.back() + (at(i) - at(i - 1)).norm());
  }
  return path;
}

double TcpPath::length_mm() const {
  const double way_mm = angle_ != 0           ? std::abs(angle_) * arm_.norm()
                        : covered_mm_.empty() ? (to_ - from_.translation()).norm()
                                              : covered_mm_.back();
  return std::max(way_mm, kRadius_mm * turn_.norm());
}

Isometry3d TcpPath::at(double share) const {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = rotation_by(share * turn_) * from_.linear();
  X.translation() = position(share);
  return X;
}

Vector3d TcpPath::position(double share) const {
  if (angle_ != 0) return centre_ + rotation_by(share * angle_ * axis_) * arm_;
  if (covered_mm_.empty()) return from_.translation() + share * (to_ - from_.translation());
  const double mm = share * covered_mm_.back();
  const auto after = std::ranges::upper_bound(covered_mm_, mm);
  if (after == covered_mm_.end()) return to_;
  const double in_between = (mm - after[-1]) / (after[0] - after[-1]);
  return on_curve((static_cast<double>(after - covered_mm_.begin() - 1) + in_between) / kTable);
}

Vector3d TcpPath::direction(double share, double into) const {
  if (!covered_mm_.empty()) return normalised(into > 0 ? leaving_ : arriving_);
  if (angle_ == 0) return normalised(to_ - from_.translation());
  return normalised(std::copysign(1.0, angle_) * axis_.cross(position(share) - centre_));
}

/// Hermite's cubic.
Vector3d TcpPath::on_curve(double u) const {
  const double v = 1 - u;
  return v * v * (1 + 2 * u) * from_.translation() + u * u * (3 - 2 * u) * to_ + u * v * v * leaving_ -
         u * u * v * arriving_;
}

/// @return whether there is a circle
bool TcpPath::bend(const Vector3d& via) {
  const Vector3d a = via - from_.translation(), b = to_ - from_.translation();
  const Vector3d normal = a.cross(b);
  if (normal.norm() <= 1e-9 * a.norm() * b.norm()) return false;
  const Vector3d to_centre =
      (a.squaredNorm() * b - b.squaredNorm() * a).cross(normal) / (2 * normal.squaredNorm());
  centre_ = from_.translation() + to_centre;
  arm_ = -to_centre;
  axis_ = normal.normalized();
  const Vector3d end = to_ - centre_;
  angle_ = std::atan2(arm_.cross(end).dot(axis_), arm_.dot(end));
  if (angle_ <= 0) angle_ += 2 * std::numbers::pi;
  return true;
}

namespace {

std::expected<TcpPath, std::string> stiff_piece(const Isometry3d& from, const SplineSegment& segment) {
  if (segment.kind == SplineSegment::Kind::Line) return TcpPath::line(from, segment.to);
  if (segment.angle_rad) return TcpPath::arc(from, *segment.via, segment.to, *segment.angle_rad);
  return TcpPath::arc(from, *segment.via, segment.to);
}

/// The direction at an end of a curve whose neighbour there is none: as a parabola would have it.
Vector3d free_end(const Vector3d& chord, const Vector3d& other_end) {
  if (other_end.isZero()) return normalised(chord);
  return normalised(2 * normalised(chord) - other_end);
}

}  // namespace

std::expected<std::vector<TcpPath>, std::string> spline_path(const Isometry3d& from,
                                                             const std::vector<SplineSegment>& segments) {
  // Lines and arcs first: curves take their directions.
  std::vector<std::optional<TcpPath>> stiff(segments.size());
  std::vector<Isometry3d> ends{from};
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (segments[i].kind != SplineSegment::Kind::Curve) {
      auto piece = stiff_piece(ends.back(), segments[i]);
      if (!piece) return std::unexpected(piece.error());
      stiff[i] = *std::move(piece);
    }
    ends.push_back(stiff[i] ? stiff[i]->at(1) : segments[i].to);
  }
  const auto point = [&](std::size_t i) -> Vector3d { return ends[i].translation(); };
  // At the beginning of segment i, where curves go through it.
  const auto direction = [&](std::size_t i) -> Vector3d {
    if (i > 0 && stiff[i - 1]) return stiff[i - 1]->arriving();
    if (i < segments.size() && stiff[i]) return stiff[i]->leaving();
    if (i == 0 || i == segments.size()) return {0, 0, 0};
    return through(point(i - 1), point(i), point(i + 1));
  };
  std::vector<TcpPath> pieces;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (stiff[i]) {
      pieces.push_back(*stiff[i]);
      continue;
    }
    const Vector3d chord = point(i + 1) - point(i);
    Vector3d leaving = direction(i), arriving = direction(i + 1);
    if (leaving.isZero()) leaving = free_end(chord, arriving);
    if (arriving.isZero()) arriving = free_end(chord, leaving);
    pieces.push_back(TcpPath::curve(ends[i], ends[i + 1], leaving, arriving));
  }
  return pieces;
}

}  // namespace truepose::sim
