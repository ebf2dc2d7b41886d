#include "tools/truepose/drift_text.hpp"

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>

namespace truepose::tools {
namespace {

namespace json = boost::json;

constexpr double kHardly = 1e-6;  // of a probability: beyond, the digits say nothing

double number(const json::value& object, const char* key) { return object.at(key).to_number<double>(); }

std::string row_text(const json::value& point) {
  char text[100];
  std::snprintf(text, sizeof text, "%5lld %9.3f %9.3f %9.3f %9.3f\n",
                static_cast<long long>(number(point, "row")), number(point, "x"), number(point, "y"),
                number(point, "z"), number(point, "length"));
  return text;
}

}  // namespace

std::string drift_text(const json::value& document) {
  std::string text = "  row         x         y         z     error   (mm, predicted less measured)\n";
  for (const json::value& point : document.at("points").as_array()) text += row_text(point);
  const double probability = number(document, "probability");
  char chance[100];
  std::snprintf(chance, sizeof chance,
                "\nIn an unchanged cell such errors or greater have a probability %s %.2g.\n",
                probability < kHardly ? "below" : "of", std::max(probability, kHardly));
  text += chance;
  if (document.at("parameters") != "uncertain")
    text += "The model file does not say how well its parameters are known; they were taken as exact.\n";
  const auto word = [&](const char* key) { return std::string{document.at(key).as_string()}; };
  return text + word("verdict") + ": " + word("reason") + ".\n";
}

}  // namespace truepose::tools
