#include "core/fit/null_space.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string_view>

#include "core/fit/identifiability.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// Below this part of the largest coefficient (columns at unit norm) a parameter is not named.
constexpr double kNamed = 2e-3;
/// The same for what is weakly known, where every parameter has some part in every combination.
constexpr double kNamedWeak = 0.3;

std::vector<int> ascending(std::vector<int> columns) {
  std::ranges::sort(columns);
  return columns;
}

/// Columns from the most dispensable on: the least preferred, the last of those alike.
std::vector<int> dispensable_first(const Eigen::VectorXd& preference) {
  std::vector<int> order(static_cast<std::size_t>(preference.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::reverse(order);
  std::ranges::stable_sort(order, {}, [&](int k) { return preference[k]; });
  return order;
}

/// As many rows of `basis` as it has columns, independent of each other, the first of `order` that are. A row
/// with a small part of its own would make for large coefficients: it is taken only where nothing else is
/// left.
std::vector<int> pivot_rows(const Eigen::MatrixXd& basis, const std::vector<int>& order) {
  std::vector<int> rows;
  Eigen::MatrixXd left = basis;
  for (double least = 0.05; static_cast<Eigen::Index>(rows.size()) < basis.cols(); least /= 10) {
    for (const int row : order) {
      if (static_cast<Eigen::Index>(rows.size()) == basis.cols()) break;
      if (left.row(row).norm() <= least) continue;
      const Eigen::VectorXd direction = left.row(row).transpose().normalized();
      const Eigen::VectorXd along = times(left, direction);
      for (Eigen::Index c = 0; c < left.cols(); ++c) left.col(c) -= along * direction[c];
      rows.push_back(row);
    }
  }
  return rows;
}

/// Null space in reduced echelon form: column k holds 1 in row pivots[k], 0 in those of the other pivots.
struct Echelon {
  std::vector<int> pivots;
  Eigen::MatrixXd columns;
};

Echelon reduced_echelon(const Eigen::MatrixXd& basis, const std::vector<int>& order) {
  Echelon echelon{.pivots = pivot_rows(basis, order), .columns = {}};
  const Eigen::MatrixXd pivots = basis(echelon.pivots, Eigen::all);
  echelon.columns = times(basis, inverse(pivots));
  echelon.columns(echelon.pivots, Eigen::all).setIdentity();
  return echelon;
}

std::vector<int> named(const Eigen::VectorXd& coefficients, double least) {
  const double limit = least * coefficients.cwiseAbs().maxCoeff();
  std::vector<int> columns;
  for (int k = 0; k < coefficients.size(); ++k) {
    if (std::abs(coefficients[k]) > limit) columns.push_back(k);
  }
  return columns;
}

/// Names of parameters, and which of them belong together.
class GroupedNames {
 public:
  explicit GroupedNames(std::span<const std::string> names) : names_{names} {
    std::map<std::string_view, int> number_of;
    for (const std::string_view name : names) {
      const int next = static_cast<int>(sizes_.size());
      const int group = number_of.emplace(name.substr(0, name.rfind('.')), next).first->second;
      if (group == next) sizes_.push_back(0);
      groups_.push_back(group);
      ++sizes_[static_cast<std::size_t>(group)];
    }
  }

  /// "link1.a", or "link1.*" in place of all parameters of link 1.
  std::vector<std::string> spelled(const std::vector<int>& columns) const {
    std::vector<std::string> out;
    for (const int k : columns) {
      const std::string& name = names_[static_cast<std::size_t>(k)];
      const auto all = sizes_[static_cast<std::size_t>(group(k))];
      const bool whole =
          all > 2 && std::ranges::count(columns, group(k), [this](int other) { return group(other); }) == all;
      const std::string text = whole ? name.substr(0, name.rfind('.')) + ".*" : name;
      if (out.empty() || out.back() != text) out.push_back(text);
    }
    return out;
  }

 private:
  int group(int k) const { return groups_[static_cast<std::size_t>(k)]; }

  std::span<const std::string> names_;
  std::vector<int> groups_;  ///< of each name
  std::vector<int> sizes_;   ///< of each group
};

/// "a", "a and b", "a, b and c".
std::string listed(const std::vector<std::string>& texts) {
  std::string list;
  for (std::size_t k = 0; k < texts.size(); ++k) {
    if (k > 0) list += k + 1 == texts.size() ? " and " : ", ";
    list += texts[k];
  }
  return list;
}

std::string listed(const GroupedNames& names, const std::vector<int>& columns) {
  return listed(names.spelled(columns));
}

/// Dispensable parameters that the same others make up for.
struct Group {
  std::vector<int> dispensable, partners;
  std::vector<double> ratios;  ///< the sole partner's step for a unit step of each dispensable parameter
};

Combination in_words(const Group& group, const GroupedNames& names) {
  std::vector<int> all = group.dispensable;
  all.insert(all.end(), group.partners.begin(), group.partners.end());
  all = ascending(all);
  const bool one = all.size() == 1;
  if (group.partners.empty()) {
    return {all, listed(names, all) + (one ? " does" : " do") + " not show in these poses"};
  }
  if (group.partners.size() > 1) {
    return {all,
            listed(names, group.dispensable) + " cannot be separated from " + listed(names, group.partners)};
  }
  const auto near = [&](double ratio) {
    return std::ranges::all_of(group.ratios, [=](double r) { return std::abs(r - ratio) < kNamed; });
  };
  const std::string known = near(-1)                     ? "their sum"
                            : near(1) && all.size() == 2 ? "their difference"
                                                         : "one combination of them";
  return {all, listed(names, all) + " move together: only " + known + " is known"};
}

std::vector<Combination> unknown_combinations(const Echelon& scaled, const Eigen::MatrixXd& basis,
                                              const GroupedNames& names) {
  std::map<std::vector<int>, Group> groups;
  for (std::size_t k = 0; k < scaled.pivots.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    std::vector<int> partners = named(scaled.columns.col(column), kNamed);
    std::erase(partners, scaled.pivots[k]);
    Group& group = groups[partners];
    group.partners = partners;
    group.dispensable.push_back(scaled.pivots[k]);
    if (partners.size() == 1) group.ratios.push_back(basis(partners[0], column));
  }
  std::vector<Combination> combinations;
  for (auto& [partners, group] : groups) {
    std::ranges::sort(group.dispensable);
    combinations.push_back(in_words(group, names));
  }
  std::ranges::sort(combinations, {}, &Combination::parameters);
  return combinations;
}

std::string tenths(double value) {
  const long rounded = std::lround(value * 10);
  return std::to_string(rounded / 10) + (value < 10 ? "." + std::to_string(rounded % 10) : "");
}

/// Directions that the data show badly, and the parameters named in them.
struct Weak {
  std::vector<int> parameters;
  int directions = 0;
  double sigma = 0;  ///< of the weakest direction, in usual deviations
};

std::string in_words(const Weak& weak, const GroupedNames& names) {
  std::string sentence;
  if (weak.directions > 1) sentence = std::to_string(weak.directions) + " combinations of ";
  if (weak.directions == 1 && weak.parameters.size() > 1) sentence = "a combination of ";
  sentence += listed(names, weak.parameters);
  sentence += weak.directions == 1 ? " is" : " are";
  return sentence + " weakly known: sigma is " + tenths(weak.sigma) + " times the usual deviation";
}

/// Directions of the independent parameters whose sigma exceeds the usual deviation, those that share a named
/// parameter together.
std::vector<Combination> weak_combinations(const Eigen::MatrixXd& J, const std::vector<int>& independent,
                                           const GroupedNames& names,
                                           const Eigen::VectorXd& usual_deviation) {
  const Eigen::MatrixXd whitened = J(Eigen::all, independent) * usual_deviation(independent).asDiagonal();
  // It bounds all variances: mostly nothing is weak.
  if (inverse_gram_trace(whitened, kRankTolerance) < 1) return {};
  const Svd svd = thin_svd(whitened);
  std::vector<Weak> weak;
  for (Eigen::Index i = svd.s.size(); i-- > 0 && svd.s[i] < 1;) {
    Weak next{.directions = 1, .sigma = 1 / svd.s[i]};
    for (const int k : named(svd.V.col(i), kNamedWeak)) {
      next.parameters.push_back(independent[static_cast<std::size_t>(k)]);
    }
    std::erase_if(weak, [&](const Weak& earlier) {
      std::vector<int> shared, both;
      std::ranges::set_intersection(earlier.parameters, next.parameters, std::back_inserter(shared));
      if (shared.empty()) return false;
      std::ranges::set_union(earlier.parameters, next.parameters, std::back_inserter(both));
      next = {both, earlier.directions + next.directions, std::max(earlier.sigma, next.sigma)};
      return true;
    });
    weak.push_back(next);
  }
  std::vector<Combination> combinations;
  for (const Weak& w : weak) combinations.push_back({w.parameters, in_words(w, names)});
  return combinations;
}

}  // namespace

Eigen::VectorXd usual_deviation(const ParameterLayout& layout) {
  constexpr double kLink = 0.3, kPlacement = 1;  // mm
  constexpr double kLink_rad = 3e-4, kPlacement_rad = 1e-3;
  Eigen::VectorXd deviation = Eigen::VectorXd::Constant(layout.size(), kPlacement);
  for (int s = 0; s < layout.stations; ++s)
    deviation.segment<3>(layout.base(s) + 3).setConstant(kPlacement_rad);
  for (int i = 0; i < layout.joints; ++i) {
    deviation.segment<5>(layout.link(i)) << kLink, kLink_rad, kLink, kLink_rad, kLink_rad;
  }
  return deviation;
}

NullSpace null_space(const Eigen::MatrixXd& J_all, std::span<const std::string> all_names,
                     const Eigen::VectorXd& preference, const Eigen::VectorXd& usual_deviation) {
  const GroupedNames names(all_names);
  const Eigen::MatrixXd J = triangular_factor(J_all);
  const Eigen::VectorXd norms = column_norms(J);
  const PivotedQr unit = pivoted_qr(J * norms.cwiseInverse().asDiagonal());
  const Identifiability known = rank_by(unit.pivots());
  const Echelon scaled = reduced_echelon(null_basis(unit, known.rank), dispensable_first(preference));

  NullSpace result{.rank = known.rank, .gap = known.gap, .basis = scaled.columns, .unknown = {}, .weak = {}};
  result.basis.array().colwise() /= norms.array();
  for (std::size_t k = 0; k < scaled.pivots.size(); ++k) {
    result.basis.col(static_cast<Eigen::Index>(k)) *= norms[scaled.pivots[k]];
  }
  result.unknown = unknown_combinations(scaled, result.basis, names);

  std::vector<int> independent;
  for (int k = 0; k < J.cols(); ++k) {
    if (std::ranges::find(scaled.pivots, k) == scaled.pivots.end()) independent.push_back(k);
  }
  result.weak = weak_combinations(J, independent, names, usual_deviation);
  return result;
}

}  // namespace truepose
