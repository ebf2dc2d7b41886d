#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "core/math/dense_algebra.hpp"
#include "daemon/report/charts.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

constexpr double kPaperWidth = 480, kDrawingTop = 30, kPaperMargin = 12;
constexpr double kLeastHeight = 140, kMostHeight = 340;
constexpr double kBelowDrawing = 100;  // the base's axes, a length, and the colours

/// As seen at right angles to the plane that holds most of the wanted path, upright by one of the base's axes
/// and the wider way lying.
class PathView {
 public:
  explicit PathView(std::span<const PathDrawing> drawings) {
    look_at(positions_of(drawings.front().wanted));
    lo_ = hi_ = seen(drawings.front().wanted.front().front());
    for (const PathDrawing& drawing : drawings) {
      for (const auto* lines : {&drawing.wanted, &drawing.real}) include(positions_of(*lines));
      for (const PathMark& mark : drawing.marks) include(mark.place_mm);
    }
    const Eigen::Vector2d size = (hi_ - lo_).cwiseMax(1);
    const double width = kPaperWidth - 2 * kPaperMargin;
    height_ = std::clamp(width * size.y() / size.x(), kLeastHeight, kMostHeight);
    scale_ = std::min(width / size.x(), height_ / size.y());
  }

  double height() const { return height_; }  ///< on the paper
  double scale() const { return scale_; }    ///< of the paper's units, one mm

  /// mm to the paper.
  Eigen::Vector2d operator()(const Eigen::Vector3d& p) const {
    const Eigen::Vector2d from_middle = scale_ * (seen(p) - (lo_ + hi_) / 2);
    return {kPaperWidth / 2 + from_middle.x(), kDrawingTop + height_ / 2 - from_middle.y()};
  }
  /// Of a unit vector, as it is seen: to the right and down.
  Eigen::Vector2d direction(const Eigen::Vector3d& v) const { return {right_.dot(v), -up_.dot(v)}; }

 private:
  static std::vector<Eigen::Vector3d> positions_of(const std::vector<PathLine>& lines) {
    std::vector<Eigen::Vector3d> positions;
    for (const PathLine& line : lines) positions.insert(positions.end(), line.begin(), line.end());
    return positions;
  }

  void look_at(const std::vector<Eigen::Vector3d>& positions) {
    Eigen::Vector3d mean{0, 0, 0};
    for (const Eigen::Vector3d& p : positions) mean += p / static_cast<double>(positions.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& p : positions) scatter += (p - mean) * (p - mean).transpose();
    Eigen::Vector3d normal = thin_svd(scatter).U.col(2);
    Eigen::Index towards = 0, across = 0;
    normal.cwiseAbs().maxCoeff(&towards);
    normal.cwiseAbs().minCoeff(&across);
    if (normal[towards] < 0) normal = -normal;
    right_ = (Eigen::Vector3d::Unit(across) - normal[across] * normal).normalized();
    up_ = normal.cross(right_);
    lo_ = hi_ = seen(mean);
    include(positions);
    if (const Eigen::Vector2d size = hi_ - lo_; size.y() > size.x()) {
      std::swap(right_, up_);
      up_ = -up_;
    }
    up_.cwiseAbs().maxCoeff(&towards);
    if (up_[towards] < 0) {
      right_ = -right_;
      up_ = -up_;
    }
  }

  Eigen::Vector2d seen(const Eigen::Vector3d& p) const { return {right_.dot(p), up_.dot(p)}; }
  void include(const Eigen::Vector3d& p) {
    lo_ = lo_.cwiseMin(seen(p));
    hi_ = hi_.cwiseMax(seen(p));
  }
  void include(const std::vector<Eigen::Vector3d>& positions) {
    for (const Eigen::Vector3d& p : positions) include(p);
  }

  Eigen::Vector3d right_{1, 0, 0}, up_{0, 1, 0};
  Eigen::Vector2d lo_{0, 0}, hi_{0, 0};
  double height_ = 0, scale_ = 1;
};

