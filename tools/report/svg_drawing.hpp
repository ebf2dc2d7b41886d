#pragma once

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/report/svg_chart.hpp"

namespace truepose::report {

// What the charts with two axes are drawn with.

/// One axis: what it covers, and where on the paper a value lies.
struct Axis {
  double lo = 0, hi = 1;
  double from = 0, to = 1;    ///< on the paper
  std::vector<double> ticks;  ///< at least two
  bool logarithmic = false;

  double at(double value) const;
};

/// Labels with the decimals that the step between the ticks needs, and no more.
std::vector<std::string> tick_labels(const Axis& axis);

/// Width that the y axis needs for its labels.
double label_width(const std::vector<std::string>& labels);

/// An <svg> element in the making, well-formed XML.
class Drawing {
 public:
  Drawing(std::string_view title, double width, double height);

  const double right, bottom;  ///< edges of the plot

  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
  }

  /// Each point as the marker of its series, with its label; very many of them as bare dots.
  void points(const Series& series, const Axis& x, const Axis& y, double radius);
  void y_axis(const Axis& axis, const std::vector<std::string>& labels, double left);
  void x_axis(const Axis& axis, std::string_view label);
  /// In as many lines as it needs; returns the y below it.
  double legend(const std::vector<Series>& series);

  std::string finish() && { return std::move(svg_) + "</svg>\n"; }

 private:
  /// Left open for a title, until end_marker().
  void marker(const Series& series, double x, double y, double r);
  void end_marker(const Series& series);

  std::string svg_;
};

}  // namespace truepose::report
