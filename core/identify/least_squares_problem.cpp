#include "core/identify/least_squares_problem.hpp"

#include <utility>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/step_count.hpp"

namespace truepose {

LinearSystem linearise(const CalibratedCell& cell, const LeastSquaresProblem& problem) {
  count_step();
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, problem.points, f, J);

  const Eigen::VectorXd& weight = problem.prior.weight;
  std::vector<std::size_t> known;
  for (std::size_t k = 0; weight.size() > 0 && k < problem.free.size(); ++k) {
    if (weight[problem.free[k]] > 0) known.push_back(k);
  }
  LinearSystem system;
  const auto columns = static_cast<Eigen::Index>(problem.free.size());
  if (columns == J.cols() && known.empty() && problem.W.empty()) return {std::move(f), std::move(J)};
  system.f.resize(f.size() + static_cast<Eigen::Index>(known.size()));
  system.J.resize(system.f.size(), columns);
  system.f.head(f.size()) = f;
  for (Eigen::Index k = 0; k < columns; ++k) {
    system.J.col(k).head(f.size()) = J.col(problem.free[static_cast<std::size_t>(k)]);
  }
  for (std::size_t i = 0; i < problem.W.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    system.f.segment<3>(row) = (problem.W[i] * system.f.segment<3>(row)).eval();
    system.J.middleRows<3>(row) = (problem.W[i] * system.J.middleRows<3>(row)).eval();
  }

  if (known.empty()) return system;
  const Eigen::VectorXd values = parameter_values(cell);
  Eigen::Index row = f.size();
  for (const std::size_t k : known) {
    const int parameter = problem.free[k];
    system.J.row(row).setZero();
    system.J(row, static_cast<Eigen::Index>(k)) = weight[parameter];
    system.f[row] = weight[parameter] * (values[parameter] - problem.prior.centre[parameter]);
    ++row;
  }
  return system;
}

Eigen::VectorXd scattered(const Eigen::VectorXd& step, const std::vector<int>& free, int size) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(size);
  for (std::size_t k = 0; k < free.size(); ++k) all[free[k]] = step[static_cast<Eigen::Index>(k)];
  return all;
}

}  // namespace truepose
