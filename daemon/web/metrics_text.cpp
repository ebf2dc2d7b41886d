#include "daemon/web/metrics_text.hpp"

#include <cmath>

#include "config/number_text.hpp"

namespace truepose::daemon {

namespace {

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  return config::format_number(value);
}

std::string escaped(std::string_view text, bool in_quotes) {
  std::string escaped;
  for (const char byte : text) {
    if (byte == '\\' || (in_quotes && byte == '"')) escaped += '\\';
    escaped += byte == '\n' ? "\\n" : std::string(1, byte);
  }
  return escaped;
}

}  // namespace

void MetricsText::family(std::string_view name, std::string_view type, std::string_view help) {
  name_ = name;
  text_ +=
      "# HELP " + name_ + " " + escaped(help, false) + "\n# TYPE " + name_ + " " + std::string{type} + "\n";
}

void MetricsText::line(std::string_view suffix, Labels labels, double value) {
  text_ += name_ + std::string{suffix};
  const char* before = "{";
  for (const auto& [name, of] : labels) {
    text_ += before + std::string{name} + "=\"" + escaped(of, true) + "\"";
    before = ",";
  }
  if (labels.size() > 0) text_ += "}";
  text_ += " " + number(value) + "\n";
}

void MetricsText::sample(double value, Labels labels) { line("", labels, value); }

void MetricsText::counter(std::string_view name, std::string_view help, double value) {
  family(name, "counter", help);
  sample(value);
}

void MetricsText::gauge(std::string_view name, std::string_view help, double value) {
  family(name, "gauge", help);
  sample(value);
}

void MetricsText::histogram(std::string_view name, std::string_view help, const LatencyHistogram& durations,
                            std::span<const double> edges_us) {
  const LatencyHistogram::Distribution distribution = durations.distribution(edges_us);
  family(name, "histogram", help);
  for (std::size_t i = 0; i < edges_us.size(); ++i)
    line("_bucket", {{"le", number(edges_us[i] / 1e6)}}, static_cast<double>(distribution.at_most[i]));
  line("_bucket", {{"le", "+Inf"}}, static_cast<double>(distribution.count));
  line("_sum", {}, distribution.sum_us / 1e6);
  line("_count", {}, static_cast<double>(distribution.count));
}

}  // namespace truepose::daemon
