#include "tools/report/error_cloud.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/math/statistics.hpp"
#include "proto/xml/escape.hpp"
#include "tools/report/svg_chart.hpp"

namespace truepose::report {
namespace {

constexpr double kCloudWidth = 480, kCloudHeight = 360;
constexpr double kCloudTop = 28;     // below the title
constexpr double kCloudMargin = 12;  // around the cloud
// Of the cloud's size: few arrows may be long, many would hide each other.
constexpr double kCrowd = 0.8, kMedianPart = 0.12;

/// The box that a view shows: all places, the robot's base, and the floor up to whole squares of its grid.
struct Box {
  Eigen::Vector3d lo{0, 0, 0}, hi{0, 0, 0};
  double grid_mm = 1;

  explicit Box(const std::vector<CloudArrow>& arrows) {
    for (const CloudArrow& arrow : arrows) {
      lo = lo.cwiseMin(arrow.place);
      hi = hi.cwiseMax(arrow.place);
    }
    grid_mm = nice_ticks(0, std::max((hi - lo).head<2>().maxCoeff(), 1.0), 6)[1];
    lo.head<2>() = (lo.head<2>() / grid_mm).array().floor() * grid_mm;
    hi.head<2>() = (hi.head<2>() / grid_mm).array().ceil() * grid_mm;
  }
  double size() const { return std::max((hi - lo).norm(), 1.0); }
};

/// Parallel projection: mm of the base frame to the paper, as large as the places, the floor and the base
/// fit.
class Projection {
 public:
  Projection(const Box& box, const std::vector<CloudArrow>& arrows, double azimuth, double elevation)
      : right_{-std::sin(azimuth), std::cos(azimuth), 0},
        up_{-std::sin(elevation) * std::cos(azimuth), -std::sin(elevation) * std::sin(azimuth),
            std::cos(elevation)} {
    Eigen::Vector2d lo{0, 0}, hi{0, 0};
    const auto include = [&](const Eigen::Vector3d& p) {
      const Eigen::Vector2d seen{right_.dot(p), up_.dot(p)};
      lo = lo.cwiseMin(seen);
      hi = hi.cwiseMax(seen);
    };
    for (const double x : {box.lo.x(), box.hi.x()}) {
      for (const double y : {box.lo.y(), box.hi.y()}) include({x, y, 0});
    }
    for (const CloudArrow& arrow : arrows) include(arrow.place);
    const Eigen::Vector2d middle = (lo + hi) / 2, size = (hi - lo).cwiseMax(1);
    const Eigen::Vector3d inside = (box.lo + box.hi) / 2;  // what the cloud turns about
    center_ = inside + (middle.x() - right_.dot(inside)) * right_ + (middle.y() - up_.dot(inside)) * up_;
    scale_ = std::min((kCloudWidth - 2 * kCloudMargin) / size.x(),
                      (kCloudHeight - kCloudTop - 2 * kCloudMargin) / size.y());
  }

  Eigen::Vector2d operator()(const Eigen::Vector3d& p) const {
    return {kMiddleX + scale_ * right_.dot(p - center_), kMiddleY - scale_ * up_.dot(p - center_)};
  }

  const Eigen::Vector3d& center() const { return center_; }
  double scale() const { return scale_; }

  static constexpr double kMiddleX = kCloudWidth / 2, kMiddleY = (kCloudHeight + kCloudTop) / 2;

 private:
  Eigen::Vector3d center_, right_, up_;
  double scale_ = 1;
};

class Scene {
 public:
  Scene(const Cloud& cloud, const CloudView& view)
      : box_{cloud.arrows}, project_{box_, cloud.arrows, view.azimuth_rad, view.elevation_rad} {
    const Eigen::Vector3d& c = project_.center();
    put(R"(<svg xmlns="http://www.w3.org/2000/svg" class="chart cloud-view{}" viewBox="0 0 {} {}" role="img" )"
        R"(aria-label="{}" data-azimuth="{:.4f}" data-elevation="{:.4f}" data-scale="{:.6f}" )"
        R"(data-center="{:.1f} {:.1f} {:.1f}" data-middle="{:.1f} {:.1f}">)",
        view.turns ? " turns" : "", kCloudWidth, kCloudHeight, xml::escaped(view.title), view.azimuth_rad,
        view.elevation_rad, project_.scale(), c.x(), c.y(), c.z(), Projection::kMiddleX,
        Projection::kMiddleY);
    put(R"(<defs><marker id="{}" viewBox="0 0 6 6" refX="4" refY="3" markerWidth="3.6" markerHeight="3.6" )"
        R"(orient="auto"><path d="M0 0L6 3L0 6z" fill="{}"/></marker></defs>)",
        view.id, view.color);
    put(R"(<text class="chart-title" x="0" y="14">{}</text>)", xml::escaped(view.title));
  }

