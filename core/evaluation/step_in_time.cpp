#include "core/evaluation/step_in_time.hpp"

#include "core/calibration/identifiability.hpp"
#include "core/calibration/measurement_model.hpp"
#include "core/calibration/parameters.hpp"
#include "core/evaluation/chi_square.hpp"
#include "core/evaluation/drift_causes.hpp"
#include "core/linear_algebra/decompositions.hpp"
#include "core/linear_algebra/products.hpp"

namespace truepose {
namespace {

constexpr std::size_t kFewest = 3;  // points before and after a step: fewer are single readings
constexpr double kHalved = 0.5;     // of the standard deviation
constexpr int kUnknowns = ParameterLayout::kBase;

/// Orthonormal columns that span those of A.
Eigen::MatrixXd span_of(const Eigen::MatrixXd& A) {
  const Svd svd = thin_svd(A * column_norms(A).cwiseInverse().asDiagonal());
  return svd.U.leftCols((svd.s.array() > kRankTolerance * svd.s[0]).count());
}

/// What of a step's six columns, and of the residuals, is left beside the parameters.
struct Beside {
  const Eigen::MatrixXd& U;
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& A) const { return A - times(U, transposed_times(U, A)); }
};

}  // namespace

std::optional<StepInTime> step_in_time(const CalibratedCell& cell, std::span<const Measurement> points,
                                       const MeasurementNoise& stated) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, f, J);
  const Eigen::MatrixXd moves = J.leftCols<kUnknowns>();  // mm at each point
  const Whitening whitening = whitening_of(points, stated);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix3d W = whitening.W[i] / whitening.finest_mm;
    f.segment<3>(row) = W * f.segment<3>(row).eval();
    J.middleRows<3>(row) = W * J.middleRows<3>(row).eval();
  }
  const Eigen::MatrixXd U = span_of(J);
  const Beside beside{U};
  const Eigen::VectorXd r = beside(-f);
  const auto degrees = static_cast<int>(f.size() - U.cols());
  if (degrees <= kUnknowns || chi_square_tail(r.squaredNorm(), degrees) >= kSignificance) return std::nullopt;

  std::optional<StepInTime> found;
  double least = kHalved * kHalved * r.squaredNorm() / degrees * (degrees - kUnknowns);
  for (std::size_t first = kFewest; first + kFewest <= points.size(); ++first) {
    const auto rows = 3 * static_cast<Eigen::Index>(points.size() - first);
    Eigen::MatrixXd step = Eigen::MatrixXd::Zero(f.size(), kUnknowns);
    step.bottomRows(rows) = J.leftCols<kUnknowns>().bottomRows(rows);
    const Eigen::VectorXd scale = column_norms(step).cwiseInverse();
    const Eigen::MatrixXd A = beside(step) * scale.asDiagonal();
    const Eigen::VectorXd x = smallest_solution(A, r, kRankTolerance);
    const double left = (times(A, x) - r).squaredNorm();
    if (left >= least) continue;
    least = left;
    const Eigen::VectorXd moved = times(moves.bottomRows(rows), scale.cwiseProduct(x));
    found = StepInTime{.first = first, .moved_mm = moved.reshaped(3, rows / 3).colwise().norm().mean()};
  }
  return found;
}

}  // namespace truepose
