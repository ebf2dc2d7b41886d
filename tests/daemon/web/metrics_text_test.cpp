#include "daemon/web/metrics_text.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;

TEST(MetricsText, HasTheGoldenForm) {
  MetricsText text;
  text.counter("truepose_stream_lost_total", "Cycles missing\nin the IPOC \\ of the controller", 3);
  text.family("truepose_faults", "gauge", "Faults that stand");
  text.sample(0.5, {{"severity", "a \"quoted\" one"}, {"axis", "1"}});
  text.sample(std::numeric_limits<double>::infinity(), {});
  EXPECT_EQ(text.text(),
            "# HELP truepose_stream_lost_total Cycles missing\\nin the IPOC \\\\ of the controller\n"
            "# TYPE truepose_stream_lost_total counter\n"
            "truepose_stream_lost_total 3\n"
            "# HELP truepose_faults Faults that stand\n"
            "# TYPE truepose_faults gauge\n"
            "truepose_faults{severity=\"a \\\"quoted\\\" one\",axis=\"1\"} 0.5\n"
            "truepose_faults +Inf\n");
}

TEST(MetricsText, CountsDurationsUpToEachEdge) {
  LatencyHistogram times;
  for (const auto time : {10us, 90us, 90us, 5000us}) times.record(time);
  MetricsText text;
  constexpr std::array kEdges_us{20.0, 100.0};
  text.histogram("t_seconds", "Times", times, kEdges_us);
  const std::string& said = text.text();
  EXPECT_NE(said.find("t_seconds_bucket{le=\"2e-05\"} 1\nt_seconds_bucket{le=\"1e-04\"} 3\n"
                      "t_seconds_bucket{le=\"+Inf\"} 4\n"),
            std::string::npos)
      << said;
  EXPECT_NE(said.find("t_seconds_count 4\n"), std::string::npos);
  const double sum_s = std::stod(said.substr(said.find("t_seconds_sum ") + 14));
  EXPECT_GE(sum_s, 5.19e-3);
  EXPECT_LT(sum_s, 5.19e-3 * (1 + 1.0 / 32));
}

}  // namespace
}  // namespace truepose::daemon
