// The RSI ethernet configuration. With one that is accepted, replies can be written and read.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <pugixml.hpp>
#include <string>

#include "core/math/angles.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "proto/text/message.hpp"
#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {
namespace {

bool receives(const rsi::EthernetConfig& config, const std::string& tag, rsi::ElementType type) {
  return std::ranges::any_of(config.receive, [&](const rsi::Element& element) {
    return element.tag == tag && element.type == type;
  });
}

/// The names that replies use are those that the controller listens to.
void expect_names_of_the_file(const rsi::EthernetConfig& config) {
  expect(!config.stop || receives(config, *config.stop, rsi::ElementType::Bool), "Stop is received");
  for (const char axis : std::string_view{"123456"}) {
    expect(!config.axis_correction ||
               receives(config, *config.axis_correction + ".A" + axis, rsi::ElementType::Double),
           "every axis of the correction is received");
  }
}

/// As another reader than ours sees it.
void expect_well_formed(std::string_view reply, const rsi::EthernetConfig& config) {
  pugi::xml_document document;
  expect(document.load_buffer(reply.data(), reply.size()), "a reply is well formed: " + std::string{reply});
  expect(document.child("Sen").attribute("Type").value() == config.sentype, "a reply is of the right type");
  expect(document.child("Sen").child("IPOC").text().as_int() == 4711, "a reply has its IPOC");
}

}  // namespace

void rsi_config(std::string_view input) {
  const auto config = rsi::parse_ethernet_config(input);
  if (!config) {
    expect(!config.error().empty(), "a refusal says why");
    return;
  }
  for (const Message& found : rsi::lint(*config)) expect(!found.what.empty(), "a finding says what");

  expect_names_of_the_file(*config);

  const rsi::SensorFrameCodec codec{*config};
  const rsi::Axes correction_deg{0.1, -0.2, 0.3, -1.25, 2.5, 0};
  rsi::SensorFrame frame{.ipoc = 4711, .axis_correction_rad = correction_deg, .stop = false};
  for (double& axis : *frame.axis_correction_rad) axis *= kRadPerDeg;
  std::array<char, rsi::kMaxFrameBytes> buffer;
  const auto text = codec.encode(frame, buffer);
  expect(text.has_value(), "a reply fits into its buffer");
  expect_well_formed(*text, *config);
  const auto again = codec.decode(*text);
  expect(again.has_value(), "a reply is read again: " + std::string{*text});
  expect(again->ipoc == frame.ipoc, "a reply has its IPOC");
  expect(again->stop == (config->stop ? frame.stop : std::nullopt), "a reply stops where it can");
  expect(again->axis_correction_rad.has_value() == config->axis_correction.has_value(),
         "a reply corrects where it can");
  for (std::size_t i = 0; again->axis_correction_rad && i < correction_deg.size(); ++i) {
    const double back_deg = (*again->axis_correction_rad)[i] * kDegPerRad;
    expect(std::abs(back_deg - correction_deg[i]) < 1e-6, "a reply has its correction");
  }
}

}  // namespace truepose::fuzz
