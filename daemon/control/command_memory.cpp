#include "daemon/control/command_memory.hpp"

#include <algorithm>
#include <utility>

namespace truepose::daemon {

using drivers::TimePoint;

void CommandMemory::drop_old(TimePoint now) {
  std::erase_if(commands_,
                [&](const auto& kept) { return kept.second->result && now - kept.second->begun >= kKept; });
}

std::shared_ptr<CommandMemory::Command> CommandMemory::find(const std::string& caller, const std::string& id,
                                                            TimePoint now) {
  drop_old(now);
  const auto found = commands_.find({caller, id});
  return found == commands_.end() ? nullptr : found->second;
}

std::shared_ptr<CommandMemory::Command> CommandMemory::begin(const std::string& caller, const std::string& id,
                                                             std::string text, TimePoint now,
                                                             const boost::asio::any_io_executor& executor) {
  const auto later = [](const auto& one, const auto& other) {
    return std::pair{!one.second->result, one.second->begun} <
           std::pair{!other.second->result, other.second->begun};
  };
  if (commands_.size() >= kMost) commands_.erase(std::ranges::min_element(commands_, later));
  auto command = std::make_shared<Command>(Command{std::move(text), now, {}, drivers::Condition{executor}});
  commands_[{caller, id}] = command;
  return command;
}

void CommandMemory::end(Command& command, Result result) {
  command.result = std::move(result);
  command.ended.notify();
}

void CommandMemory::forget(const std::string& caller, const std::string& id) {
  commands_.erase({caller, id});
}

}  // namespace truepose::daemon
