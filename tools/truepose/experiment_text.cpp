#include "tools/truepose/experiment_text.hpp"

#include <fmt/format.h>

#include <string_view>

#include "tools/report/number_text.hpp"

namespace truepose::tools {
namespace {

using report::error_text;

std::string_view suffix_of(TrialData data) {
  switch (data) {
    case TrialData::NoiseFree:
      return ", noise-free";
    case TrialData::Noisy:
      return "";
    case TrialData::GrossErrors:
      break;
  }
  return ", gross errors";
}

std::string methods_text(const ExperimentResult& result) {
  std::string text = fmt::format("{:<40}{:>9}{:>9}{:>9}{:>10}{:>11}{:>7}{:>9}\n", "Method", "mean", "max",
                                 "RMS", "RMS/bound", "converged", "iter", "time");
  for (const MethodResult& method : result.methods) {
    const ErrorStatistics& errors = method.validation;
    text += fmt::format("{:<40}", method.method + std::string(suffix_of(method.data)));
    text += method.converged > 0 ? fmt::format("{:>9}{:>9}{:>9}", error_text(errors.mean),
                                               error_text(errors.max), error_text(errors.rms))
                                 : fmt::format("{:>9}{:>9}{:>9}", "-", "-", "-");
    text += method.rmse_over_bound > 0 ? fmt::format("{:>10.3f}", method.rmse_over_bound)
                                       : fmt::format("{:>10}", "-");
    text += fmt::format("{:>9.1f} %{:>7.1f}{:>6.1f} ms\n", 100 * method.converged, method.iterations,
                        1000 * method.time_s);
  }
  return text;
}

std::string designs_text(const ExperimentResult& result) {
  std::string text = fmt::format("\n{:<40}{:>7}{:>9}{:>9}\n", "Poses chosen", "poses", "RMS", "max");
  for (const DesignResult& design : result.designs) {
    text += fmt::format("{:<40}{:>7}{:>9}{:>9}\n", design.design, design.poses, error_text(design.rms_mm),
                        error_text(design.max_mm));
  }
  return text;
}

bool same_arm(const LayerResult& a, const LayerResult& b) {
  return a.rigid == b.rigid && a.poses == b.poses && a.backlash_deg == b.backlash_deg;
}

std::string layers_text(const ExperimentResult& result) {
  std::string text;
  const LayerResult* last = nullptr;
  for (const LayerResult& layer : result.layers) {
    if (last == nullptr || !same_arm(*last, layer)) {
      const std::string arm = layer.rigid ? std::string("Rigid arm")
                                          : fmt::format("Heavy arm, backlash {} deg", layer.backlash_deg);
      text += fmt::format("\n{:<40}{:>9}{:>9}{:>9}\n", fmt::format("{}, {} poses", arm, layer.poses), "mean",
                          "max", "RMS");
    }
    text += fmt::format("  {:<38}{:>9}{:>9}{:>9}\n", layer.layer, error_text(layer.validation.mean),
                        error_text(layer.validation.max), error_text(layer.validation.rms));
    last = &layer;
  }
  return text;
}

std::string published_text(const ExperimentResult& result) {
  std::string text = fmt::format("\n{:<40}{:>9}{:>9}\n", "Mean error, the paper's and ours", "paper", "ours");
  for (const PublishedComparison& pair : result.published) {
    text += fmt::format("{:<40}{:>9}{:>9}\n    {} ({}).\n", pair.figure, error_text(pair.published_mean_mm),
                        error_text(pair.mean_mm), pair.explanation.substr(0, pair.explanation.size() - 1),
                        pair.source);
  }
  return text;
}

}  // namespace

std::string experiment_text(const ExperimentOptions& options, const ExperimentResult& result) {
  return fmt::format(
             "{} trials (seed {}), {} + {} random poses each, tracker {} mm and repeatability {} mm per "
             "axis.\nErrors in mm at validation poses; the Cramer-Rao bound of their RMS is {} mm.\n\n",
             options.trials, options.seed, options.identify_poses, options.validate_poses,
             error_text(options.tracker_noise_mm), error_text(options.repeatability_mm),
             error_text(result.bound_rms_mm)) +
         methods_text(result) + designs_text(result) + layers_text(result) + published_text(result);
}

}  // namespace truepose::tools
