#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/report/plot.hpp"

namespace truepose::report {

// The kinds of charts, each as an <svg> element: points over a running number, points anywhere with a curve,
// a histogram, boxes with whiskers, a heat map, errors as arrows in space, and a path with its errors.

/// A series without points yet, the k-th of many in one chart.
Series series_of_palette(std::string name, std::size_t k);

/// Values over a running number, in 480 x 280 units.
struct PointChart {
  std::string title;
  std::string x_label;
  std::string y_unit;
  double y_limit = 0;  ///< points farther from zero are drawn at the edge; 0: none is
  bool log_y = false;  ///< for positive values of very different size; others are drawn at the lower edge
  std::vector<Series> series;
};
std::string point_chart_svg(const PointChart& chart);

/// Points anywhere on a plane, with a curve through those of each series, in 360 x 250 units.
struct ScatterChart {
  std::string title, x_label;
  double y_extent = 0;  ///< the y axis covers -y_extent..y_extent; above 0
  std::vector<Series> series;
  std::vector<std::vector<std::pair<double, double>>> curves;  ///< one per series, may be empty
};
std::string scatter_chart_svg(const ScatterChart& chart);

/// How often values of each size occur, in 320 x 220 units.
struct Histogram {
  std::string title;
  std::string x_label;
  std::string_view color;
  std::vector<double> values;  ///< mm, not negative, at least one
};
std::string histogram_svg(const Histogram& chart);

/// What a box shows, mm: the whiskers reach from the smallest to the greatest value, the box from the lower
/// to the upper quartile.
struct Box {
  std::string name;
  std::string_view color;  ///< "#rrggbb"
  double min = 0, lower = 0, median = 0, upper = 0, max = 0;
};
/// Boxes one below the other over one logarithmic axis.
///
/// @param boxes  at least one, their values positive (smaller ones are drawn at the left edge)
std::string box_chart_svg(const std::string& title, const std::string& x_label,
                          const std::vector<Box>& boxes);

/// The values that the colours of a map run over, light to dark; logarithmic where they span more than a
/// decade.
struct ColorScale {
  double lo = 0, hi = 0;

  bool logarithmic() const { return lo > 0 && hi > 10 * lo; }
  std::string color(double value) const;  ///< "#rrggbb"
};
/// The colours over the width between the axes, with what they mean below them; 25 units high.
void draw_scale(Plot& plot, const ColorScale& scale, std::string_view title, double top);

/// Standard deviations (mm) over a plane, sampled on a grid, in 480 x 400 units with their scale below.
struct HeatMap {
  std::string title;
  std::string x_label, y_label;
  double x_from = 0, x_to = 0, y_from = 0, y_to = 0;  ///< of the outer samples
  std::vector<std::vector<double>> values;            ///< [y][x], at least two of each
  std::vector<std::pair<double, double>> marks;       ///< points to draw; those outside are left out
  ColorScale scale;
};
std::string heat_map_svg(const HeatMap& map);

/// A round factor (1, 2 or 5 times a power of ten) by which an error of the usual size, the median, is drawn
/// as long as that or shorter; 1 where there is none.
double exaggeration_of(std::vector<double> errors_mm, double length_mm);

/// An error at its place, mm in the robot's base frame.
struct CloudArrow {
  Eigen::Vector3d place{0, 0, 0}, error{0, 0, 0};
  std::string label;  ///< what a pointer resting on it reads
};

/// Error vectors in the workspace.
struct Cloud {
  std::string_view color;
  std::vector<CloudArrow> arrows;       ///< at least one
  Eigen::Vector3d tracker_mm{0, 0, 0};  ///< in the base frame
  double exaggeration = 1;
};

/// Where a cloud is seen from. The view from the side can be turned, by the page's script.
enum class CloudSide { Side, Above };

/// That by which the errors are well seen and do not hide each other.
double exaggeration_of(const std::vector<CloudArrow>& arrows);

/// The view in 480 x 360 units: the arrows from the measured places, the robot's base as its three axes on a
/// grid of the floor, and the tracker; where that stands outside, its direction and distance.
///
/// @param id  unique on the page
std::string cloud_svg(const Cloud& cloud, CloudSide side, std::string_view id);

using PathLine = std::vector<Eigen::Vector3d>;  ///< at least one position, mm

/// A point of a path.
struct PathMark {
  Eigen::Vector3d place_mm{0, 0, 0};
  std::optional<double> error_mm;  ///< nothing: not judged
  std::string label;               ///< what a pointer resting on it reads
};

/// A path, and the same as it was gone with its errors drawn larger.
struct PathDrawing {
  std::string title;
  std::string_view color;              ///< of `real`, "#rrggbb"
  std::vector<PathLine> wanted, real;  ///< wanted: at least one line
  std::vector<PathMark> marks;
};

/// Drawings of the same wanted path, each 480 units wide: all seen at right angles to the plane that holds
/// most of it, in one size and one scale of colours for the errors of the marks.
///
/// @param drawings  at least one
std::string path_drawings_svg(std::span<const PathDrawing> drawings);

}  // namespace truepose::report
