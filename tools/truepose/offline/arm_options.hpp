#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/data/measurement.hpp"
#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

/// The files that say which arm a command is about.
struct ArmFiles {
  std::filesystem::path robot;
  std::filesystem::path model;  ///< empty = none given
};

/// A word on standard error where the model failed a test of its verdict when it was made.
///
/// @param place  that it was read from
void report_failed_verdict(const config::ModelFile& model, const std::string& place);

/// Reads a model file, with that word and one where it carries no hash. Throws ConfigError.
config::ModelFile load_model_to_use(const std::filesystem::path& file);

/// The same, but refuses one of another arm than `nominal`. Throws ConfigError.
config::ModelFile load_model_of(const RobotModel& nominal, const std::filesystem::path& file);

/// Warns if the arm's payload is not stated, and that matters: it was measured under several payloads.
///
/// @param file       that the model was read from
/// @param to_say_it  how it is said
void note_open_payload(const config::ModelFile& model, const std::filesystem::path& file,
                       const char* to_say_it = "give the robot file its payload, and calibrate again");

/// The model with its drives so warm, or where none is said and it knows what warmth does, a word on which it
/// is taken for.
///
/// @param file  that it was read from
config::ModelFile as_warm(config::ModelFile model, std::span<const double> temperature_c,
                          const std::filesystem::path& file);

/// What blurs a measured point, as the command line says it. Checked by the parser; empty where not given.
struct NoiseOptions {
  std::string tracker, repeatability;
};

Option tracker_noise_option(NoiseOptions& noise);
Option repeatability_option(NoiseOptions& noise);

/// Nothing where neither is given: all points are taken alike.
std::optional<MeasurementNoise> noise_of(const NoiseOptions& options);

}  // namespace truepose::tools
