// The signal flow of RSI, in both formats. One that is accepted is linted, and executed by the simulated
// controller where it knows the objects: corrections stay within the limits that the context has.
#include <cmath>
#include <string>

#include "proto/rsi/context.hpp"
#include "proto/text/message.hpp"
#include "tests/fuzz/target.hpp"
#include "tools/sim/controller/rsi_flow.hpp"

namespace truepose::fuzz {
namespace {

const rsi::EthernetConfig& ethernet() {
  static const rsi::EthernetConfig config =
      rsi::parse_ethernet_config(
          "<ROOT><CONFIG><IP_NUMBER>127.0.0.1</IP_NUMBER><PORT>49152</PORT><SENTYPE>T</SENTYPE>"
          "<ONLYSEND>FALSE</ONLYSEND></CONFIG><SEND><ELEMENTS/></SEND><RECEIVE><ELEMENTS>"
          "<ELEMENT TAG=\"Stop\" TYPE=\"BOOL\" INDX=\"7\" HOLDON=\"1\"/></ELEMENTS></RECEIVE></ROOT>")
          .value();
  return config;
}

void execute(const rsi::Context& context) {
  const auto flow = sim::RsiFlow::of(context);
  if (!flow) return expect(!flow.error().empty(), "a refusal says why");
  sim::FlowSources sources;
  sources.sen_pint = [](int) { return 1; };
  static_cast<void>(flow->sent(sources));
  sim::ChannelValues received;
  for (int channel = 1; channel <= 64; ++channel) received[channel] = channel % 2 ? 1e6 : -1e6;
  const sim::FlowEffects effects = flow->effects(sources, received);
  for (std::size_t i = 0; i < effects.correction_deg.size(); ++i) {
    const rsi::ContextObject* const correction = context.of_type("AXISCORR");
    if (correction == nullptr) continue;
    const auto upper_deg = correction->number("UpperLimA" + std::to_string(i + 1));
    expect(!upper_deg || effects.correction_deg[i] <= std::max(*upper_deg, 0.0), "AXISCORR clamps");
  }
}

}  // namespace

void rsi_context(std::string_view bytes) {
  const auto context = rsi::parse_context(bytes);
  if (!context) return expect(!context.error().empty(), "a refusal says why");
  for (const Message& found : rsi::lint(*context, ethernet(), {}))
    expect(!found.what.empty(), "a finding says what");
  execute(*context);
}

}  // namespace truepose::fuzz
