#pragma once

#include <string>
#include <vector>

namespace truepose::report {

enum class Marker { HollowCircle, Circle, Diamond };

struct ChartPoint {
  double x = 0;
  double y = 0;
  std::string label;  ///< what a pointer resting on the marker reads; may be empty
};

struct Series {
  std::string name;   ///< in the legend
  std::string color;  ///< "#rrggbb"
  Marker marker = Marker::Circle;
  std::vector<ChartPoint> points;
};

/// A chart of values over a running number.
struct PointChart {
  std::string title;
  std::string x_label;
  std::string y_unit;
  double y_limit = 0;  ///< points farther from zero are drawn at the edge; 0: none is
  bool log_y = false;  ///< for positive values of very different size; others are drawn at the lower edge
  std::vector<Series> series;
};

/// A chart of how often values of each size occur.
struct HistogramChart {
  std::string title;
  std::string x_label;
  std::string color;
  std::vector<double> values;  ///< not negative, at least one
};

/// Round numbers (1, 2 or 5 times a power of ten apart) that cover lo..hi, at most `at_most` + 2 of them.
std::vector<double> nice_ticks(double lo, double hi, int at_most);

/// Round numbers that cover lo..hi (0 < lo <= hi) on a logarithmic axis: 1, 2, 5 in each decade, or decades
/// alone.
std::vector<double> log_ticks(double lo, double hi, int at_most);

/// The charts as <svg> elements, well-formed XML with every text escaped: points in 480 x 280 units, a
/// histogram in 320 x 220, in text of 12 to be read at about that many pixels.
std::string point_chart_svg(const PointChart& chart);
std::string histogram_svg(const HistogramChart& chart);

}  // namespace truepose::report
