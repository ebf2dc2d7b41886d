#include "tools/truepose/calibration_summary.hpp"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cstdio>

namespace truepose::tools {

namespace {

namespace json = boost::json;

template <typename... Values>
std::string line(const char* format, Values... values) {
  std::array<char, 256> buffer;
  std::snprintf(buffer.data(), buffer.size(), format, values...);
  return std::string(buffer.data()) + "\n";
}

std::string stage_rows(const json::object& set, const char* name) {
  std::string text;
  for (const char* stage : {"before", "geometric", "after"}) {
    const json::object& errors = set.at(stage).as_object();
    const auto mm = [&](const char* key) { return errors.at(key).to_number<double>(); };
    text += line("  %-10s %-10s %10.4f %10.4f %10.4f %10.4f", stage == std::string("before") ? name : "",
                 stage, mm("mean"), mm("rms"), mm("max"), mm("min"));
  }
  return text;
}

std::string set_size(const json::object& set) {
  const auto count = [&](const char* key) { return set.at(key).to_number<double>(); };
  return line("%.0f poses, %.0f points", count("poses"), count("points"));
}

}  // namespace

std::string calibration_summary(const json::object& document, const std::string& robot_name) {
  const json::object& iterations = document.at("iterations").as_object();
  const json::array& parameters = document.at("parameters").as_array();
  const auto identified =
      std::ranges::count_if(parameters, [](const json::value& p) { return p.at("identified").as_bool(); });
  const json::value* validate = document.if_contains("validate");
  const json::value* splits = document.if_contains("splits");

  std::string text = robot_name + "\n";
  text += line("%s, %s after %.0f coarse and %.0f fine iterations, %.3f s",
               document.at("method").as_string().c_str(),
               document.at("converged").as_bool() ? "converged" : "NOT CONVERGED",
               iterations.at("coarse").to_number<double>(), iterations.at("fine").to_number<double>(),
               document.at("elapsed_s").to_number<double>());
  text += line("%td of %zu parameters identified, rank %.0f, condition %.1f", identified, parameters.size(),
               document.at("rank").to_number<double>(), document.at("condition").to_number<double>());
  text += "identify: " + set_size(document.at("identify").as_object());
  text += validate ? "validate: " + set_size(validate->as_object()) : "validate: nothing was validated\n";
  if (splits) text += line("validate: means over %zu splits", splits->as_array().size());

  text += line("\n  %-10s %-10s %10s %10s %10s %10s", "error, mm", "", "mean", "rms", "max", "min");
  text += stage_rows(document.at("identify").as_object(), "identify");
  if (validate) text += stage_rows(validate->as_object(), "validate");
  return text;
}

}  // namespace truepose::tools
