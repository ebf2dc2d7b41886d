#pragma once

#include <string>
#include <vector>

namespace truepose::report {

/// What a box shows: the whiskers reach from the smallest to the greatest value, the box from the lower to
/// the upper quartile.
struct BoxRow {
  std::string name;
  std::string color;  ///< "#rrggbb"
  double min = 0, lower = 0, median = 0, upper = 0, max = 0;
};

/// Boxes one below the other over one logarithmic axis, as an <svg> element: well-formed XML, every text
/// escaped.
///
/// @param rows  at least one, their values positive (smaller ones are drawn at the left edge)
std::string box_chart_svg(const std::string& title, const std::string& x_label,
                          const std::vector<BoxRow>& rows);

}  // namespace truepose::report
