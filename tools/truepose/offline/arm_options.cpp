#include "tools/truepose/offline/arm_options.hpp"

#include <numeric>
#include <string_view>
#include <vector>

#include "config/model_update.hpp"
#include "config/number_text.hpp"
#include "core/formatted.hpp"

namespace truepose::tools {
namespace {

/// The numbers of "0.005,0.006", or none where they are not `count` numbers above 0.
std::vector<double> positive_numbers(std::string_view text, std::size_t count) {
  std::vector<double> numbers;
  while (true) {
    const std::size_t comma = text.find(',');
    const auto number = config::parse_number(text.substr(0, comma));
    if (!number || !(*number > 0)) return {};
    numbers.push_back(*number);
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  return numbers.size() == count ? numbers : std::vector<double>{};
}

Check positive(std::size_t count, const std::string& form) {
  return {"", [=](const std::string& text) -> std::string {
            if (!positive_numbers(text, count).empty()) return {};
            return config::in_quotes(text) + " is not " + form;
          }};
}

}  // namespace

void report_failed_verdict(const config::ModelFile& model, const std::string& place) {
  if (!model.verdict || !model.verdict->failed()) return;
  const VerdictColor color = model.verdict->color();
  const std::string to_do = color == VerdictColor::Red ? "do not use it" : "look into that before you use it";
  print_to_stderr(place + ": judged " + std::string{name_of(kVerdictColorNames, color)} +
                  " when it was made, " + to_do + ": " + model.verdict->findings.front().sentence);
}

config::ModelFile load_model_to_use(const std::filesystem::path& file) {
  config::ModelFile model = config::load_model(file);
  report_failed_verdict(model, file.string());
  return model;
}

config::ModelFile load_model_of(const RobotModel& nominal, const std::filesystem::path& file) {
  config::ModelFile model = config::load_model(file);
  if (model.name != nominal.name || model.cell.robot.joint_count() != nominal.joint_count()) {
    throw config::ConfigError(file.string() + ": the model of '" + model.name + "' with " +
                              std::to_string(model.cell.robot.joint_count()) +
                              " joints, but the robot file is of '" + nominal.name + "' with " +
                              std::to_string(nominal.joint_count()));
  }
  if (const auto why = config::other_nominal(nominal, model))
    throw config::ConfigError(file.string() + ": the model is refused: " + *why +
                              "; give the one that it was identified from, or identify again");
  if (const auto why = config::larger_correction(nominal, model.cell, config::poses_of(model.validation),
                                                 model.largest_correction_deg))
    throw config::ConfigError(file.string() + ": the model is refused: " + *why + "; identify again");
  report_failed_verdict(model, file.string());
  return model;
}

void note_open_payload(const config::ModelFile& model, const std::filesystem::path& file,
                       const char* to_say_it) {
  if (!config::is_payload_open(model)) return;
  print_to_stderr(file.string() +
                  ": measured under several payloads, and the arm's load is not given: it is taken to carry "
                  "nothing; " +
                  to_say_it);
}

config::ModelFile as_warm(config::ModelFile model, std::span<const double> temperature_c,
                          const std::filesystem::path& file) {
  if (!model.thermal || !temperature_c.empty()) return at_temperatures(std::move(model), temperature_c);
  const std::vector<double>& reference_c = model.thermal->reference_c;
  const double mean_c =
      std::accumulate(reference_c.begin(), reference_c.end(), 0.0) / static_cast<double>(reference_c.size());
  print_to_stderr(
      file.string() +
      formatted(": the temperature of the drives is not given: the arm is taken at the model's reference, "
                "%.1f C on average",
                mean_c));
  return model;
}

Option tracker_noise_option(NoiseOptions& noise) {
  return {"--tracker-noise",
          &noise.tracker,
          "Standard deviation of the tracker's reading along the beam (mm) and across it (mm per m of "
          "distance), where points do not state their sigma",
          {.check = positive(2, "RANGE_MM,TRANSVERSE_MM_PER_M, two numbers above 0 such as 0.01,0.006"),
           .type = "RANGE_MM,TRANSVERSE_MM_PER_M"}};
}

Option repeatability_option(NoiseOptions& noise) {
  return {"--repeatability",
          &noise.repeatability,
          "Standard deviation per axis of the arm's position when it returns to a pose, added to "
          "the tracker's noise",
          {.check = positive(1, "a length in mm above 0 such as 0.02"), .type = "MM"}};
}

std::optional<MeasurementNoise> noise_of(const NoiseOptions& options) {
  if (options.tracker.empty() && options.repeatability.empty()) return std::nullopt;
  MeasurementNoise noise;
  if (!options.tracker.empty()) {
    const std::vector<double> numbers = positive_numbers(options.tracker, 2);
    noise.tracker = {.range_mm = numbers[0], .transverse_mm_per_m = numbers[1]};
  }
  if (!options.repeatability.empty()) noise.repeatability_mm = positive_numbers(options.repeatability, 1)[0];
  return noise;
}

}  // namespace truepose::tools
