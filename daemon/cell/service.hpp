#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <concepts>
#include <cstddef>
#include <expected>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/cell_config.hpp"
#include "daemon/campaign/store_journal.hpp"
#include "daemon/control/event_bus.hpp"
#include "daemon/control/served.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "daemon/recorder/recorder.hpp"
#include "daemon/store/store.hpp"
#include "daemon/threads/worker.hpp"
#include "proto/control/param_reader.hpp"

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
  StoreJournal::WallClock wall_clock;
  std::function<drivers::Scheduling()> realtime_thread{};  ///< how it runs now; empty: there is none
};

/// One method of the control protocol, as openrpc.json describes it, and who carries it out. Some want to
/// know by whom it was called.
template <typename Service>
struct Method {
  using OfAnybody = MethodReply (Service::*)(boost::json::object params);
  using OfSomebody = MethodReply (Service::*)(boost::json::object params, std::string by);

  // Two, so that each finds its own among the overloads of a name.
  Method(std::string_view method, OfAnybody member) : name{method}, carry_out{member} {}
  Method(std::string_view method, OfSomebody member) : name{method}, carry_out{member} {}

  std::string_view name;
  std::variant<OfAnybody, OfSomebody> carry_out;
};

/// The methods of all services, by their names.
using MethodTable =
    std::map<std::string, std::function<MethodReply(boost::json::object, std::string by)>, std::less<>>;

template <typename Service>
void add_methods(MethodTable& table, Service& service) {
  if constexpr (std::same_as<decltype(Service::methods()), std::vector<Served<Service>>>) {
    for (const Served<Service>& served : Service::methods())
      table.emplace(served.name,
                    [&service, carry_out = served.carry_out](boost::json::object params, std::string by) {
                      return carry_out(service, std::move(params), std::move(by));
                    });
    return;
  } else
    for (const Method<Service>& method : Service::methods())
      table.emplace(
          method.name, [&service, carry_out = method.carry_out](boost::json::object params, std::string by) {
            if (const auto* of_anybody = std::get_if<typename Method<Service>::OfAnybody>(&carry_out))
              return (service.**of_anybody)(std::move(params));
            const auto of_somebody = std::get<typename Method<Service>::OfSomebody>(carry_out);
            return (service.*of_somebody)(std::move(params), std::move(by));
          });
}

inline std::optional<control::RpcError> no_parameters(const boost::json::object& params) {
  return control::ParamReader{params}.finish();
}

inline control::RpcError store_unusable(const StoreError& error) {
  return {control::ErrorCode::Store, error.detail};
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

/// The part of a list that a request asks for with "limit" and "offset".
struct Page {
  std::size_t limit;
  std::size_t offset;

  explicit Page(control::ParamReader& read)
      : limit{static_cast<std::size_t>(read.integer("limit", 1, 100).value_or(20))},
        offset{static_cast<std::size_t>(read.integer("offset", 0, 1'000'000'000).value_or(0))} {}

  template <typename Record>
  boost::json::array of(const std::vector<Record>& records,
                        boost::json::object (*json)(const Record&)) const {
    boost::json::array page;
    for (std::size_t i = offset; i < records.size() && page.size() < limit; ++i)
      page.push_back(json(records[i]));
    return page;
  }
};

}  // namespace truepose::daemon
