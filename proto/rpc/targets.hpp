#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

/// targets.compensate
struct TargetsCompensate {
  struct Result {
    std::vector<std::vector<double>> joints{};
    std::vector<double> residual_mm{};
    std::vector<double> residual_deg{};
    std::vector<std::uint64_t> iterations{};
    std::vector<bool> damped{};
  };
  static const Method& method();

  std::optional<std::vector<std::vector<double>>> joints{};
  std::optional<std::vector<std::vector<double>>> poses{};
  std::optional<std::string> model_id{};
  std::optional<int> tool{};
  std::optional<std::vector<std::vector<double>>> payload{};
};
void layout(Io& io, TargetsCompensate& x);
void layout(Io& io, TargetsCompensate::Result& x);

/// The methods of this file.
std::vector<Described> targets_methods();

}  // namespace truepose::rpc
