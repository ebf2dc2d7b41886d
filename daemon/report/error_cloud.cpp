#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "daemon/report/charts.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

constexpr double kWidth = 480, kHeight = 360;
constexpr double kTop = 28;     // below the title
constexpr double kMargin = 12;  // around the cloud
constexpr double kMiddleX = kWidth / 2, kMiddleY = (kHeight + kTop) / 2;
// Of the cloud's size: few arrows may be long, many would hide each other.
constexpr double kCrowd = 0.8, kMedianPart = 0.12;
// More arrows hide each other, and make the page heavy.
constexpr std::size_t kMostArrows = 250;

/// The box that a view shows: all places, the robot's base, and the floor up to whole squares of its grid.
struct Workspace {
  Eigen::Vector3d lo{0, 0, 0}, hi{0, 0, 0};
  double grid_mm = 1;

  explicit Workspace(const std::vector<CloudArrow>& arrows) {
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
struct Projection {
  double azimuth, elevation;
  Eigen::Vector3d right{-std::sin(azimuth), std::cos(azimuth), 0};
  Eigen::Vector3d up{-std::sin(elevation) * std::cos(azimuth), -std::sin(elevation) * std::sin(azimuth),
                     std::cos(elevation)};
  Eigen::Vector3d center{0, 0, 0};
  double scale = 1;

  void fit(const Workspace& box, const std::vector<CloudArrow>& arrows) {
    Eigen::Vector2d lo{0, 0}, hi{0, 0};
    const auto include = [&](const Eigen::Vector3d& p) {
      const Eigen::Vector2d seen{right.dot(p), up.dot(p)};
      lo = lo.cwiseMin(seen);
      hi = hi.cwiseMax(seen);
    };
    for (const double x : {box.lo.x(), box.hi.x()}) {
      for (const double y : {box.lo.y(), box.hi.y()}) include({x, y, 0});
    }
    for (const CloudArrow& arrow : arrows) include(arrow.place);
    const Eigen::Vector2d middle = (lo + hi) / 2, size = (hi - lo).cwiseMax(1);
    const Eigen::Vector3d inside = (box.lo + box.hi) / 2;  // what the cloud turns about
    center = inside + (middle.x() - right.dot(inside)) * right + (middle.y() - up.dot(inside)) * up;
    scale = std::min((kWidth - 2 * kMargin) / size.x(), (kHeight - kTop - 2 * kMargin) / size.y());
  }

  Eigen::Vector2d operator()(const Eigen::Vector3d& p) const {
    return {kMiddleX + scale * right.dot(p - center), kMiddleY - scale * up.dot(p - center)};
  }

  /// How the script has to look at the cloud.
  std::string attributes() const {
    return fmt::format(R"( data-azimuth="{:.4f}" data-elevation="{:.4f}" data-scale="{:.6f}" )"
                       R"(data-center="{:.1f} {:.1f} {:.1f}" data-middle="{:.1f} {:.1f}")",
                       azimuth, elevation, scale, center.x(), center.y(), center.z(), kMiddleX, kMiddleY);
  }
};

/// What a view is drawn on. The script finds the places of what it moves as data-p and data-q (mm).
struct Scene {
  Plot& plot;
  const Projection& project;

  static std::string numbers(const Eigen::Vector3d& p) {
    return fmt::format("{:.0f} {:.0f} {:.0f}", p.x(), p.y(), p.z());
  }

  /// Left open for a title.
  void line(std::string_view attributes, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const Eigen::Vector2d p = project(from), q = project(to);
    plot.put(R"(<line {} data-p="{}" data-q="{}" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}")",
             attributes, numbers(from), numbers(to), p.x(), p.y(), q.x(), q.y());
  }

  void floor(const Workspace& box) {
    const double step = box.grid_mm;
    const Eigen::Vector3d &from = box.lo, &to = box.hi;
    const auto grid = [this](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
      line(R"(class="grid")", a, b);
      plot.put("/>");
    };
    for (double x = from.x(); x < to.x() + step / 2; x += step) grid({x, from.y(), 0}, {x, to.y(), 0});
    for (double y = from.y(); y < to.y() + step / 2; y += step) grid({from.x(), y, 0}, {to.x(), y, 0});
    plot.put(R"(<text class="tick" text-anchor="end" x="{}" y="14">grid {:g} m</text>)", kWidth, step / 1000);
  }

  void base(double length) {
    const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d end = length * Eigen::Vector3d::Unit(k), beyond = 1.18 * end;
      line(R"(class="base-axis")", origin, end);
      const Eigen::Vector2d p = project(beyond);
      plot.put(
          R"(/><text class="tick" text-anchor="middle" dy="4" data-p="{}" x="{:.1f}" y="{:.1f}">{}</text>)",
          numbers(beyond), p.x(), p.y(), "xyz"[k]);
    }
    const Eigen::Vector2d p = project(origin);
    plot.put(
        R"(<circle class="base" data-p="0 0 0" cx="{:.1f}" cy="{:.1f}" r="4"><title>Robot base</title></circle>)",
        p.x(), p.y());
  }

