#include "core/fit/left_out_poses.hpp"

#include <algorithm>

#include "core/data/measurement.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {

LeftOutPoses::Normal LeftOutPoses::normal_of(const Eigen::MatrixXd& J, const Eigen::VectorXd& f) {
  return {gram(J), transposed_times(J, f), f.squaredNorm()};
}

LeftOutPoses::Fold LeftOutPoses::eliminated(const Normal& all, const Normal& here, Eigen::Index geometry) {
  const Eigen::Index terms = all.Jtf.size() - geometry;
  const Eigen::MatrixXd rest = all.JtJ - here.JtJ;
  const Eigen::VectorXd rest_right = all.Jtf - here.Jtf;
  Eigen::MatrixXd gg = rest.topLeftCorner(geometry, geometry);
  gg.diagonal() *= 1 + 1e-12;
  // x_g = -C_right - C x_d with all right-hand sides of the sign of f = model - measured.
  Eigen::MatrixXd right(geometry, terms + 1);
  right << rest.topRightCorner(geometry, terms), rest_right.head(geometry);
  const Eigen::MatrixXd solved = solve_symmetric(gg, right);
  const Eigen::MatrixXd C = solved.leftCols(terms);
  const Eigen::VectorXd c = solved.col(terms);

  Fold fold;
  fold.normal = rest.bottomRightCorner(terms, terms) - times(rest.bottomLeftCorner(terms, geometry), C);
  fold.right = rest_right.tail(terms) - transposed_times(C, rest_right.head(geometry));
  // Here: f + J_g x_g + J_d x_d = (f - J_g c) + (J_d - J_g C) x_d.
  const auto gg_here = here.JtJ.topLeftCorner(geometry, geometry);
  const auto gd_here = here.JtJ.topRightCorner(geometry, terms);
  const Eigen::VectorXd gg_c = times(gg_here, c), without_c = here.Jtf.head(geometry) - gg_c;
  fold.here_square = here.ff - 2 * c.dot(here.Jtf.head(geometry)) + c.dot(gg_c);
  fold.here_right = here.Jtf.tail(terms) - transposed_times(C, without_c) - transposed_times(gd_here, c);
  const Eigen::MatrixXd CtD = transposed_times(C, gd_here), CtGC = transposed_times(C, times(gg_here, C));
  fold.here_normal = here.JtJ.bottomRightCorner(terms, terms) - CtD - CtD.transpose() + CtGC;
  return fold;
}

LeftOutPoses::LeftOutPoses(const CalibratedCell& cell, const LeastSquaresProblem& problem,
                           Eigen::Index fitted) {
  constexpr int kFolds = 10;
  const LinearSystem system = linearise(cell, problem);
  const auto rows = rows_of_points(problem);
  const std::vector<int> pose = pose_numbers(problem.points);
  const int count = std::min(kFolds, count_poses(problem.points));
  std::vector<Normal> parts;
  for (int k = 0; k < count; ++k) {
    std::vector<int> mine;
    for (std::size_t i = 0; i < pose.size(); ++i) {
      if (pose[i] % count == k) mine.insert(mine.end(), rows[i].begin(), rows[i].end());
    }
    parts.push_back(normal_of(system.J(mine, Eigen::all), system.f(mine)));
  }
  Eigen::Index of_points = 0;
  for (const auto& of_point : rows) of_points += std::ssize(of_point);
  const Eigen::Index of_prior = system.f.size() - of_points;
  // The prior's rows are never left out.
  Normal all = normal_of(system.J.bottomRows(of_prior), system.f.tail(of_prior));
  for (const Normal& part : parts) {
    all.JtJ += part.JtJ;
    all.Jtf += part.Jtf;
  }
  for (const Normal& part : parts) folds_.push_back(eliminated(all, part, fitted));
}

std::vector<double> LeftOutPoses::squared_errors(const std::vector<int>& active,
                                                 const Eigen::VectorXd& ridge) const {
  std::vector<double> errors;
  for (const Fold& fold : folds_) {
    errors.push_back(fold.here_square);
    if (active.empty()) continue;
    Eigen::MatrixXd normal = fold.normal(active, active);
    normal.diagonal() += ridge;
    const Eigen::VectorXd x = -solve_symmetric(normal, Eigen::VectorXd(fold.right(active)));
    const Eigen::VectorXd here_right = fold.here_right(active);
    const Eigen::MatrixXd here_normal = fold.here_normal(active, active);
    errors.back() += 2 * x.dot(here_right) + times(here_normal, x).col(0).dot(x);
  }
  return errors;
}

}  // namespace truepose
