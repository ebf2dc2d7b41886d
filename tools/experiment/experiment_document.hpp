#pragma once

#include <string>

#include "proto/record/layout.hpp"
#include "tools/experiment/experiment.hpp"

namespace truepose {

/// The document of one experiment, as `truepose-experiment --json` prints it. mm.
struct ExperimentDocument {
  ExperimentOptions options;
  ExperimentResult result;
};
void layout(record::Io& io, ExperimentDocument& x);

/// "two-stage", "two-stage, outliers".
std::string title_of(const MethodResult& method);
/// "Heavy arm, backlash 0.002 deg, 60 poses".
std::string arm_title(const LayerResult& layer);

}  // namespace truepose
