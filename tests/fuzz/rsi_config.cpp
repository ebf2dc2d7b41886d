// The RSI ethernet configuration. With one that is accepted, replies can be written and read.
#include <array>
#include <cmath>
#include <optional>

#include "core/kinematics/angles.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {

void rsi_config(std::string_view input) {
  const auto config = rsi::parse_ethernet_config(input);
  if (!config) {
    expect(!config.error().empty(), "a refusal says why");
    return;
  }
  for (const std::string& warning : rsi::lint(*config)) expect(!warning.empty(), "a warning says what");

  const rsi::SensorFrameCodec codec{*config};
  const rsi::Axes correction_deg{0.1, -0.2, 0.3, -1.25, 2.5, 0};
  rsi::SensorFrame frame{.ipoc = 4711, .axis_correction_rad = correction_deg, .stop = false};
  for (double& axis : *frame.axis_correction_rad) axis *= kRadPerDeg;
  std::array<char, rsi::kMaxFrameBytes> buffer;
  const auto text = codec.encode(frame, buffer);
  expect(text.has_value(), "a reply fits into its buffer");
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
