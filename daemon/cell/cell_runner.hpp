#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/cell/cell_state.hpp"
#include "daemon/control/event_bus.hpp"
#include "daemon/fault_kinds.hpp"
#include "daemon/threads/signal.hpp"
#include "drivers/clock.hpp"
#include "proto/control/request.hpp"
#include "proto/rpc/cell.hpp"

namespace truepose::daemon {

/// The active faults, at most one of each code. An event reports each begin and end.
class ActiveFaults {
 public:
  ActiveFaults(EventBus& events, drivers::WallClock wall_clock)
      : events_{events}, wall_clock_{std::move(wall_clock)} {}

  /// Called with each fault that begins.
  void tell(std::function<void(const Fault& fault)> begun) { begun_ = std::move(begun); }
  /// In place of one that stands with the same code.
  void begin(Fault fault);
  void end(FaultCode code);
  /// Begins a fault and warns of it in the log, or ends it: it stands as long as its cause.
  void stand(bool stands, Fault fault);

  bool stands(FaultCode code) const { return faults_.contains(code); }
  /// What a fault says that stands; empty where it does not.
  std::string text(FaultCode code) const;
  /// In the order of their codes.
  std::vector<rpc::Fault> list() const;
  std::size_t count(std::string_view severity) const;

 private:
  struct Standing {
    Fault fault;
    std::string since;  ///< RFC 3339
    rpc::Fault described() const;
  };
  void publish(const Standing& fault, bool standing);

  EventBus& events_;
  drivers::WallClock wall_clock_;
  std::map<FaultCode, Standing> faults_;
  std::function<void(const Fault& fault)> begun_ = [](const Fault&) {};
};

/// Runs a cell's state machine: feeds it events, has its commands carried out, tells clients of its changes
/// and wakes who waits for them.
class CellRunner {
 public:
  /// @param reason  why the event came, in words
  using CarryOut = std::function<void(const std::string& reason)>;

  CellRunner(drivers::Clock& clock, EventBus& events, drivers::WallClock wall_clock, CellLimits limits = {});

  /// What carries out a command.
  void on(CellCommand command, CarryOut carry_out) { carry_out_[index(command)] = std::move(carry_out); }
  /// Says why no packet was answered, should a stream not start in time.
  void explain_by(std::function<std::string()> no_packet_answered) {
    no_packet_answered_ = std::move(no_packet_answered);
  }

  /// What else than the state a method needs: where it is not there, the method is not allowed.
  void possible_where(std::function<bool(std::string_view method)> possible) {
    possible_ = std::move(possible);
  }

  /// Feeds one event to the state machine and has its commands carried out.
  /// @param by  the user that caused it, for clients; empty: the daemon itself, or no user
  /// @return the refusal as an error, where there was one
  std::optional<control::RpcError> apply(const CellEvent& event, const std::string& reason,
                                         const std::string& by = {});
  /// Acknowledges what the cell's state is a fault by, and a stream that is frozen, whatever the state is.
  std::optional<control::RpcError> acknowledge(const std::string& by);

  /// Tells why the cell is in its state, where that has changed and the state has not.
  void reword(std::string reason);
  /// What is under way continues once the device answers; without a reason it does.
  void await(CellDevice device, const std::string& reason);

  std::string_view name() const { return state_name(state_); }
  template <typename State>
  const State* in() const {
    return std::get_if<State>(&state_);
  }
  bool streaming() const { return in<StreamStarting>() || in<Streaming>() || in<StreamStopping>(); }
  bool armed() const { return in<Armed>() || in<Disarming>(); }
  /// Whether corrections are sent, or would be sent on request.
  bool corrects() const { return streaming() || armed(); }
  /// The text of the fault that the cell is in, or another where it is in none.
  std::string fault_or(const std::string& other) const {
    return in<Faulted>() != nullptr ? in<Faulted>()->reason : other;
  }
  /// What the fault that the cell is in has ended was a stream.
  bool faulted_in_stream() const { return in<Faulted>() != nullptr && faulted_in_stream_; }
  control::RpcError wrong_state(std::string why, std::vector<std::string> allowed) const;
  control::RpcError wrong_state(std::string why) const { return wrong_state(std::move(why), allowed()); }
  /// The methods that the state carries out, less what a standing fault rules out or what is not possible
  /// now, and what a fault needs.
  std::vector<std::string> allowed() const;
  /// Whether that fault stands, and the method is not possible until it is acknowledged.
  bool rules_out(FaultCode fault, std::string_view method) const;
  /// One sentence: why the cell is in its state, or for which device it waits, how long already and why.
  std::string reason() const;
  /// What an operator does next, in one sentence.
  std::string next() const;
  /// The device that is waited for.
  std::optional<rpc::AwaitedDevice> awaited_device() const;
  bool waits() const { return waiting(state_).has_value(); }

  ActiveFaults& faults() { return faults_; }
  const ActiveFaults& faults() const { return faults_; }

  /// Wakes who waits for a change that is none of the state.
  void wake() { changed_.notify(); }
  /// Returns at the next change.
  boost::asio::awaitable<void> changed() { return changed_.wait(); }
  boost::asio::awaitable<void> changed_until(TimePoint when) { return changed_.wait_until(clock_, when); }
  /// Returns when the state is none of that kind any more.
  template <typename State>
  boost::asio::awaitable<void> while_in() {
    while (in<State>()) co_await changed();
  }

  /// Ends the states that have lasted too long. Ends when cancelled.
  boost::asio::awaitable<void> watch();

 private:
  static std::size_t index(CellCommand command) { return static_cast<std::size_t>(command); }
  void carry_out(CellCommand command, const std::string& reason) const;
  void tell(const CellState& before, const std::string& reason, const std::string& by);
  void report_waiting(const CellState& before);
  std::string waiting_for(const Waiting& wait) const;
  std::string paused_because(const Waiting& wait) const;

  drivers::Clock& clock_;
  EventBus& events_;
  drivers::WallClock wall_clock_;
  ActiveFaults faults_;
  std::array<CarryOut, kCellCommands> carry_out_;
  std::function<std::string()> no_packet_answered_;
  std::function<bool(std::string_view method)> possible_ = [](std::string_view) { return true; };
  CellLimits limits_;
  CellState state_ = Disconnected{};
  std::string reason_ = "started";
  bool faulted_in_stream_ = false;
  Signal changed_;
};

}  // namespace truepose::daemon
