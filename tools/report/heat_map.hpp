#pragma once

#include <string>
#include <utility>
#include <vector>

namespace truepose::report {

/// The values that the colours of a map run over, light to dark; logarithmic where they span more than a
/// decade.
struct ColorScale {
  double lo = 0, hi = 0;

  bool logarithmic() const { return lo > 0 && hi > 10 * lo; }
  std::string color(double value) const;  ///< "#rrggbb"
};

/// Values over a plane, sampled on a grid.
struct HeatMap {
  std::string title;
  std::string x_label, y_label;
  double x_from = 0, x_to = 0, y_from = 0, y_to = 0;  ///< of the outer samples
  std::vector<std::vector<double>> values;            ///< [y][x], at least two of each
  std::vector<std::pair<double, double>> marks;       ///< points to draw; those outside are left out
  ColorScale scale;
};

/// The map as an <svg> element in 480 x 400 units with its scale below.
std::string heat_map_svg(const HeatMap& map);

}  // namespace truepose::report
