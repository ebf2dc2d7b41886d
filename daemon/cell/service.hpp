#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/cell_config.hpp"
#include "daemon/campaign/store_journal.hpp"
#include "daemon/control/event_bus.hpp"
#include "daemon/control/served.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "daemon/recorder/recorder.hpp"
#include "daemon/store/store.hpp"
#include "daemon/threads/worker.hpp"
#include "proto/text/random_bytes.hpp"

namespace truepose::daemon {

/// What the services of a cell work with. All of it outlives them.
struct CellParts {
  boost::asio::any_io_executor io;
  const config::CellConfig& config;
  drivers::Robot& robot;
  drivers::Tracker& tracker;
  drivers::Clock& clock;
  StreamCycle& stream;
  Store& store;  ///< touched by the store thread alone
  Worker& store_thread;
  Worker& compute_thread;
  EventBus& events;
  Recorder& recorder;  ///< drained and saved by the recorder thread alone
  Worker& recorder_thread;
  drivers::WallClock wall_clock;
  std::function<drivers::Scheduling()> realtime_thread{};  ///< how it runs now; empty: there is none
  RandomBytes random = kernel_random;                      ///< of the ids of campaigns, models and backups
};

/// The methods of all services, by their names.
using MethodTable =
    std::map<std::string, std::function<MethodReply(boost::json::object, std::string by)>, std::less<>>;

template <typename Service>
void add_methods(MethodTable& table, Service& service) {
  for (const Served<Service>& served : Service::methods())
    table.emplace(served.name,
                  [&service, carry_out = served.carry_out](boost::json::object params, std::string by) {
                    return carry_out(service, std::move(params), std::move(by));
                  });
}

inline control::RpcError store_unusable(const StoreError& error) {
  return {control::ErrorCode::Store, error.detail};
}

/// An empty text says nothing: null in an answer.
inline std::optional<std::string> text_or_none(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional{text};
}

/// The part of a list that a request asks for with limit and offset.
template <class Entry, class Record>
std::vector<Entry> page_of(const std::vector<Record>& records, const auto& request,
                           Entry (*entry)(const Record&)) {
  std::vector<Entry> page;
  for (std::size_t i = request.offset; i < records.size() && std::ssize(page) < request.limit; ++i)
    page.push_back(entry(records[i]));
  return page;
}

}  // namespace truepose::daemon
