#include "core/fit/least_squares_problem.hpp"

#include <utility>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/target_turns.hpp"
#include "core/step_count.hpp"

namespace truepose {

LinearSystem linearise(const CalibratedCell& cell, const LeastSquaresProblem& problem) {
  count_step();
  LinearSystem system;
  residuals_with_jacobian(cell, problem.points, problem.free, system.f, system.J);
  for (std::size_t i = 0; i < problem.W.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    system.f.segment<3>(row) = (problem.W[i] * system.f.segment<3>(row)).eval();
    system.J.middleRows<3>(row) = (problem.W[i] * system.J.middleRows<3>(row)).eval();
  }
  append_turns(system, cell, problem);
  append_prior(system, cell, problem);
  return system;
}

std::vector<std::vector<int>> rows_of_points(const LeastSquaresProblem& problem) {
  std::vector<std::vector<int>> rows;
  const int points = static_cast<int>(problem.points.size());
  for (int i = 0; i < points; ++i) rows.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  int row = 3 * points;
  if (problem.turn_weight.empty()) return rows;
  for (const std::size_t i : oriented_points(problem.points)) {
    rows[i].insert(rows[i].end(), {row, row + 1, row + 2});
    row += 3;
  }
  return rows;
}

void append_prior(LinearSystem& system, const CalibratedCell& cell, const LeastSquaresProblem& problem) {
  const Eigen::VectorXd& weight = problem.prior.weight;
  std::vector<std::size_t> known;
  for (std::size_t k = 0; weight.size() > 0 && k < problem.free.size(); ++k) {
    if (weight[problem.free[k]] > 0) known.push_back(k);
  }
  if (known.empty()) return;
  const Eigen::VectorXd values = parameter_values(cell);
  // Of a factorised J there are fewer rows than residuals.
  Eigen::Index row = system.J.rows(), entry = system.f.size();
  system.J.conservativeResize(row + static_cast<Eigen::Index>(known.size()), Eigen::NoChange);
  system.f.conservativeResize(entry + static_cast<Eigen::Index>(known.size()));
  for (const std::size_t k : known) {
    const int parameter = problem.free[k];
    system.J.row(row).setZero();
    system.J(row++, static_cast<Eigen::Index>(k)) = weight[parameter];
    system.f[entry++] = weight[parameter] * (values[parameter] - problem.prior.centre[parameter]);
  }
}

Eigen::VectorXd scattered(const Eigen::VectorXd& step, const std::vector<int>& free, int size) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(size);
  for (std::size_t k = 0; k < free.size(); ++k) all[free[k]] = step[static_cast<Eigen::Index>(k)];
  return all;
}

}  // namespace truepose
