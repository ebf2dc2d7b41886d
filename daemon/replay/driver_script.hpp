#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "daemon/recorder/driver_call.hpp"
#include "proto/recording/record.hpp"

namespace truepose::daemon {

/// What a stretch of a recording says of one driver: what was done to it, and what it did, in their order.
class DriverScript {
 public:
  /// @param records  of the driver and its wires, the first one of the kind Driver; outlive the script
  explicit DriverScript(std::span<const recording::Record> records);

  enum class Part { DoneTo, DoneBy, Neither };
  struct Step {
    const recording::Record* record = nullptr;
    Part part = Part::Neither;
    std::uint64_t call = 0;  ///< number, of a Call and an Outcome
    std::int64_t time_ns() const { return record->time_ns; }
  };
  /// As far as the records can be read.
  const std::vector<Step>& steps() const { return steps_; }
  /// Why the others cannot, one phrase; empty: all can.
  const std::string& unreadable() const { return unreadable_; }

  /// The steps that a driver does in this order: Sent and Closed of a wire, or Air.
  std::vector<std::size_t> done_by(recording::Wire wire) const;
  std::vector<std::size_t> asks_for_air() const;
  /// The step that tells how a call ended, be it cancelled.
  std::optional<std::size_t> outcome(std::uint64_t call) const;
  bool is_cancelled(std::uint64_t call) const { return cancelled_.contains(call); }
  /// Whether what was sent in this step did not come to its end.
  bool write_fails(std::size_t sent) const;

 private:
  std::string add(const recording::Record& record);
  std::string add_call(Step step);
  std::string add_outcome(Step step);

  std::vector<Step> steps_;
  std::string unreadable_;
  std::map<std::uint64_t, std::size_t> outcomes_;
  std::set<std::uint64_t> begun_, cancelled_;
  std::set<recording::Wire> connected_;
};

}  // namespace truepose::daemon
