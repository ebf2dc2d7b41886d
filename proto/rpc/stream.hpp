#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

struct Percentiles {
  double p50 = 0;
  double p99 = 0;
  double p999 = 0;
  double max = 0;
};
void layout(Io& io, Percentiles& x);

struct StreamScheduling {
  std::string policy{};
  int priority = 0;
  std::vector<int> cpus{};
  std::uint64_t locked_kB = 0;
};

struct StreamStatus {
  static constexpr auto kTopic = control::Topic::Stream;

  struct Tool {
    std::optional<int> number{};
    bool measured = false;
  };
  struct Robot {
    std::optional<std::string> mode{};
    std::optional<double> override_percent{};
    std::optional<std::string> program{};
    std::optional<bool> emergency_stop{};
    std::optional<bool> gate_open{};
    std::optional<std::array<double, 6>> tool_frame{};
    std::optional<std::array<double, 6>> base_frame{};
    std::optional<double> load_kg{};
    std::string unknown{};

    bool operator==(const Robot&) const = default;
  };
  struct Arm {
    std::optional<std::string> serial{};
    bool verified = false;
    std::string why_not{};
  };
  struct LateBy {
    std::uint64_t daemon = 0;
    std::uint64_t machine = 0;
    std::uint64_t network = 0;
  };
  struct LastMinute {
    std::uint64_t answered = 0;
    std::uint64_t late = 0;
    std::uint64_t daemon = 0;
    std::uint64_t machine = 0;
    std::uint64_t network = 0;
  };
  std::string state{};
  bool armed = false;
  std::string reason{};
  std::optional<std::string> model_id{};
  Tool tool{};
  Robot robot{};
  Arm arm{};
  std::optional<std::string> peer{};
  std::optional<std::int64_t> packet_age_ms{};
  std::optional<std::uint64_t> ipoc_step{};
  std::uint64_t sessions = 0;
  std::uint64_t cycles = 0;
  std::uint64_t answered = 0;
  std::uint64_t held = 0;
  std::uint64_t duplicate = 0;
  std::uint64_t unconfirmed = 0;
  std::uint64_t malformed = 0;
  std::uint64_t partly_read = 0;
  std::uint64_t unexpected_sender = 0;
  std::optional<std::string> refused{};
  std::uint64_t late = 0;
  std::uint64_t lost = 0;
  std::uint64_t wrong_ipoc = 0;
  std::uint64_t clamped = 0;
  std::uint64_t no_solution = 0;
  std::uint64_t damped = 0;
  double max_step_deg = 0;
  std::vector<double> correction_deg{};
  std::vector<std::optional<double>> measured_deg{};
  LateBy late_by{};
  LastMinute last_minute{};
  Percentiles turnaround_us{};
  Percentiles compute_us{};
  std::optional<StreamScheduling> scheduling{};
};
void layout(Io& io, StreamStatus& x);

/// stream.start
struct StreamStart : NoParameters {
  using Result = StreamStatus;
  static const Method& method();
};

/// stream.stop
struct StreamStop : NoParameters {
  using Result = StreamStatus;
  static const Method& method();
};

/// stream.arm
struct StreamArm : NoParameters {
  using Result = StreamStatus;
  static const Method& method();
};

/// stream.disarm
struct StreamDisarm : NoParameters {
  using Result = StreamStatus;
  static const Method& method();
};

/// stream.status
struct GetStreamStatus : NoParameters {
  using Result = StreamStatus;
  static const Method& method();
};

/// The methods of this file.
std::vector<Described> stream_methods();

}  // namespace truepose::rpc
