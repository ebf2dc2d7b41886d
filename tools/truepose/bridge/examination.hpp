#pragma once

#include <chrono>
#include <expected>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/truepose/bridge/bridge_line.hpp"
#include "tools/truepose/bridge/conformance.hpp"

namespace truepose::tools {

/// What is answered from memory, or refused, comes within this.
inline constexpr drivers::Duration kAtOnce = std::chrono::seconds{1};

/// What was seen of a promise: nothing that speaks against it, or what does.
struct Seen {
  std::string fault;
  bool skipped = false;

  static Seen kept() { return {}; }
  static Seen otherwise(std::string what) { return {std::move(what)}; }
  static Seen not_tried(std::string why) { return {std::move(why), true}; }
};
using Trial = boost::asio::awaitable<Seen>;

/// Whether a reply refuses by this code.
Seen expect_refusal(const std::expected<bridge::Reply, std::string>& reply, bridge::ErrorCode code,
                    std::optional<std::int64_t> id);

template <class T>
Seen kept_where(const std::expected<T, std::string>& outcome) {
  return outcome ? Seen::kept() : Seen::otherwise(outcome.error());
}

/// A bridge, looked at promise by promise.
class Examination {
 public:
  Examination(const boost::asio::any_io_executor& executor, drivers::Clock& clock, BridgeCheckOptions options)
      : options_{std::move(options)},
        executor_{executor},
        clock_{clock},
        line_{options_.stream(executor), clock} {}

  boost::asio::awaitable<std::expected<std::vector<BridgeVerdict>, std::string>> run();

 private:
  struct Promise {
    const char* promise;
    Trial (Examination::*trial)();
    const char* next;
  };
  static const std::vector<Promise> kPromises;

  // Of the connection and its lines
  Trial hello_comes_first();
  Trial greets();
  Trial speaks_what_it_can();
  Trial lives();
  Trial answers_status();
  Trial refuses_no_json();
  Trial refuses_no_id();
  Trial refuses_unknown_request();
  Trial refuses_missing_member();
  Trial passes_over_unknown_member();
  Trial takes_lines_in_pieces();
  Trial takes_lines_together();
  Trial turns_second_client_away();
  // Of settings
  Trial refuses_unknown_reflector();
  Trial takes_reflector();
  Trial takes_air();
  // Of the tracker
  Trial initialises();
  Trial aims();
  Trial misses();
  Trial measures();
  Trial lives_while_it_measures();
  Trial is_busy_while_it_measures();
  Trial stops();
  Trial turns_over();
  Trial loses_beam();
  Trial comes_back();

  BridgeTask<void> aim_at(Eigen::Vector3d p_mm, double search_mm, std::chrono::milliseconds timeout);
  BridgeTask<bridge::Greeting> hello(int protocol);
  BridgeTask<void> reconnect();

  const BridgeCheckOptions options_;
  boost::asio::any_io_executor executor_;
  drivers::Clock& clock_;
  BridgeLine line_;
  bridge::Greeting greeting_;
  bridge::Status status_;
  bool initialised_ = false, aimed_ = false;
};

}  // namespace truepose::tools
