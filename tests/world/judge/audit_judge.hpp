#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/world/client.hpp"
#include "tests/world/methods.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges the audit trail by its files: each order of a client is in it once, with what became of it, and no
/// other order is.
class AuditJudge {
 public:
  AuditJudge(SoakLog& log, const Methods& methods) : log_{log}, methods_{methods} {}

  /// A request has its answer, or none.
  /// @param disk_fails  then what is always carried out is on record later, unless the daemon ends before
  void answered(const Client& client, const Request& request, bool disk_fails);
  /// Reads the trail of a store.
  void judge(const std::filesystem::path& store);

 private:
  struct Order {
    std::string text;                     // who and what
    std::vector<std::string> outcomes{};  // of each time that it was given; empty: no answer
    bool may_be_unrecorded = false;
  };
  struct Record {
    boost::json::object command;
    std::vector<std::string> results{};  // of what became of it
  };

  void take(const boost::json::object& record);
  void judge_order(const Order& order, const std::vector<const Record*>& records);

  SoakLog& log_;
  const Methods& methods_;
  std::map<std::string, Order> orders_;      // by their command_ids
  std::map<std::uint64_t, Record> records_;  // of commands, by their numbers
  std::uint64_t last_ = 0;                   // number of a record
};

}  // namespace truepose::world
