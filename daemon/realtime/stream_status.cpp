#include "daemon/realtime/stream_status.hpp"

#include <algorithm>
#include <cstdio>

namespace truepose::daemon {
namespace {

std::string number(const char* format, double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string deg(double value) { return number("%.3f", value) + " deg"; }

std::string axis(const FaultDetail& detail) { return "A" + std::to_string(detail.axis); }

/// What an element is watched for.
std::string_view shown_by(std::string_view element) {
  if (element == "Delay") return "which replies it has taken";
  if (element == "AIPos") return "whether the arm follows the correction";
  return "whether it is the arm of robot.file";
}

std::string fault_reason(StreamFault fault, const FaultDetail& detail) {
  switch (fault) {
    case StreamFault::None:
      return "";
    case StreamFault::NotFollowing:
      return "the axes do not follow the correction: " + axis(detail) + " is sent " + deg(detail.limit) +
             " and AIPos - ASPos shows " + number("%.2f", detail.value) + " +- " +
             number("%.2f", detail.uncertain) + " deg" +
             "; the robot program is stopped or not at RSI_MOVECORR, or the ethernet configuration on the "
             "controller has another name for the correction than the one that truepose reads "
             "(stream.ethernet_xml), or the RSI context does not lead it to AXISCORR: put that right, then "
             "acknowledge";
    case StreamFault::BoundBroken:
      return "the model asked for more than the correction bounds allow for too long: " + axis(detail) +
             " by " + deg(detail.value) + ", where the bound is " + deg(detail.limit) +
             "; check the model and the bounds, then acknowledge";
    case StreamFault::NoSolution:
      return "the calibrated arm cannot reach the commanded poses, or only by corrections as large as a "
             "singularity asks for; check the program and the model, then acknowledge";
    case StreamFault::RepliesRejected:
      return "the controller does not take replies that were sent in time: the ethernet configuration on it "
             "has another SENTYPE or other names than the one that truepose reads (stream.ethernet_xml): "
             "load that one there, then acknowledge";
    case StreamFault::WrongCycle:
      return "the controller's IPOC rises by " + number("%.0f", detail.value) +
             " from packet to packet, but stream.cycle_ms is " + number("%.0f", detail.limit) +
             ": set stream.cycle_ms to the cycle in which the program starts RSI (4 for #IPO_FAST, 12 for "
             "#IPO) and restart trueposed, or start RSI in the other, then acknowledge";
    case StreamFault::NotSent: {
      const std::string element{detail.element};
      return "the controller's packets have no " + element +
             " that can be read, and without it nobody sees " + std::string{shown_by(element)} +
             ": the ethernet configuration on the controller is another than the one that truepose reads "
             "(stream.ethernet_xml), which sends DEF_" +
             element + ": load that one there, then acknowledge";
    }
    case StreamFault::WrongArm:
      return "the controller's pose RIst is " + number("%.1f", detail.value) +
             " mm from where the robot file's arm has its flange at AIPos (allowed " +
             number("%.1f", detail.limit) +
             "): it is another arm, or the program has a tool or a base: correct robot.file, or start RSI "
             "with tool 0 and base 0 (BAS(#TOOL,0) and BAS(#BASE,0) before RSI_ON), then acknowledge";
  }
  return "";
}

}  // namespace

std::string_view name(StreamState state) {
  switch (state) {
    case StreamState::Idle:
      return "idle";
    case StreamState::Unproven:
      return "unproven";
    case StreamState::RampingIn:
      return "ramping in";
    case StreamState::Active:
      return "active";
    case StreamState::RampingOut:
      return "ramping out";
    case StreamState::Frozen:
      return "frozen";
    case StreamState::Fault:
      return "fault";
  }
  return "unknown";
}

std::optional<drivers::Duration> silence(const StreamStatus& status) {
  if (!status.heard) return std::nullopt;
  return std::max(drivers::Duration{0}, status.read_until - *status.heard);
}

std::string reason(const StreamStatus& status) {
  if (status.state == StreamState::Unproven)
    return "what correction the controller has in force is not known, and any answer could be a jump: it is "
           "answered as soon as the arm stands, or has a new session and no correction";
  return fault_reason(status.fault, status.detail);
}

std::string Excerpt::text() const {
  std::string text{bytes.data(), size};
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, '.');
  return text;
}

}  // namespace truepose::daemon
