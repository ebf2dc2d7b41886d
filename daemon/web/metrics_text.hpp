#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/realtime/lock_free.hpp"

namespace truepose::daemon {

/// Writes the text format of Prometheus (version 0.0.4): a family after the other, each with its samples.
///
///   MetricsText text;
///   text.family("truepose_stream_lost_total", "counter", "Cycles missing in the controller's IPOC");
///   text.sample(3, {{"arm", "left"}});
class MetricsText {
 public:
  using Labels = std::initializer_list<std::pair<std::string_view, std::string_view>>;

  /// @param type  "counter", "gauge" or "histogram"
  void family(std::string_view name, std::string_view type, std::string_view help);
  /// One of the family begun last.
  void sample(double value, Labels labels = {});
  /// A family with a single sample.
  void counter(std::string_view name, std::string_view help, double value);
  void gauge(std::string_view name, std::string_view help, double value);
  /// A family of durations, in seconds.
  void histogram(std::string_view name, std::string_view help, const LatencyHistogram& durations,
                 std::span<const double> edges_us);

  const std::string& text() const { return text_; }

 private:
  void line(std::string_view suffix, Labels labels, double value);

  std::string text_, name_;
};

}  // namespace truepose::daemon
