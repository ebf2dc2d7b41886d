#include "core/fit/normal_equations.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/arm/guide.hpp"
#include "core/step_count.hpp"

namespace truepose {
namespace {

std::size_t lines_of(int numbers) {
  return static_cast<std::size_t>((numbers + kernels::kMostLanes - 1) / kernels::kMostLanes);
}

}  // namespace

NormalEquations::NormalEquations(const CalibratedCell& cell, PreparedPoints& points,
                                 const std::vector<int>& free, const Prior& prior)
    : points_{points}, layout_{ParameterLayout::of(cell)}, free_{free}, prior_{prior} {
  assert(LinkNumbers(cell.robot).count() == points.link_count() && layout_.reflectors == points.reflectors());
  const int first_link = layout_.link(0);
  for (const int parameter : free) {
    if (parameter < first_link) {
      place_.push_back(parameter);
      continue;
    }
    place_.push_back(first_link + static_cast<int>(columns_.size()));
    columns_.push_back(link_column(cell.robot, layout_, parameter));
  }
  assert(columns_.size() <= kMostLinkParameters);
  const int local = local_columns();
  all_.resize(first_link + static_cast<int>(columns_.size()), first_link + static_cast<int>(columns_.size()));
  gradient_.resize(all_.rows());
  chunk_.resize(lines_of(local * 3 * kernels::kChunk));
  gram_.resize(lines_of((local + kernels::kBlock) * (local + kernels::kBlock)));
  sums_.resize(3, local);
}

int NormalEquations::local_columns() const {
  return kernels::kFixedColumns + static_cast<int>(columns_.size()) +
         (points_.whitened() ? kernels::kTranslations : 0);
}

void NormalEquations::evaluate(const CalibratedCell& cell) {
  count_step();
  points_.deviate(cell.robot);
  PreparedModel model(cell, columns_);
  all_.setZero();
  gradient_.setZero();
  cost_ = 0;
  for (int s = 0; s < points_.stations(); ++s) {
    const Eigen::Isometry3d X_WB = cell.base_at(s).isometry();
    for (int k = 0; k < layout_.reflectors; ++k)
      add(model.of(X_WB, cell.reflectors[static_cast<std::size_t>(k)]), s, k);
    turn_base_to_tracker(s, X_WB.linear());
  }
  add_prior(cell);
}

void NormalEquations::add(const kernels::PointModel& model, int station, int reflector) {
  const int local = static_cast<int>(sums_.cols());
  const int stride = local + kernels::kBlock;
  std::fill(gram_.begin(), gram_.end(), kernels::Line{});
  sums_.setZero();
  kernels::PointSums sums{.gram = gram_[0].value, .sum = sums_.data(), .weight = 0, .stride = stride};
  points_.code().point_sums(model, points_.of(station, reflector), chunk_[0].value, sums);
  const auto dot = [&](int i, int j) { return sums.gram[i * stride + j]; };
  cost_ += dot(0, 0);
  for (int i = 1; i < local; ++i) {
    const int first = place_of_local(i, station, reflector);
    gradient_[first] += dot(0, i);
    for (int j = i; j < local; ++j) {
      const int second = place_of_local(j, station, reflector);
      all_(std::min(first, second), std::max(first, second)) += dot(i, j);
    }
  }
  if (!points_.whitened()) add_translations(sums, station, reflector);
}

/// Of the kernel's columns from 1 on: the base's turn, the reflector, the links, the base's translation.
int NormalEquations::place_of_local(int column, int station, int reflector) const {
  const int translations = kernels::kFixedColumns + static_cast<int>(columns_.size());
  if (column < 4) return layout_.base(station) + 3 + column - 1;
  if (column < kernels::kFixedColumns) return layout_.reflector(reflector) + column - 4;
  if (column < translations) return layout_.link(0) + column - kernels::kFixedColumns;
  return layout_.base(station) + column - translations;
}
/// Where points are weighed the translations' columns are the axes, times the weight.
void NormalEquations::add_translations(const kernels::PointSums& sums, int station, int reflector) {
  const int base = layout_.base(station);
  gradient_.segment<3>(base) += sums_.col(0);
  all_.diagonal().segment<3>(base).array() += sums.weight;
  for (int i = 1; i < sums_.cols(); ++i)
    all_.col(place_of_local(i, station, reflector)).segment<3>(base) += sums_.col(i);
}

void NormalEquations::add_prior(const CalibratedCell& cell) {
  if (prior_.weight.size() == 0) return;
  const Eigen::VectorXd values = parameter_values(cell);
  for (int i = 0; i < size(); ++i) {
    const int parameter = free_[static_cast<std::size_t>(i)];
    const double weight = prior_.weight[parameter];
    const double off = weight * (values[parameter] - prior_.centre[parameter]);
    all_(place(i), place(i)) += weight * weight;
    gradient_[place(i)] += weight * off;
    cost_ += off * off;
  }
}

void NormalEquations::turn_base_to_tracker(int station, const Eigen::Matrix3d& R_WB) {
  const int shift = layout_.base(station), turn = shift + 3;
  gradient_.segment<3>(shift) = (R_WB * gradient_.segment<3>(shift)).eval();
  gradient_.segment<3>(turn) = (R_WB * gradient_.segment<3>(turn)).eval();
  all_.block<3, 3>(shift, turn) = (R_WB * all_.block<3, 3>(shift, turn) * R_WB.transpose()).eval();
  // Of translations and turns among themselves only the upper half was summed.
  for (const Eigen::Index own : {shift, turn}) {
    const Eigen::Matrix3d among = all_.block<3, 3>(own, own).selfadjointView<Eigen::Upper>();
    all_.block<3, 3>(own, own) = R_WB * among * R_WB.transpose();
  }
  for (Eigen::Index j = layout_.base(station + 1); j < all_.cols(); ++j) {
    all_.col(j).segment<3>(shift) = (R_WB * all_.col(j).segment<3>(shift)).eval();
    all_.col(j).segment<3>(turn) = (R_WB * all_.col(j).segment<3>(turn)).eval();
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
