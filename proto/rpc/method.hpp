#pragma once

#include <concepts>
#include <string_view>
#include <vector>

#include "proto/control/access.hpp"
#include "proto/control/request.hpp"
#include "proto/record/io.hpp"

/// Methods and events of the control protocol. A request is a record of the method's parameters. It names
/// the record of the answer, its Result, and describes the method. openrpc.json is made from these.
namespace truepose::rpc {

using control::ErrorCode;
using control::Role;
using record::Io;

/// Of what names a campaign, a model, a job: an empty text names none, not even the usual one.
inline constexpr record::Size kIdSize{1, 64};

struct Method {
  std::string_view name;
  Role role = Role::Viewer;  ///< the least that may call it; above a viewer it is a command
  std::string_view summary;
  std::string_view description{};
  std::vector<ErrorCode> errors{};
  /// Takes motion, a correction or control away: carried out even where it cannot be put on record.
  bool is_always_carried_out = false;
  bool is_long = false;  ///< clients are shown that it may be called as a job
};

template <class T>
concept Request = requires {
  typename T::Result;
  { T::method() } -> std::same_as<const Method&>;
};

/// Whether a method has requests of this type.
template <Request T>
bool is_of(std::string_view method) {
  return method == T::method().name;
}

/// A request that has none.
struct NoParameters {};
inline void layout(Io&, NoParameters&) {}

/// The data of an event, which knows its topic.
template <class T>
concept Event = requires {
  { T::kTopic } -> std::convertible_to<control::Topic>;
};

/// A method, with the layouts of its parameters and of its result.
struct Described {
  const Method* method;
  void (*params)(Io&);
  void (*result)(Io&);
};

template <class Record>
void describe(Io& io) {
  Record x{};
  io.value(x);
}

template <Request T>
Described described() {
  return {&T::method(), describe<T>, describe<typename T::Result>};
}

}  // namespace truepose::rpc
