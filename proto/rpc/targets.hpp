#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/campaign.hpp"
#include "proto/rpc/method.hpp"

namespace truepose::rpc {

/// targets.compensate
struct TargetsCompensate {
  struct Result {
    std::vector<std::vector<double>> joints{};
    std::vector<double> residual_mm{};
    std::vector<double> residual_deg{};
    std::vector<int> iterations{};
    std::vector<bool> damped{};
  };
  static const Method& method();

  std::vector<std::vector<double>> joints{};
  std::vector<PoseRow> poses{};
  std::optional<std::string> model_id{};
  std::optional<int> tool{};
  std::vector<Eigen::Vector4d> payload{};
};
void layout(Io& io, TargetsCompensate& x);
void check(const Io& io, const TargetsCompensate& x);
void layout(Io& io, TargetsCompensate::Result& x);

/// The methods of this file.
std::vector<Described> targets_methods();

}  // namespace truepose::rpc
