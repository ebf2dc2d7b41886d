#pragma once

#include <boost/json/value.hpp>
#include <expected>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "drivers/clock.hpp"
#include "drivers/condition.hpp"
#include "proto/control/request.hpp"

namespace truepose::daemon {

/// The commands of the last ten minutes that their callers numbered, so that one that is repeated, as by a
/// panel that lost its connection meanwhile, is answered and not done twice.
class CommandMemory {
 public:
  static constexpr std::chrono::minutes kKept{10};
  static constexpr std::size_t kMost = 1000;  ///< beyond, the oldest that has ended is forgotten
  using Result = std::expected<boost::json::value, control::RpcError>;

  struct Command {
    std::string text;  ///< method and parameters
    drivers::TimePoint begun;
    std::optional<Result> result{};  ///< none while it is under way
    drivers::Condition ended;
  };

  /// The command that a caller gave this id; null where it gave it to none.
  std::shared_ptr<Command> find(const std::string& caller, const std::string& id, drivers::TimePoint now);
  std::shared_ptr<Command> begin(const std::string& caller, const std::string& id, std::string text,
                                 drivers::TimePoint now, const boost::asio::any_io_executor& executor);
  /// Tells the result to who waits for it.
  static void end(Command& command, Result result);
  /// It was not carried out: the id is free again.
  void forget(const std::string& caller, const std::string& id);

 private:
  using Key = std::pair<std::string, std::string>;
  void drop_old(drivers::TimePoint now);

  std::map<Key, std::shared_ptr<Command>> commands_;
};

}  // namespace truepose::daemon
