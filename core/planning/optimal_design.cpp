#include "core/planning/optimal_design.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <numeric>
#include <utility>

#include "core/evaluation/cramer_rao.hpp"
#include "core/random.hpp"

namespace truepose {
namespace {

using PoseRows = Eigen::Matrix<double, 3, Eigen::Dynamic>;

// Holds the information of a design regular while it has too few poses; in the coordinates in which all
// candidates together have the information 1.
constexpr double kRegular = 1e-9;
// A gain below this part is rounding, and would let two equal poses change places for ever.
constexpr double kLeastGain = 1e-9;

class Exchange {
 public:
  Exchange(const Eigen::MatrixXd& candidates, const Eigen::MatrixXd& task, const DesignOptions& options)
      : A_{candidates}, task_{task.transpose() * task}, options_{options} {
    std::vector<std::size_t> order(static_cast<std::size_t>(A_.rows()) / 3);
    std::iota(order.begin(), order.end(), std::size_t{0});
    Random random{options.seed};
    for (std::size_t i = order.size(); i-- > 1;) std::swap(order[i], order[random.next() % (i + 1)]);
    is_chosen_.assign(order.size(), false);
    chosen_.assign(order.begin(), order.begin() + options.poses);
    for (const std::size_t k : chosen_) is_chosen_[k] = true;
  }

  std::vector<std::size_t> run() {
    for (int pass = 0; pass < options_.max_passes && improve_each(); ++pass) {
    }
    std::ranges::sort(chosen_);
    return chosen_;
  }

 private:
  auto rows(std::size_t pose) const { return A_.middleRows<3>(3 * static_cast<Eigen::Index>(pose)); }

  /// Covariance of the design without one of its poses.
  Eigen::MatrixXd covariance_without(std::size_t given_up) const {
    Eigen::MatrixXd information = kRegular * Eigen::MatrixXd::Identity(A_.cols(), A_.cols());
    for (const std::size_t k : chosen_) {
      if (k != given_up) information.noalias() += rows(k).transpose() * rows(k);
    }
    return information.llt().solve(Eigen::MatrixXd::Identity(A_.cols(), A_.cols()));
  }

  /// What a pose adds to a design of covariance C: by the matrix determinant lemma the factor of the
  /// determinant, and by Woodbury's identity the fall of the mean variance.
  double gain(const PoseRows& AC, const PoseRows& A, const Eigen::MatrixXd& CTC) const {
    const Eigen::Matrix3d S = Eigen::Matrix3d::Identity() + AC * A.transpose();
    if (options_.criterion == DesignCriterion::D) return S.determinant();
    const Eigen::Matrix3d fall = A * CTC * A.transpose();
    return S.inverse().cwiseProduct(fall).sum();  // both symmetric: the trace of their product
  }

  bool improve_each() {
    bool improved = false;
    for (std::size_t& pose : chosen_) {
      const Eigen::MatrixXd C = covariance_without(pose);
      const Eigen::MatrixXd CTC = C * task_ * C;
      const Eigen::MatrixXd AC = A_ * C;
      const auto gain_of = [&](std::size_t k) {
        return gain(AC.middleRows<3>(3 * static_cast<Eigen::Index>(k)), rows(k), CTC);
      };
      std::size_t best = pose;
      double best_gain = (1 + kLeastGain) * gain_of(pose);
      for (std::size_t k = 0; k < is_chosen_.size(); ++k) {
        if (is_chosen_[k]) continue;
        if (const double g = gain_of(k); g > best_gain) {
          best = k;
          best_gain = g;
        }
      }
      if (best == pose) continue;
      is_chosen_[pose] = false;
      is_chosen_[best] = true;
      pose = best;
      improved = true;
    }
    return improved;
  }

  Eigen::MatrixXd A_;     // 3 rows of each candidate, in coordinates in which they are known alike
  Eigen::MatrixXd task_;  // sum over the task's poses
  DesignOptions options_;
  std::vector<std::size_t> chosen_;
  std::vector<bool> is_chosen_;
};

}  // namespace

std::vector<std::size_t> optimal_design(const CalibratedCell& cell, std::span<const JointVector> candidates,
                                        std::span<const JointVector> task, const DesignOptions& options) {
  assert(options.poses >= 0 && static_cast<std::size_t>(options.poses) <= candidates.size());
  const Eigen::MatrixXd J = position_jacobian(cell, candidates);
  const Eigen::MatrixXd basis = whitened_basis(J);
  return Exchange{J * basis, position_jacobian(cell, task) * basis, options}.run();
}

}  // namespace truepose
