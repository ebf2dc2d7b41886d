#include "core/fit/placement.hpp"

#include <algorithm>
#include <numbers>
#include <optional>
#include <vector>

#include "core/fit/measurement_model.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// Weight of each reflector's distance from the flange's centre against the misses, mm per mm: a residual of
/// 1 mm over 30 m. It holds what no pose shows, and moves by less than rounding what they show.
constexpr double kReflectorWeight = 3e-5;

/// Entries of M, row by row, and -1 for what does not depend on it.
using Entries = Eigen::Vector<double, 10>;
using Form = Eigen::Matrix<double, 10, 10>;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Entries entries_of(const Eigen::Matrix3d& M) {
  Entries z;
  z << M.row(0).transpose(), M.row(1).transpose(), M.row(2).transpose(), -1;
  return z;
}

Eigen::Matrix3d matrix_of(const Eigen::Ref<const Eigen::Vector<double, 9>>& entries) {
  return Eigen::Map<const RowMajor3>(entries.data());
}

Eigen::Vector3d mean_point(std::span<const Measurement> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Measurement& point : points) sum += point.p_WS_mm;
  return sum / static_cast<double>(points.size());
}

/// The squared error over all points, with base position and reflectors at their best.
struct ErrorForm {
  Form Q;                      ///< z' Q z, mm^2
  Eigen::MatrixXd reflectors;  ///< times z: t of each
  Eigen::Vector3d mean_p;
  Eigen::MatrixXd mean_R;  ///< of all points, by reflector: s = -mean_p - mean_R t

  ErrorForm(const RobotModel& arm, Eigen::Index reflectors, std::span<const Measurement> points,
            const Eigen::Vector3d& centre);
};

ErrorForm::ErrorForm(const RobotModel& arm, Eigen::Index reflector_count, std::span<const Measurement> points,
                     const Eigen::Vector3d& centre) {
  // Columns of the misses: c for each entry of M, p_k, and R_k for t of each reflector. Those of M add up to
  // nothing.
  const Eigen::Index size = 10 + 3 * reflector_count;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);  // of all products; lower half
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(3, size);
  const std::vector<Eigen::Isometry3d> flange = flange_poses(arm, points);
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d c = points[k].p_WS_mm - centre, p = flange[k].translation();
    const Eigen::Matrix3d R = flange[k].linear();
    const Eigen::Index t = 10 + 3 * points[k].smr;
    C += c * c.transpose();
    for (Eigen::Index i = 0; i < 3; ++i) {
      A.block<1, 3>(9, 3 * i) += p[i] * c.transpose();
      A.block<3, 3>(t, 3 * i) += R.row(i).transpose() * c.transpose();
    }
    A(9, 9) += p.squaredNorm();
    A.block<3, 1>(t, 9) += R.transpose() * p;
    A.block<3, 3>(t, t) += Eigen::Matrix3d::Identity();
    sum.col(9) += p;
    sum.middleCols<3>(t) += R;
  }
  for (Eigen::Index i = 0; i < 3; ++i) A.block<3, 3>(3 * i, 3 * i) = C;
  const Eigen::MatrixXd mean = sum / static_cast<double>(points.size());
  A -= transposed_times(mean, sum);
  mean_p = mean.col(9);
  mean_R = mean.rightCols(3 * reflector_count);

  const Eigen::Index unknowns = 3 * reflector_count;
  Eigen::MatrixXd T = A.bottomRightCorner(unknowns, unknowns);
  T.diagonal().array() += kReflectorWeight * kReflectorWeight;
  const Eigen::MatrixXd mixed = A.bottomLeftCorner(unknowns, 10);
  reflectors = solve_symmetric(T, mixed);
  Q = A.topLeftCorner<10, 10>().selfadjointView<Eigen::Lower>();
  Q -= transposed_times(mixed, reflectors);
}

// Products are written out (lazyProduct): Eigen takes 10 rows for many, and calls what is made for large
// matrices.

double error_of(const Form& Q, const Entries& z) { return z.dot(Q.lazyProduct(z)); }

/// A rotation and the squared error with it.
struct Candidate {
  Eigen::Matrix3d M;
  double error = 0;
};

/// Newton's step (a turn) of half the error with M, and the decrease that it promises.
struct NewtonStep {
  Eigen::Vector3d turn;
  double promised = 0;
};

/// @param damping  added to the curvatures; a step that is not finite where they are not positive even so
NewtonStep newton_step(const Form& Q, const Eigen::Matrix3d& M, double damping) {
  Eigen::Matrix<double, 10, 3> by_turn;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(i);
    const Eigen::Matrix3d turned = -M.colwise().cross(axis);
    by_turn.col(i) = entries_of(turned);
  }
  by_turn.row(9).setZero();
  const Entries slope = Q.lazyProduct(entries_of(M));
  const Eigen::Vector3d gradient = by_turn.transpose().lazyProduct(slope);
  const Eigen::Matrix3d bend = matrix_of(slope.head<9>()) * M.transpose();
  const Eigen::Matrix<double, 10, 3> bent = Q.lazyProduct(by_turn);
  Eigen::Matrix3d curvature = by_turn.transpose().lazyProduct(bent);
  curvature += 0.5 * (bend + bend.transpose());
  curvature.diagonal().array() += damping - bend.trace();
  const Eigen::Matrix3d W = inverse_cholesky(curvature);
  const Eigen::Vector3d whitened = W * gradient;
  return {-W.transpose() * whitened, whitened.squaredNorm()};
}