  void floor() {
    const double step = box_.grid_mm;
    const Eigen::Vector3d &from = box_.lo, &to = box_.hi;
    for (double x = from.x(); x < to.x() + step / 2; x += step)
      line("grid", {x, from.y(), 0}, {x, to.y(), 0});
    for (double y = from.y(); y < to.y() + step / 2; y += step)
      line("grid", {from.x(), y, 0}, {to.x(), y, 0});
    put(R"(<text class="tick" text-anchor="end" x="{}" y="14">grid {:g} m</text>)", kCloudWidth, step / 1000);
  }

  void base() {
    const double length = 0.12 * box_.size();
    static constexpr const char* kNames[] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d end = length * Eigen::Vector3d::Unit(k);
      line("base-axis", Eigen::Vector3d::Zero(), end);
      text(kNames[k], 1.18 * end);
    }
    const Eigen::Vector2d p = project_(Eigen::Vector3d::Zero());
    put(R"(<circle class="base" data-p="0 0 0" cx="{:.1f}" cy="{:.1f}" r="4"><title>Robot base</title></circle>)",
        p.x(), p.y());
  }

  /// Its beam from the base, as far as the paper goes, and its name where it stands or the beam leaves.
  void tracker(const Eigen::Vector3d& place) {
    line("beam", Eigen::Vector3d::Zero(), place);
    const Eigen::Vector2d p = project_(place), start = project_(Eigen::Vector3d::Zero());
    put(R"(<rect class="tracker" data-p="{}" x="{:.1f}" y="{:.1f}" width="8" height="8"/>)", numbers(place),
        p.x() - 4, p.y() - 4);
    double part = 1;
    const Eigen::Vector2d lo{50, kCloudTop + 14}, hi{kCloudWidth - 50, kCloudHeight - 10};
    for (int k = 0; k < 2; ++k) {
      if (p[k] > hi[k]) part = std::min(part, (hi[k] - start[k]) / (p[k] - start[k]));
      if (p[k] < lo[k]) part = std::min(part, (lo[k] - start[k]) / (p[k] - start[k]));
    }
    const Eigen::Vector2d at = start + std::max(part, 0.0) * (p - start);
    put(R"(<text class="legend tracker-name" text-anchor="middle" data-p="{}" data-from="0 0 0" x="{:.1f}" y="{:.1f}">)"
        R"(tracker, {:.1f} m</text>)",
        numbers(place), at.x(), at.y() - 8, place.norm() / 1000);
  }

  void arrows(const Cloud& cloud, const CloudView& view) {
    put(R"(<g stroke="{}" stroke-width="1.4">)", view.color);
    for (const CloudArrow& arrow : cloud.arrows) {
      const Eigen::Vector3d end = arrow.place + cloud.exaggeration * arrow.error;
      put("<line class=\"arrow\" marker-end=\"url(#{})\" {}><title>{}</title></line>", view.id,
          ends(arrow.place, end), xml::escaped(arrow.label));
    }
    put("</g>");
  }

  std::string finish() && { return std::move(svg_) + "</svg>\n"; }

 private:
  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
  }

  static std::string numbers(const Eigen::Vector3d& p) {
    return fmt::format("{:.0f} {:.0f} {:.0f}", p.x(), p.y(), p.z());
  }

  std::string ends(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
    const Eigen::Vector2d p = project_(from), q = project_(to);
    return fmt::format(R"(data-p="{}" data-q="{}" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}")",
                       numbers(from), numbers(to), p.x(), p.y(), q.x(), q.y());
  }

  void line(std::string_view kind, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    put("<line class=\"{}\" {}/>", kind, ends(from, to));
  }

  void text(std::string_view name, const Eigen::Vector3d& place) {
    const Eigen::Vector2d p = project_(place);
    put(R"(<text class="tick" text-anchor="middle" dy="4" data-p="{}" x="{:.1f}" y="{:.1f}">{}</text>)",
        numbers(place), p.x(), p.y(), name);
  }

  Box box_;
  Projection project_;
  std::string svg_;
};

}  // namespace

double exaggeration_of(const std::vector<CloudArrow>& arrows) {
  std::vector<double> lengths;
  for (const CloudArrow& arrow : arrows) lengths.push_back(arrow.error.norm());
  // The median, so that gross errors leave the picture rather than shrink it.
  const double usual = median(lengths);
  if (!(usual > 0)) return 1;
  const double part = std::min(kMedianPart, kCrowd / std::sqrt(static_cast<double>(arrows.size())));
  const double wanted = Box{arrows}.size() * part / usual;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * decade <= wanted) return factor * decade;
  }
  return decade;
}

std::string cloud_svg(const Cloud& cloud, const CloudView& view) {
  Scene scene{cloud, view};
  scene.floor();
  scene.tracker(cloud.tracker_mm);
  scene.base();
  scene.arrows(cloud, view);
  return std::move(scene).finish();
}

}  // namespace truepose::report
