#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

struct Control {
  std::optional<std::string> holder{};
  std::optional<Role> role{};
  std::optional<std::chrono::seconds> left_s{};
};
void layout(Io& io, Control& x);

/// What every command takes besides the parameters of its method.
struct CommandId {
  std::optional<std::string> command_id{};
};
void layout(Io& io, CommandId& x);

/// A command before it is carried out (who, role, from, method, params), or what became of it (of,
/// result)
struct AuditRecord {
  std::uint64_t n = 0;
  std::string before{};
  std::string time{};
  std::optional<std::string> who{};
  std::optional<std::string> role{};
  std::optional<std::string> from{};
  std::optional<std::string> method{};
  std::optional<boost::json::object> params{};
  std::optional<bool> written_later{};
  std::optional<std::uint64_t> missed{};
  std::optional<std::uint64_t> of{};
  std::optional<std::string> result{};
  std::optional<std::string> message{};
  std::optional<std::string> command_id{};
  std::optional<boost::json::value> answer{};
  std::optional<std::string> put_aside{};
};
void layout(Io& io, AuditRecord& x);

/// control.get
struct ControlGet : NoParameters {
  using Result = Control;
  static const Method& method();
};

/// control.acquire
struct ControlAcquire {
  using Result = Control;
  static const Method& method();

  std::optional<std::chrono::seconds> lease_s{};
};
void layout(Io& io, ControlAcquire& x);

/// control.takeover
struct ControlTakeover : ControlAcquire {
  static const Method& method();
};

/// control.release
struct ControlRelease : NoParameters {
  using Result = Control;
  static const Method& method();
};

/// audit.list
struct AuditList {
  struct Result {
    std::vector<AuditRecord> records{};
  };
  static const Method& method();

  std::optional<std::uint64_t> before{};
  std::optional<std::size_t> limit{};
};
void layout(Io& io, AuditList& x);
void layout(Io& io, AuditList::Result& x);

/// audit.acknowledge
struct AuditAcknowledge {
  struct Result {
    std::string acknowledged{};
  };
  static const Method& method();

  std::string name{};
};
void layout(Io& io, AuditAcknowledge& x);
void layout(Io& io, AuditAcknowledge::Result& x);

/// The methods of this file.
std::vector<Described> control_methods();

}  // namespace truepose::rpc
