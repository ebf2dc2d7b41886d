#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/json/value.hpp>
#include <chrono>
#include <cstddef>
#include <expected>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "daemon/control/control_server.hpp"
#include "proto/control/request.hpp"
#include "proto/rpc/session.hpp"

namespace truepose::daemon {

/// Calls that run in the background. The client is answered at once, gets progress notifications, and may ask
/// for the result after it has reconnected. Those that ended are kept for ten minutes. Runs on one thread.
class Jobs {
 public:
  static constexpr std::chrono::minutes kKept{10};
  static constexpr std::size_t kMost = 100;  ///< kept; beyond, the one that ended first is forgotten
  static constexpr std::size_t kMostRunning = 16;
  static constexpr std::chrono::seconds kLook{1};  ///< from one look at how a job continues to the next

  using Result = std::expected<boost::json::value, control::RpcError>;
  using Call = std::function<boost::asio::awaitable<Result>()>;
  using Tell = std::function<void(const rpc::Job& job)>;

  Jobs(const ControlServerParts& parts, boost::asio::any_io_executor executor)
      : parts_{parts}, executor_{std::move(executor)} {}

  /// @param by    whose it is
  /// @param tell  called with the job each time that what it does has changed, and at its end
  /// @return its number; or that too many are under way
  std::expected<std::string, control::RpcError> begin(std::string method, std::string by, Call call,
                                                      Tell tell);
  /// The job with its result or error; none where the caller has none of that number.
  std::optional<rpc::Job> find(const std::string& id, const std::string& by);
  /// Cancels those under way. They end within the loop's next turns.
  void stop();

 private:
  struct Job {
    std::string id, method, by;
    std::chrono::system_clock::time_point started;
    Tell tell;
    std::string doing{};             ///< one sentence, while it is under way
    std::optional<Result> result{};  ///< none while it is under way
    std::chrono::system_clock::time_point ended{};
    drivers::TimePoint forgotten_from{};  ///< once it has ended
    boost::asio::cancellation_signal cancel{};

    /// Without its result.
    rpc::Job record() const;
  };
  using Kept = std::shared_ptr<Job>;

  boost::asio::awaitable<void> carry_out(Kept job, Call call);
  boost::asio::awaitable<void> finish(Kept job, Call call);
  boost::asio::awaitable<void> follow(Kept job);
  void forget_old();

  const ControlServerParts& parts_;
  boost::asio::any_io_executor executor_;
  std::map<std::string, Kept> jobs_;
};

}  // namespace truepose::daemon
