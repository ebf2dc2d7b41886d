#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "config/yaml_layout.hpp"

namespace truepose::config {

/// The lower triangle of a covariance, row by row.
struct LowerTriangle {
  int size;  ///< of the covariance: a row for each parameter

  template <class Derived>
  std::vector<std::vector<double>> form_of(const Eigen::MatrixBase<Derived>& covariance) const {
    std::vector<std::vector<double>> rows;
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
      rows.emplace_back();
      for (Eigen::Index j = 0; j <= i; ++j) rows.back().push_back(covariance(i, j));
    }
    return rows;
  }
  template <class Derived>
  void read(const Io& io, Eigen::PlainObjectBase<Derived>& covariance) const {
    const YamlValue& value = yaml_value(io);
    const std::vector<YamlValue>& rows = value.list();
    if (rows.size() != static_cast<std::size_t>(size))
      value.fail("expected a row for each of " + std::to_string(size) + " parameters");
    covariance.resize(size, size);
    for (int i = 0; i < size; ++i) {
      const YamlValue& row = rows[static_cast<std::size_t>(i)];
      if (row.list().size() != static_cast<std::size_t>(i) + 1)
        row.fail("expected " + std::to_string(i + 1) + " numbers, the lower triangle up to the diagonal");
      for (int j = 0; j <= i; ++j)
        covariance(i, j) = covariance(j, i) = row.list()[static_cast<std::size_t>(j)].number(kAny);
    }
  }
};

}  // namespace truepose::config
