#include "config/suggestion.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace truepose::config {

namespace {

// Optimal string alignment: letters put in, left out, changed, or two neighbours swapped.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before_last = std::exchange(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row.back();
}

}  // namespace

std::string suggestion(std::string_view misspelt, std::span<const std::string> known) {
  constexpr std::size_t kLongest =
      64;  // a longer name is no slip of the finger, and the distance costs its square
  if (misspelt.size() > kLongest) return {};
  const std::string* nearest = nullptr;
  std::size_t best = std::max<std::size_t>(1, misspelt.size() / 3) + 1;
  for (const std::string& name : known) {
    // The unit is what is left out most: "ramp" for "ramp_ms".
    if (!misspelt.empty() && name.starts_with(std::string(misspelt) + "_"))
      return ", did you mean '" + name + "'?";
    const std::size_t distance = edit_distance(misspelt, name);
    if (distance < best && distance < name.size()) {
      best = distance;
      nearest = &name;
    }
  }
  return nearest ? ", did you mean '" + *nearest + "'?" : "";
}

}  // namespace truepose::config
