#include <fmt/format.h>

#include <boost/json/object.hpp>
#include <stdexcept>

#include "core/math/angles.hpp"
#include "daemon/report/charts.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/record/frame_document.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

using record::FrameDocument;

std::string frame_table(const FrameDocument& frame) {
  Table table{"frame", {{}, {"X, mm"}, {"Y, mm"}, {"Z, mm"}, {"A, deg", "first"}, {"B, deg"}, {"C, deg"}}};
  std::vector<std::string> values, sigmas;
  for (const double mm : frame.X.translation()) values.push_back(fmt::format("{:.4f}", mm));
  for (const double deg : kuka_abc_deg(frame.X.linear())) values.push_back(fmt::format("{:.5f}", deg + 0.0));
  for (const double mm : frame.sigma_mm) sigmas.push_back(fmt::format("{:.4f}", mm));
  for (Eigen::Index i = 0; i < 3; ++i)
    sigmas.push_back(frame.sigma_deg ? fmt::format("{:.5f}", (*frame.sigma_deg)[i]) : "-");
  table.row("Measured", values);
  table.row("Standard deviation", sigmas);
  return std::move(table).scrolled();
}

std::string readings_chart(const FrameDocument& frame) {
  Series errors{"Distance from where all readings together have the point", kGeometricColor, Marker::Circle};
  for (const FrameDocument::Reading& reading : frame.readings)
    errors.points.push_back({static_cast<double>(reading.row), reading.error_mm, reading.point});
  return charts(point_chart_svg(
      {.title = "Readings", .x_label = "reading", .y_unit = "mm", .series = {std::move(errors)}}));
}

}  // namespace

std::string frame_section(const boost::json::object& json) {
  const auto read = record::read_frame_document(json);
  if (!read) throw std::invalid_argument("document of the tool: " + read.error());
  const bool is_tool = read->kind == record::FrameKind::Tool;
  std::string html =
      fmt::format("<p>{} readings of {} points{}. Sigma is by the readings and by the model.</p>\n",
                  read->readings.size(), read->points.size(),
                  read->touched_by ? fmt::format(", touched by tool {}", *read->touched_by) : "");
  if (const std::string why = record::why_not_usable(*read); !why.empty())
    html += fmt::format("<p class=\"caution\">Not to be used: {}.</p>\n", xml::escaped(why));
  for (const std::string& sentence : read->notes) html += note(xml::escaped(sentence));
  html += frame_table(*read) + fmt::format("<p><code>{}</code></p>\n", xml::escaped(read->krl)) +
          readings_chart(*read);
  return section(fmt::format("{} {}", is_tool ? "Tool" : "Base", read->number), html);
}

}  // namespace truepose::report
