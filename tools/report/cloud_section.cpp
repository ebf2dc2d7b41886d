#include "tools/report/cloud_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/report/error_cloud.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_style.hpp"

namespace truepose::report {
namespace {

// More arrows hide each other, and make the page heavy.
constexpr std::size_t kMostArrows = 250;

using ErrorOf = std::optional<Eigen::Vector3d> (*)(const Point&);

/// One setting of the switch.
struct CloudPanel {
  std::string name;
  std::string_view color;
  Cloud cloud;
};

std::vector<CloudArrow> arrows(const std::vector<Point>& points, const Eigen::Isometry3d& X_BW,
                               ErrorOf error_of) {
  std::vector<CloudArrow> result;
  for (const Point& p : points) {
    const auto error = error_of(p);
    if (!error) continue;
    result.push_back({X_BW * *p.position, X_BW.linear() * *error,
                      fmt::format("Pose {}, reflector {}: {} mm", p.pose, p.smr, error_text(error->norm()))});
  }
  return result;
}

/// Every k-th point, so that at most so many are left.
std::vector<Point> thinned(const std::vector<Point>& points) {
  const std::size_t step = (points.size() + kMostArrows - 1) / kMostArrows;
  std::vector<Point> result;
  for (std::size_t i = 0; i < points.size(); i += std::max<std::size_t>(step, 1)) result.push_back(points[i]);
  return result;
}

std::vector<CloudPanel> panels(const ReportDocument& document, const std::vector<Point>& points) {
  const Eigen::Isometry3d X_BW = document.setup.X_WB->inverse();
  const auto of = [&](ErrorOf error_of) {
    return Cloud{.arrows = arrows(points, X_BW, error_of), .tracker_mm = X_BW.translation()};
  };
  CloudPanel before{"Before", kBeforeColor, of([](const Point& p) { return std::optional{p.before}; })};
  before.cloud.exaggeration = exaggeration_of(before.cloud.arrows);
  CloudPanel after{"After", kGeometricColor, {}};
  if (document.remeasured) {
    after.color = kCompensatedColor;
    after.cloud = of([](const Point& p) { return p.remeasured; });
  } else {
    if (has_layers(document.judged())) after.color = kLayersColor;
    after.cloud = of([](const Point& p) { return std::optional{p.after}; });
  }
  std::vector<CloudPanel> result{std::move(before)};
  if (after.cloud.arrows.empty()) return result;
  const double alike = result.front().cloud.exaggeration, enlarged = exaggeration_of(after.cloud.arrows);
  after.cloud.exaggeration = alike;
  result.push_back(after);
  if (enlarged > alike) {
    after.name = "After, enlarged";
    after.cloud.exaggeration = enlarged;
    result.push_back(std::move(after));
  }
  return result;
}

std::string views(const CloudPanel& panel, std::size_t number) {
  constexpr double kPi = std::numbers::pi;
  const auto view = [&](std::string_view title, std::string_view kind, double azimuth, double elevation) {
    return cloud_svg(panel.cloud, {.title = std::string(title),
                                   .id = fmt::format("tip{}{}", number, kind),
                                   .color = std::string(panel.color),
                                   .azimuth_rad = azimuth,
                                   .elevation_rad = elevation,
                                   .turns = kind == "a"});
  };
  return fmt::format(
             "<div class=\"views view{}\">\n<h3>{}, errors drawn {:g} times as long</h3>\n<div "
             "class=\"charts\">\n",
             number, panel.name, panel.cloud.exaggeration) +
         view("From the side", "a", -kPi / 3, kPi / 7) + view("From above", "b", -kPi / 2, kPi / 2) +
         "</div>\n</div>\n";
}

}  // namespace

std::string cloud_section(const ReportDocument& document) {
  const std::vector<Point> all = document.judged_points();
  if (all.empty() || !document.setup.X_WB) return "";
  if (!std::ranges::all_of(all, [](const Point& p) { return p.position.has_value(); })) return "";
  const std::vector<Point> points = thinned(all);
  const std::vector<CloudPanel> shown = panels(document, points);

  std::string html = fmt::format(
      "<section class=\"clouds\">\n<h2>Where the errors are</h2>\n<p class=\"note\">{} Each arrow starts "
      "where "
      "the reflector was measured and points to where {}. In the robot's base frame.<span class=\"screen\"> "
      "Drag the view from the side to turn it.</span></p>\n<div class=\"cloud\">\n",
      points.size() < all.size()
          ? fmt::format("{} of {} points, evenly chosen.", points.size(), all.size())
          : fmt::format("All {} {} points.", all.size(), document.validate ? "validation" : "identification"),
      document.remeasured ? "it was predicted (before) or wanted (after)" : "the model predicts it");
  for (std::size_t k = 0; k < shown.size(); ++k) {
    html += fmt::format(
        "<input type=\"radio\" name=\"cloud\" id=\"cloud{0}\"{1}/><label for=\"cloud{0}\">{2}</label>\n", k,
        k == 0 ? " checked=\"checked\"" : "", shown[k].name);
  }
  for (std::size_t k = 0; k < shown.size(); ++k) html += views(shown[k], k);
  return html + "</div>\n</section>\n";
}

}  // namespace truepose::report
