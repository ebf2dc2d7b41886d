#include "daemon/replay/replay.hpp"

#include <algorithm>
#include <charconv>
#include <map>

#include "daemon/replay/device_replay.hpp"
#include "daemon/replay/driver_replay.hpp"
#include "daemon/replay/stream_replay.hpp"

namespace truepose::daemon {

using recording::Kind;
using recording::Record;
using recording::Wire;

namespace {

/// All wires of a recording.
class Replayed {
 public:
  Replayed(StreamReplay stream, std::optional<Wire> only) : stream_{std::move(stream)}, only_{only} {}

  void take(const Record& record) {
    count(record);
    if (record.kind == Kind::Dropped) {
      miss(record);
    } else if (record.wire == Wire::Daemon) {
      report_.recorded_faults.push_back({record.time_ns, record.bytes});
    } else {
      if (!only_ || record.wire == *only_) of_wire(record);
      of_driver(record);
    }
  }

  ReplayReport report(std::string damage) {
    stream_.end();
    if (has_rsi_) report_.wires.push_back(stream_.wire());
    for (const auto& [wire, device] : devices_) report_.wires.push_back(device.report());
    report_.stream = stream_.report();
    for (DriverReplay* const driver : {&robot_, &tracker_})
      if (DriverReport of = driver->report(); of.calls > 0) report_.drivers.push_back(std::move(of));
    report_.damage = std::move(damage);
    return std::move(report_);
  }

 private:
  void count(const Record& record) {
    if (report_.records++ == 0) report_.begin_ns = report_.end_ns = record.time_ns;
    report_.begin_ns = std::min(report_.begin_ns, record.time_ns);
    report_.end_ns = std::max(report_.end_ns, record.time_ns);
  }

  void miss(const Record& record) {
    std::uint64_t dropped = 0;
    std::from_chars(record.bytes.data(), record.bytes.data() + record.bytes.size(), dropped);
    report_.dropped += dropped;
    stream_.miss();
    for (auto& [wire, device] : devices_) device.miss();
    robot_.miss();
    tracker_.miss();
  }

  void of_wire(const Record& record) {
    if (record.wire == Wire::Robot) return;
    if (record.wire != Wire::Rsi)
      return devices_.try_emplace(record.wire, record.wire).first->second.take(record);
    has_rsi_ = true;
    stream_.take(record);
  }

  /// A robot's has two wires besides that of its calls.
  void of_driver(const Record& record) {
    const Wire driver = record.wire == Wire::Tracker ? Wire::Tracker : Wire::Robot;
    if (record.wire == Wire::Rsi || only_.value_or(driver) != driver) return;
    (driver == Wire::Tracker ? tracker_ : robot_).take(record);
  }

  StreamReplay stream_;
  std::optional<Wire> only_;
  DriverReplay robot_{"robot"}, tracker_{"tracker"};
  bool has_rsi_ = false;
  std::map<Wire, DeviceReplay> devices_;
  ReplayReport report_;
};

}  // namespace

bool ReplayReport::same() const {
  return stream.different == 0 &&
         std::ranges::none_of(drivers, [](const DriverReport& driver) { return driver.different > 0; }) &&
         std::ranges::none_of(wires, [](const WireReport& wire) { return wire.regression.has_value(); });
}

std::expected<ReplayReport, std::string> replay(const recording::Recording& recording,
                                                std::optional<Wire> only) {
  auto stream = StreamReplay::create(recording.header());
  if (!stream) return std::unexpected(stream.error());
  Replayed replayed{*std::move(stream), only};
  std::string damage = recording.for_each([&](const Record& record) { replayed.take(record); });
  return replayed.report(std::move(damage));
}

}  // namespace truepose::daemon
