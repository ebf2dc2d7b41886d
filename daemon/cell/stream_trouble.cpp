#include "daemon/cell/stream_trouble.hpp"

#include <cstdio>

namespace truepose::daemon {

namespace {

std::string seconds_text(drivers::Duration time) {
  std::array<char, 32> seconds;
  std::snprintf(seconds.data(), seconds.size(), "%.1f s", std::chrono::duration<double>(time).count());
  return seconds.data();
}

}  // namespace

std::string silence_text(std::optional<drivers::Duration> silence) {
  if (!silence) return "the controller has sent no RSI packet yet";
  return "the controller has sent no RSI packet for " + seconds_text(*silence);
}

std::string old_packet_text(const StreamStatus& status, std::optional<drivers::Duration> age) {
  const auto known = silence(status);
  if (!age || !known || *known >= kSilence) return silence_text(age);
  return "this PC has not run truepose's RSI thread for " + seconds_text(*age - *known) +
         ": look at its load, and at the scheduling that the log names at the start";
}

std::string no_answer_text(const StreamStatus& before, const StreamStatus& now, const RefusedPackets& refused,
                           const config::CellConfig& config) {
  if (std::string why = reason(now); !why.empty()) return why;
  const StreamCounters &was = before.counters, &is = now.counters;
  const std::string port = config.stream.listen.host + ":" + std::to_string(config.stream.listen.port);
  const std::string file = config.stream.ethernet_xml.string();
  if (is.malformed > was.malformed) {
    return std::to_string(is.malformed - was.malformed) + " packets came to " + port +
           " and none was understood: " + refused.malformed +
           "; the ethernet configuration on the controller must be the one that truepose reads, " + file +
           ": load that one there";
  }
  if (is.foreign > was.foreign && refused.foreign) {
    return std::to_string(is.foreign - was.foreign) + " packets came to " + port +
           ", but not from the controller (" + config.robot.rsi_peer + "): the last new sender is " +
           text(*refused.foreign) +
           "; if that is the controller's address in the RSI network, give it as robot.rsi_peer and restart "
           "trueposed, else look where the controller sends to, and stop that sender";
  }
  if (is.wrong_ipoc > was.wrong_ipoc || is.unproven > was.unproven)
    return "the controller's packets follow no order: its IPOC does not rise from packet to packet";
  return "no packet came to " + port +
         ": this address must be IP_NUMBER and PORT of the ethernet configuration on the controller (here " +
         file +
         "), its RSI network must be the one of this card, no firewall may drop UDP, and the program must "
         "have come to RSI_ON; where the pendant shows RSITimeout, it has, and the packets go elsewhere";
}

}  // namespace truepose::daemon
