#pragma once

#include <optional>
#include <string>

#include "core/identify/measurement.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace truepose::tools {

/// What blurs a measured point, as the command line says it. Checked by the parser; empty where not given.
struct NoiseOptions {
  std::string tracker, repeatability;
};

void add_noise_options(CLI::App& app, NoiseOptions& options);

/// Nothing where neither is given: all points are taken alike.
std::optional<MeasurementNoise> noise_of(const NoiseOptions& options);

}  // namespace truepose::tools
