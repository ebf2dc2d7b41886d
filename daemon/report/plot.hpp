#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace truepose::report {

// What every chart is drawn with.

/// Round numbers (1, 2 or 5 times a power of ten apart) that cover lo..hi, at most `at_most` + 2 of them.
std::vector<double> nice_ticks(double lo, double hi, int at_most);

/// Round numbers that cover lo..hi (0 < lo <= hi) on a logarithmic axis: 1, 2, 5 in each decade, or decades
/// alone.
std::vector<double> log_ticks(double lo, double hi, int at_most);

/// One axis: what it covers, and where on the paper a value lies.
struct Axis {
  double lo = 0, hi = 1;
  double from = 0, to = 1;    ///< on the paper
  std::vector<double> ticks;  ///< at least two
  bool logarithmic = false;

  double at(double value) const;  ///< that of an end for a value beyond it
  bool holds(double value) const { return value >= lo && value <= hi; }
  /// Of the ticks, with the decimals that the step between them needs, and no more.
  std::vector<std::string> labels() const;
  /// Width that a y axis needs for its labels.
  double label_width() const;
};

/// From the first to the last of the ticks.
Axis covering(std::vector<double> ticks, double from, double to, bool logarithmic = false);
/// From lo to hi and a margin beyond both, with about so many round numbers that lie within.
Axis within(double lo, double hi, double from, double to, int ticks, double margin = 0);

enum class Marker { HollowCircle, Circle, Diamond };

struct ChartPoint {
  double x = 0;
  double y = 0;
  std::string label = {};  ///< what a pointer resting on the marker reads; may be empty
};

struct Series {
  std::string name;        ///< in the legend
  std::string_view color;  ///< "#rrggbb", a literal
  Marker marker = Marker::Circle;
  std::vector<ChartPoint> points = {};
};

/// Lines that an axis draws in addition to its labels.
enum class AxisLines { None, Axis, Grid };

/// A chart in the making: an <svg> element, well-formed XML with every text escaped, in text of 12 units to
/// be read at about that many pixels.
class Plot {
 public:
  /// @param title       plain text
  /// @param attributes  of the element, in addition to the usual ones
  Plot(std::string_view title, double width, double height, std::string_view classes = "chart",
       std::string_view attributes = {});

  double left = 0, top = 30, right, bottom;  ///< edges of what is between the axes

  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
  }

  /// A filled rectangle that is labelled as a marker is.
  void rectangle(double x, double y, double width, double height, std::string_view color,
                 std::string_view label);
  /// @param points  on the paper
  void line(std::span<const Eigen::Vector2d> points, std::string_view attributes);
  /// Each point as the marker of its series, with its label; very many of them as bare dots.
  void points(const Series& series, const Axis& x, const Axis& y, double radius);
  void y_axis(const Axis& axis, std::string_view label = {}, AxisLines lines = AxisLines::Grid);
  void x_axis(const Axis& axis, std::string_view label, AxisLines lines = AxisLines::Axis);
  /// In as many lines as it needs; the plot begins below it.
  void legend(const std::vector<Series>& series);

  std::string finish() && { return std::move(svg_) + "</svg>\n"; }

 private:
  void marker(const Series& series, double x, double y, double r, std::string_view label = {});

  std::string svg_;
};

}  // namespace truepose::report
