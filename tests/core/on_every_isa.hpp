#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/kernels/kernels.hpp"
#include "core/math/random.hpp"

namespace truepose::example {

/// An arm of `types` (R or P) with everything that could go wrong: betas, both signs, a turned flange.
RobotModel random_arm(const std::string& types, Random& random);

/// Types of arms of 1 to 16 joints.
inline const std::vector<std::string> kArms{"RRRRRR", "RRRRRRR",   "PRRRRRR", "RRRRRRRR",        "RPR",
                                            "P",      "RRPRRRPRR", "R",       "RRRRRRRRRRRRRRRR"};

/// The KR 210 R2700-2 and, in `calibrated`, the errors of the method's paper (table 2).
RobotModel kr210(bool calibrated);

/// What every instruction set of this machine must say alike.
class OnEveryIsa : public testing::TestWithParam<kernels::Isa> {
 protected:
  void SetUp() override {
    if (!kernels::available(GetParam())) GTEST_SKIP() << "this machine or build has no such instruction set";
  }
  const kernels::Kernels& code() const { return kernels::kernels_for(GetParam()); }
};

inline const auto kEveryIsa =
    testing::Values(kernels::Isa::Baseline, kernels::Isa::Avx2, kernels::Isa::Avx512);

inline std::string isa_name(const testing::TestParamInfo<kernels::Isa>& isa) {
  return isa.param == kernels::Isa::Baseline ? "Baseline"
         : isa.param == kernels::Isa::Avx2   ? "Avx2"
                                             : "Avx512";
}

}  // namespace truepose::example