  /// Its beam from the base, as far as the paper goes, and its name where it stands or the beam leaves.
  void tracker(const Eigen::Vector3d& place) {
    line(R"(class="beam")", Eigen::Vector3d::Zero(), place);
    const Eigen::Vector2d p = project(place), start = project(Eigen::Vector3d::Zero());
    plot.put(R"(/><rect class="tracker" data-p="{}" x="{:.1f}" y="{:.1f}" width="8" height="8"/>)",
             numbers(place), p.x() - 4, p.y() - 4);
    double part = 1;
    const Eigen::Vector2d lo{50, kTop + 14}, hi{kWidth - 50, kHeight - 10};
    for (int k = 0; k < 2; ++k) {
      if (p[k] > hi[k]) part = std::min(part, (hi[k] - start[k]) / (p[k] - start[k]));
      if (p[k] < lo[k]) part = std::min(part, (lo[k] - start[k]) / (p[k] - start[k]));
    }
    const Eigen::Vector2d at = start + std::max(part, 0.0) * (p - start);
    plot.put(
        R"(<text class="legend tracker-name" text-anchor="middle" data-p="{}" data-from="0 0 0" x="{:.1f}" y="{:.1f}">)"
        R"(tracker, {:.1f} m</text>)",
        numbers(place), at.x(), at.y() - 8, place.norm() / 1000);
  }
};

/// Every k-th point, so that at most so many are left.
std::vector<Point> thinned(const std::vector<Point>& points) {
  const std::size_t step = (points.size() + kMostArrows - 1) / kMostArrows;
  std::vector<Point> result;
  for (std::size_t i = 0; i < points.size(); i += std::max<std::size_t>(step, 1)) result.push_back(points[i]);
  return result;
}

/// The settings of the switch, each with its cloud.
using Panels = std::vector<std::pair<std::string_view, Cloud>>;

Panels panels_of(const ReportDocument& document, const std::vector<Point>& points) {
  const Eigen::Isometry3d X_BW = document.X_WB->inverse();
  Cloud before{.color = kBeforeColor, .arrows = {}, .tracker_mm = X_BW.translation()}, after = before;
  after.color = stages_of(document, document.judging()).back().color;
  for (const Point& p : points) {
    const auto add = [&](Cloud& cloud, const Eigen::Vector3d& error) {
      cloud.arrows.push_back(
          {X_BW * *p.position, X_BW.linear() * error,
           fmt::format("Pose {}, reflector {}: {} mm", p.pose, p.smr, error_text(error.norm()))});
    };
    add(before, p.before);
    if (!document.remeasured) add(after, p.after);
    if (document.remeasured && p.remeasured) add(after, *p.remeasured);
  }
  before.exaggeration = after.exaggeration = exaggeration_of(before.arrows);
  if (after.arrows.empty()) return {{"Before", before}};
  Cloud enlarged = after;
  enlarged.exaggeration = exaggeration_of(after.arrows);
  Panels result{{"Before", before}, {"After", after}};
  if (enlarged.exaggeration > after.exaggeration) result.emplace_back("After, enlarged", enlarged);
  return result;
}

}  // namespace