void draw_lines(Plot& plot, const std::vector<PathLine>& lines, const PathView& view,
                std::string_view attributes) {
  for (const PathLine& line : lines) {
    std::vector<Eigen::Vector2d> points;
    for (const Eigen::Vector3d& p : line) points.push_back(view(p));
    plot.line(points, attributes);
  }
}

void draw_mark(Plot& plot, const PathMark& mark, const PathView& view, const ColorScale& scale) {
  const Eigen::Vector2d p = view(mark.place_mm);
  plot.put(
      R"(<circle cx="{:.1f}" cy="{:.1f}" r="4.5" fill="{}" stroke="#18232e" stroke-width="0.9"{}><title>{}</title></circle>)",
      p.x(), p.y(), mark.error_mm ? scale.color(*mark.error_mm) : "#fff",
      mark.error_mm ? "" : R"( stroke-dasharray="2 2")", xml::escaped(mark.label));
}

/// The base's axes that do not point at the reader, about as large as text.
void draw_base_axes(Plot& plot, const PathView& view, double y) {
  constexpr double kLength = 20, kSeen = 0.3;
  const Eigen::Vector2d origin{kPaperMargin + 26, y};
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector2d axis = kLength * view.direction(Eigen::Vector3d::Unit(k));
    if (axis.norm() < kSeen * kLength) continue;
    const Eigen::Vector2d end = origin + axis, name = end + 8 * axis.normalized();
    plot.line(std::vector{origin, end}, R"(class="base-axis" fill="none")");
    plot.put(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{:.1f}">{}</text>)", name.x(),
             name.y() + 4, "xyz"[k]);
  }
}

/// A round length, as long as it is on the drawing.
void draw_length(Plot& plot, const PathView& view, double y) {
  const double mm = nice_ticks(0, kPaperWidth / 3 / view.scale(), 1)[1] / 2, length = mm * view.scale();
  const double to = kPaperWidth - kPaperMargin;
  plot.put(R"(<path class="axis" d="M{:.1f} {y:.1f}v6h{:.1f}v-6"/>)", to - length, length, fmt::arg("y", y));
  plot.put(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{:.1f}">{:g} mm</text>)", to - length / 2,
           y + 22, mm);
}

ColorScale scale_of(std::span<const PathDrawing> drawings) {
  std::optional<ColorScale> scale;
  for (const PathDrawing& drawing : drawings) {
    for (const PathMark& mark : drawing.marks) {
      if (!mark.error_mm) continue;
      if (!scale) scale = {*mark.error_mm, *mark.error_mm};
      scale = {std::min(scale->lo, *mark.error_mm), std::max(scale->hi, *mark.error_mm)};
    }
  }
  return scale.value_or(ColorScale{});
}

std::string drawing_svg(const PathDrawing& drawing, const PathView& view, const ColorScale& scale) {
  const double bottom = kDrawingTop + view.height();
  Plot plot{drawing.title, kPaperWidth, bottom + kBelowDrawing};
  plot.left = kPaperMargin;
  plot.right = kPaperWidth - kPaperMargin;
  draw_lines(plot, drawing.wanted, view, R"(fill="none" stroke="#8e9aa5" stroke-width="1.2")");
  draw_lines(
      plot, drawing.real, view,
      fmt::format(R"(fill="none" stroke="{}" stroke-width="1.8" stroke-linejoin="round")", drawing.color));
  for (const PathMark& mark : drawing.marks) draw_mark(plot, mark, view, scale);
  draw_base_axes(plot, view, bottom + 38);
  draw_length(plot, view, bottom + 26);
  if (scale.hi > 0) draw_scale(plot, scale, "error at the point", bottom + 66);
  return std::move(plot).finish();
}

}  // namespace

std::string path_drawings_svg(std::span<const PathDrawing> drawings) {
  const PathView view{drawings};
  const ColorScale scale = scale_of(drawings);
  std::string svgs;
  for (const PathDrawing& drawing : drawings) svgs += drawing_svg(drawing, view, scale);
  return svgs;
}

}  // namespace truepose::report
