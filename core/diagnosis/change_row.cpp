#include "core/diagnosis/change_row.hpp"

#include <algorithm>

#include "core/math/statistics.hpp"

namespace truepose {

ChangeRow change_between(const std::vector<double>& earlier, const std::vector<double>& later) {
  std::vector<double> better;
  for (std::size_t i = 0; i < earlier.size(); ++i) better.push_back(std::min(earlier[i], later[i]));
  const double most = 10 * median(better);
  double cost = 0;
  for (const double miss : later) cost += std::min(miss, most);
  ChangeRow best{.row = 0, .cost = cost};
  for (std::size_t i = 0; i < earlier.size(); ++i) {
    cost += std::min(earlier[i], most) - std::min(later[i], most);
    if (cost < best.cost) best = {i + 1, cost};
  }
  return best;
}

}  // namespace truepose
