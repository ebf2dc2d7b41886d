#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/campaign.hpp"
#include "proto/rpc/cell.hpp"
#include "proto/rpc/method.hpp"
#include "proto/rpc/model.hpp"

namespace truepose::rpc {

/// events.subscribe
struct EventsSubscribe {
  struct Result {
    struct Missing {
      std::uint64_t first = 0;
      std::uint64_t last = 0;
      std::string reason{};
    };
    std::vector<control::Topic> topics{};
    std::uint64_t next = 0;
    std::uint64_t oldest = 0;
    bool complete = false;
    std::vector<Missing> missing{};
  };
  static const Method& method();

  std::optional<std::vector<control::Topic>> topics{};
  std::optional<std::uint64_t> after{};
};
void layout(Io& io, EventsSubscribe& x);
void check(const Io& io, const EventsSubscribe& x);
void layout(Io& io, EventsSubscribe::Result& x);

/// events.unsubscribe
struct EventsUnsubscribe : NoParameters {
  struct Result {
    std::vector<control::Topic> topics{};
  };
  static const Method& method();
};
void layout(Io& io, EventsUnsubscribe::Result& x);

struct StateChanged {
  static constexpr auto kTopic = control::Topic::Cell;

  std::string state{};
  std::string from{};
  std::string reason{};
  std::optional<std::string> by{};
};
void layout(Io& io, StateChanged& x);

struct PointMeasured : SeenPoint {
  static constexpr auto kTopic = control::Topic::Measurement;

  std::string campaign_id{};
  std::optional<double> error_mm{};
  std::string reason{};
};
void layout(Io& io, PointMeasured& x);

struct ModelChanged {
  static constexpr auto kTopic = control::Topic::Model;

  std::optional<std::string> by{};
  std::string change{};
  ModelSummary model{};
};
void layout(Io& io, ModelChanged& x);

struct FaultChanged {
  static constexpr auto kTopic = control::Topic::Fault;

  Fault fault{};
  bool active = false;
};
void layout(Io& io, FaultChanged& x);

struct LogLine {
  static constexpr auto kTopic = control::Topic::Log;

  std::string level{};
  std::string text{};
};
void layout(Io& io, LogLine& x);

struct ControlChanged {
  static constexpr auto kTopic = control::Topic::Control;

  std::string change{};
  std::string by{};
  std::optional<std::string> from{};
  std::optional<std::string> method{};
  std::optional<std::string> result{};
};
void layout(Io& io, ControlChanged& x);

/// The methods of this file.
std::vector<Described> events_methods();

}  // namespace truepose::rpc
