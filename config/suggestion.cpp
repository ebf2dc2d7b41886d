#include "config/suggestion.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace truepose::config {

namespace {

// Levenshtein's distance, one row at a time.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
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
    const std::size_t distance = edit_distance(misspelt, name);
    if (distance < best && distance < name.size()) {
      best = distance;
      nearest = &name;
    }
  }
  return nearest ? ", did you mean '" + *nearest + "'?" : "";
}

}  // namespace truepose::config
