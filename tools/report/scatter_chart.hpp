#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/report/svg_chart.hpp"

namespace truepose::report {

/// Points anywhere on a plane, with a curve through those of each series.
struct ScatterChart {
  std::string title, x_label;
  double y_extent = 0;  ///< the y axis covers -y_extent..y_extent; above 0
  std::vector<Series> series;
  std::vector<std::vector<std::pair<double, double>>> curves;  ///< one per series, may be empty
};

/// The chart as an <svg> element in 360 x 250 units.
std::string scatter_chart_svg(const ScatterChart& chart);

}  // namespace truepose::report
