#include "tools/truepose/doctor/rsi_report.hpp"

#include <boost/json/array.hpp>
#include <boost/json/value_from.hpp>

#include "tools/truepose/text.hpp"

namespace truepose::tools {

namespace json = boost::json;

namespace {

template <typename T>
json::value or_null(const std::optional<T>& value) {
  return value ? json::value(*value) : json::value{};
}

json::value or_null(const std::string& text) { return text.empty() ? json::value{} : json::value(text); }

std::string names_at(const json::value& sender, std::string_view pointer) {
  std::string names;
  for (const json::value& name : list_at(sender, pointer))
    names += (names.empty() ? "" : " ") + std::string{name.as_string()};
  return names.empty() ? "-" : names;
}

}  // namespace

bool is_of_kind(const RsiSender& sender, const std::optional<rsi::EthernetConfig>& ethernet) {
  if (sender.frames == 0) return false;
  return !ethernet || compare_names(sender.elements, *ethernet) == rsi::NameDifference{};
}

json::object sender_json(const RsiSender& sender, const std::optional<rsi::EthernetConfig>& ethernet) {
  const auto cycle_ms = sender.cycle_ms();
  json::object object{
      {"source", text(sender.source)},
      {"frames", sender.frames},
      {"frames_per_s", cycle_ms && *cycle_ms > 0 ? json::value(1000 / *cycle_ms) : json::value{}},
      {"cycle_ms", or_null(cycle_ms)},
      {"longest_ms", std::chrono::duration<double, std::milli>(sender.longest).count()},
      {"ipoc", nullptr},
      {"ipoc_step", sender.ipoc_step > 0 ? json::value(sender.ipoc_step) : json::value{}},
      {"delay", or_null(sender.frame.delay)},
      {"delay_rises", sender.delay_rises()},
      {"decimals", nullptr},
      {"elements", json::value_from(sender.elements.names)},
      {"unknown", nullptr},
      {"missing", nullptr},
      {"malformed", sender.malformed},
      {"why_malformed", or_null(sender.why_malformed)}};
  if (sender.frames == 0) return object;
  object["ipoc"] = sender.ipoc;
  object["decimals"] = sender.elements.decimals;
  if (!ethernet) return object;
  const rsi::NameDifference names = compare_names(sender.elements, *ethernet);
  object["unknown"] = json::value_from(names.unknown);
  object["missing"] = json::value_from(names.missing);
  return object;
}

std::string sender_text(const json::value& sender) {
  const std::string rises = is_true_at(sender, "/delay_rises") ? ", rising: these cycles had no reply" : "";
  std::vector<Cells> rows{
      {"sender", text_at(sender, "/source")},
      {"frames", text_at(sender, "/frames") + ", " + number_at(sender, "/frames_per_s", 1, " a second")},
      {"cycle", "IPOC + " + text_at(sender, "/ipoc_step") + ", " + number_at(sender, "/cycle_ms", 2, " ms") +
                    " by arrival, longest " + number_at(sender, "/longest_ms", 2, " ms")},
      {"IPOC", text_at(sender, "/ipoc")},
      {"Delay", text_at(sender, "/delay") + rises},
      {"decimals", text_at(sender, "/decimals")},
      {"elements", names_at(sender, "/elements")}};
  if (find_at(sender, "/unknown")) {
    rows.push_back({"unknown", names_at(sender, "/unknown")});
    rows.push_back({"missing", names_at(sender, "/missing")});
  }
  rows.push_back({"malformed", text_at(sender, "/malformed")});
  if (find_at(sender, "/why_malformed")) rows.back()[1] += ", " + text_at(sender, "/why_malformed");
  return text_table(rows);
}

std::string sender_line(const RsiSender& sender, std::uint64_t frames) {
  std::string line = text(sender.source) + "  " + std::to_string(frames) + " frames/s";
  if (sender.frames > 0) line += "  IPOC " + std::to_string(sender.ipoc);
  if (sender.frame.delay) line += "  Delay " + std::to_string(*sender.frame.delay);
  if (sender.malformed > 0) line += "  malformed " + std::to_string(sender.malformed);
  return line;
}

}  // namespace truepose::tools
