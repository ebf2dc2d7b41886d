#pragma once

#include "tools/bench/jobs.hpp"

namespace truepose::bench {

/// Ceres as its documentation leads one to use it: automatic derivatives, the base, the reflector and the
/// links as a block each, DENSE_QR, defaults; what must not move is held by a manifold.
CalibratedCell fit_ceres_auto(const Identification& job);

/// Ceres at its best here: analytic derivatives to the 27 free parameters alone, DENSE_NORMAL_CHOLESKY, and a
/// trust region so wide that every step is a full one.
CalibratedCell fit_ceres_tuned(const Identification& job);

}  // namespace truepose::bench