/// The minimum below M.
Candidate descended(const Form& Q, const Eigen::Matrix3d& M) {
  constexpr int kMostDampedSteps = 100;
  constexpr double kExhausted = 1e-14;  // of the error with no rotation at all
  const double unit = Q.diagonal().head<9>().maxCoeff();
  Candidate here{M, error_of(Q, entries_of(M))};
  double damping = 0;
  for (int i = 0; i < kMostDampedSteps && damping < 1e3 * unit; ++i) {
    const NewtonStep step = newton_step(Q, here.M, damping);
    const Eigen::Matrix3d turned = rotation_by(step.turn) * here.M;
    const double error = error_of(Q, entries_of(turned));
    // A decrease this small is lost in rounding: the full step is the better point.
    if (step.promised <= kExhausted * Q(9, 9)) return {turned, error};
    if (error < here.error) {
      here = {turned, error};
      damping = damping > 1e-6 * unit ? damping / 10 : 0;
    } else {
      damping = std::max(10 * damping, 1e-4 * unit);
    }
  }
  return here;
}

/// The rotations that bring a cube onto itself: none is farther than 63 deg from one of them.
std::vector<Eigen::Matrix3d> rotations_all_around() {
  constexpr double kRight = std::numbers::pi / 2;
  std::vector<Eigen::Matrix3d> rotations;
  for (int z = 0; z < 4; ++z) {
    for (int x = 0; x < 4; ++x) rotations.push_back(rotation_zyx(kRight * z, 0, kRight * x));
    for (const int y : {-1, 1}) rotations.push_back(rotation_zyx(kRight * z, kRight * y, 0));
  }
  return rotations;
}

/// The rotation nearest to M.
Eigen::Matrix3d projected_to_rotation(const Eigen::Matrix3d& M) {
  const Svd svd = thin_svd(M);
  Eigen::Matrix3d U = svd.U;
  const Eigen::Matrix3d V = svd.V;
  if ((U * V.transpose()).determinant() < 0) U.col(2) *= -1;
  return U * V.transpose();
}

/// The minimum near the least of all M, rotation or not, if no other rotation can be as good: a better one is
/// no farther from that M than the error's growth away from it allows.
std::optional<Candidate> certain_minimum(const Form& Q, PlacementSearch search) {
  constexpr double kNear = 1;  // of the entries of two rotations: 41 deg. Other minima are twice as far away
  const CholeskyFactor H(Q.topLeftCorner<9, 9>());
  if (!H.succeeded()) return std::nullopt;
  Entries least;
  least << Eigen::Vector<double, 9>(H.solve(Q.topRightCorner<9, 1>())), -1;
  const Candidate found = descended(Q, projected_to_rotation(matrix_of(least.head<9>())));
  if (search == PlacementSearch::Near) return found;
  const double farthest = (found.error - error_of(Q, least)) * H.inverse().trace();
  if (!(farthest < kNear * kNear)) return std::nullopt;
  return found;
}

/// The lowest minimum below the best of rotations all around. Six descents have always found it, so a third
/// more are made.
Candidate searched_minimum(const Form& Q) {
  constexpr std::ptrdiff_t kBestStarts = 8;
  std::vector<Candidate> starts;
  for (const Eigen::Matrix3d& M : rotations_all_around()) starts.push_back({M, error_of(Q, entries_of(M))});
  std::ranges::partial_sort(starts, starts.begin() + kBestStarts, {}, &Candidate::error);
  starts.resize(kBestStarts);
  for (Candidate& start : starts) start = descended(Q, start.M);
  return *std::ranges::min_element(starts, {}, &Candidate::error);
}

Candidate best_rotation(const Form& Q, PlacementSearch search) {
  if (const auto certain = certain_minimum(Q, search)) return *certain;
  return searched_minimum(Q);
}

}  // namespace

CalibratedCell placement(const RobotModel& arm, std::span<const std::string> smr_names,
                         std::span<const Measurement> points, PlacementSearch search) {
  const Eigen::Vector3d centre = mean_point(points);
  const ErrorForm form(arm, static_cast<Eigen::Index>(smr_names.size()), points, centre);
  // No pose of a turntable shows how its base is turned about the axis, so that the minimum over all M says
  // little.
  if (arm.joint_count() == 1) search = PlacementSearch::Everywhere;
  const Eigen::Matrix3d M = best_rotation(form.Q, search).M;

  const Eigen::VectorXd t = times(form.reflectors, entries_of(M));
  const Eigen::Vector3d s = -form.mean_p - times(form.mean_R, t);
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.linear() = M.transpose();
  X_WB.translation() = centre + M.transpose() * s;

  CalibratedCell cell{arm, BasePose::of(X_WB), {}};
  for (std::size_t k = 0; k < smr_names.size(); ++k) {
    cell.reflectors.push_back({smr_names[k], t.segment<3>(3 * static_cast<Eigen::Index>(k))});
  }
  return cell;
}

Prior placement_prior(const ParameterLayout& layout) {
  Prior prior{Eigen::VectorXd::Zero(layout.size()), Eigen::VectorXd::Zero(layout.size())};
  prior.weight.segment(layout.reflector(0), ParameterLayout::kReflector * layout.reflectors)
      .setConstant(kReflectorWeight);
  return prior;
}

}  // namespace truepose
