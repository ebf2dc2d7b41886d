#include "core/kernels/normal_equations.hpp"

#include <cassert>
#include <cmath>

#include "core/kernels/arm_kernel.hpp"

namespace truepose {
namespace {

constexpr int kBase = ParameterLayout::kBase;

std::size_t lines_of(int numbers) {
  return static_cast<std::size_t>((numbers + kernels::kMostLanes - 1) / kernels::kMostLanes);
}

}  // namespace

NormalEquations::NormalEquations(const CalibratedCell& cell, const PreparedPoints& points,
                                 const std::vector<int>& free)
    : points_{points}, layout_{ParameterLayout::of(cell)} {
  assert(layout_.joints == points.joint_count() && layout_.reflectors == points.reflectors());
  const int first_link = layout_.link(0);
  for (const int parameter : free) {
    if (parameter < first_link) {
      place_.push_back(parameter);
      continue;
    }
    place_.push_back(first_link + static_cast<int>(columns_.size()));
    const int of_links = parameter - first_link;
    columns_.push_back({static_cast<kernels::ColumnKind>(of_links % ParameterLayout::kLink),
                        of_links / ParameterLayout::kLink});
  }
  const int local = kernels::kFixedColumns + static_cast<int>(columns_.size());
  all_.resize(first_link + static_cast<int>(columns_.size()), first_link + static_cast<int>(columns_.size()));
  gradient_.resize(all_.rows());
  chunk_.resize(lines_of(local * 3 * kernels::kChunk));
  gram_.resize(lines_of((local + kernels::kBlock) * (local + kernels::kBlock)));
  sums_.resize(3, local);
}

void NormalEquations::evaluate(const CalibratedCell& cell) {
  const kernels::Arm arm = folded(cell.robot);
  const Eigen::Isometry3d X_WB = cell.base.isometry();
  kernels::PointModel model{
      .arm = &arm, .columns = columns_.data(), .column_count = static_cast<int>(columns_.size())};
  Eigen::Map<Eigen::Matrix3d>(model.rotation) = X_WB.linear();
  Eigen::Map<Eigen::Vector3d>(model.origin) = X_WB.translation();

  all_.setZero();
  gradient_.setZero();
  cost_ = 0;
  for (int k = 0; k < layout_.reflectors; ++k) {
    Eigen::Map<Eigen::Vector3d>(model.reflector) = cell.reflectors[static_cast<std::size_t>(k)].p_FS_mm;
    add(model, k);
  }
  turn_base_to_tracker(X_WB.linear());
}

void NormalEquations::add(const kernels::PointModel& model, int reflector) {
  const int local = static_cast<int>(sums_.cols());
  const int stride = local + kernels::kBlock;
  std::fill(gram_.begin(), gram_.end(), kernels::Line{});
  sums_.setZero();
  kernels::PointSums sums{.gram = gram_[0].value, .sum = sums_.data(), .weight = 0, .stride = stride};
  points_.code().point_sums(model, points_.of_reflector(reflector), chunk_[0].value, sums);
  const auto dot = [&](int i, int j) { return sums.gram[i * stride + j]; };

  // Local column 0 is the residual, then the base's turn, the reflector, the links.
  const auto place = [&](int column) {
    if (column < 4) return kBase / 2 + column - 1;
    if (column < kernels::kFixedColumns) return layout_.reflector(reflector) + column - 4;
    return layout_.link(0) + column - kernels::kFixedColumns;
  };
  cost_ += dot(0, 0);
  gradient_.head<3>() += sums_.col(0);
  all_.diagonal().head<3>().array() += sums.weight;
  for (int i = 1; i < local; ++i) {
    gradient_[place(i)] += dot(0, i);
    all_.col(place(i)).head<3>() += sums_.col(i);
    for (int j = i; j < local; ++j) all_(place(i), place(j)) += dot(i, j);
  }
}

void NormalEquations::turn_base_to_tracker(const Eigen::Matrix3d& R_WB) {
  gradient_.head<3>() = (R_WB * gradient_.head<3>()).eval();
  gradient_.segment<3>(3) = (R_WB * gradient_.segment<3>(3)).eval();
  all_.block<3, 3>(0, 3) = (R_WB * all_.block<3, 3>(0, 3) * R_WB.transpose()).eval();
  // Of the turns among themselves only the upper half was summed.
  const Eigen::Matrix3d turns = all_.block<3, 3>(3, 3).selfadjointView<Eigen::Upper>();
  all_.block<3, 3>(3, 3) = R_WB * turns * R_WB.transpose();
  for (Eigen::Index j = kBase; j < all_.cols(); ++j) {
    all_.col(j).head<3>() = (R_WB * all_.col(j).head<3>()).eval();
    all_.col(j).segment<3>(3) = (R_WB * all_.col(j).segment<3>(3)).eval();
  }
}

Eigen::VectorXd NormalEquations::gradient() const {
  Eigen::VectorXd g(size());
  for (int i = 0; i < size(); ++i) g[i] = gradient(i);
  return g;
}

Eigen::MatrixXd NormalEquations::matrix() const {
  Eigen::MatrixXd A(size(), size());
  for (int i = 0; i < size(); ++i)
    for (int j = i; j < size(); ++j) A(i, j) = A(j, i) = product(i, j);
  return A;
}

}  // namespace truepose