double exaggeration_of(const std::vector<CloudArrow>& arrows) {
  std::vector<double> lengths;
  for (const CloudArrow& arrow : arrows) lengths.push_back(arrow.error.norm());
  const double part = std::min(kMedianPart, kCrowd / std::sqrt(static_cast<double>(arrows.size())));
  return exaggeration_of(std::move(lengths), Workspace{arrows}.size() * part);
}

std::string cloud_svg(const Cloud& cloud, CloudSide side, std::string_view id) {
  constexpr double kPi = std::numbers::pi;
  const bool above = side == CloudSide::Above;
  Projection project = above ? Projection{-kPi / 2, kPi / 2} : Projection{-kPi / 3, kPi / 7};
  const Workspace box{cloud.arrows};
  project.fit(box, cloud.arrows);
  Plot plot{above ? "From above" : "From the side", kWidth, kHeight,
            above ? "chart cloud-view" : "chart cloud-view turns", project.attributes()};
  plot.put(
      R"(<defs><marker id="{}" viewBox="0 0 6 6" refX="4" refY="3" markerWidth="3.6" markerHeight="3.6" )"
      R"(orient="auto"><path d="M0 0L6 3L0 6z" fill="{}"/></marker></defs>)",
      id, cloud.color);
  Scene scene{plot, project};
  scene.floor(box);
  scene.tracker(cloud.tracker_mm);
  scene.base(0.12 * box.size());
  plot.put(R"(<g stroke="{}" stroke-width="1.4">)", cloud.color);
  for (const CloudArrow& arrow : cloud.arrows) {
    scene.line(fmt::format("class=\"arrow\" marker-end=\"url(#{})\"", id), arrow.place,
               arrow.place + cloud.exaggeration * arrow.error);
    plot.put("><title>{}</title></line>", xml::escaped(arrow.label));
  }
  plot.put("</g>");
  return std::move(plot).finish();
}

std::string cloud_section(const ReportDocument& document) {
  const std::vector<Point> all = document.judged_points();
  if (all.empty() || !document.X_WB) return "";
  if (!std::ranges::all_of(all, [](const Point& p) { return p.position.has_value(); })) return "";
  const std::vector<Point> points = thinned(all);
  std::string labels, views;
  int k = 0;
  for (const auto& [name, cloud] : panels_of(document, points)) {
    labels += fmt::format(
        "<input type=\"radio\" name=\"cloud\" id=\"cloud{0}\"{1}/><label for=\"cloud{0}\">{2}</label>\n", k,
        k == 0 ? " checked=\"checked\"" : "", name);
    views +=
        fmt::format("<div class=\"views view{}\">\n<h3>{}, errors drawn {:g} times as long</h3>\n{}</div>\n",
                    k, name, cloud.exaggeration,
                    charts(cloud_svg(cloud, CloudSide::Side, fmt::format("tip{}a", k)) +
                           cloud_svg(cloud, CloudSide::Above, fmt::format("tip{}b", k))));
    ++k;
  }
  const std::string lead = fmt::format(
      "{} Each arrow starts where the reflector was measured and points to where {}. In the robot's base "
      "frame.<span class=\"screen\"> Drag the view from the side to turn it.</span>",
      points.size() < all.size() ? fmt::format("{} of {} points, evenly chosen.", points.size(), all.size())
                                 : fmt::format("All {} {} points.", all.size(), document.judging_name()),
      document.remeasured ? "it was predicted (before) or wanted (after)" : "the model predicts it");
  return section("Where the errors are",
                 note(lead) + fmt::format("<div class=\"cloud\">\n{}{}</div>\n", labels, views), "clouds");
}

}  // namespace truepose::report
