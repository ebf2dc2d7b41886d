#include "tools/experiment/experiment_document.hpp"

#include <fmt/format.h>

#include <array>

#include "core/named.hpp"
#include "proto/record/calibration_document.hpp"
#include "proto/record/io.hpp"

namespace truepose {
namespace {

constexpr std::array kTrialDataNames{Named{"noise-free", TrialData::NoiseFree},
                                     Named{"noisy", TrialData::Noisy},
                                     Named{"outliers", TrialData::GrossErrors}};

}  // namespace

/// What the options say of how far readings and first guesses are off.
struct ExperimentNoise {
  ExperimentOptions& options;
};

void layout(record::Io& io, GrossErrors& x) {
  io("fraction", x.fraction);
  io("min", x.min_mm);
  io("max", x.max_mm);
}
void layout(record::Io& io, GuessError& x) {
  io("base", x.base_mm);
  io("base_rad", x.base_rad);
  io("smr", x.smr_mm);
}
void layout(record::Io& io, const ExperimentNoise& x) {
  io("tracker", x.options.tracker_noise_mm);
  io("repeatability", x.options.repeatability_mm);
  io("gross", x.options.gross);
  io("guess", x.options.guess);
}
void layout(record::Io& io, MethodResult& x) {
  io("method", x.method);
  io("data", x.data, kTrialDataNames);
  io.nullable("validation", x.validation);
  io.nullable("quartiles", x.quartiles_mm);
  io.nullable("rmse_over_bound", record::Unless{0.0, x.rmse_over_bound});
  io("converged", x.converged);
  io("iterations", x.iterations);
  io("time_s", x.time_s);
  io("convergence", x.convergence_mm);
  io("errors", x.errors_mm);
  io.where(x.data == TrialData::GrossErrors, "within_2_percent_of_oracle", x.within_2_percent_of_oracle);
}
void layout(record::Io& io, DesignResult& x) {
  io("design", x.design);
  io("poses", x.poses);
  io("rms", x.rms_mm);
  io("max", x.max_mm);
}
void layout(record::Io& io, LayerResult& x) {
  io("layer", x.layer);
  io("rigid", x.rigid);
  io("poses", x.poses);
  io("backlash_deg", x.backlash_deg);
  io("validation", x.validation);
  io("model_rms", x.model_rms_mm);
}
void layout(record::Io& io, PublishedComparison& x) {
  io("figure", x.figure);
  io("source", x.source);
  io("published_mean", x.published_mean_mm);
  io("mean", x.mean_mm);
  io("explanation", x.explanation);
}
void layout(record::Io& io, ExperimentDocument& x) {
  io("seed", x.options.seed);
  io("trials", x.options.trials);
  io("noise", ExperimentNoise{x.options});
  io("bound_rms", x.result.bound_rms_mm);
  io("methods", x.result.methods);
  io("designs", x.result.designs);
  io("layers", x.result.layers);
  io("published", x.result.published);
}

std::string title_of(const MethodResult& method) {
  if (method.data == TrialData::Noisy) return method.method;
  return fmt::format("{}, {}", method.method, name_of(kTrialDataNames, method.data));
}

std::string arm_title(const LayerResult& layer) {
  const std::string arm =
      layer.rigid ? "Rigid arm" : fmt::format("Heavy arm, backlash {} deg", layer.backlash_deg);
  return fmt::format("{}, {} poses", arm, layer.poses);
}

}  // namespace truepose
