#include "daemon/store/joint_list.hpp"

#include <system_error>

namespace truepose::daemon {

std::optional<std::vector<double>> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  if (!text.starts_with('[') || !text.ends_with(']')) return std::nullopt;
  const char* at = text.data() + 1;
  const char* const end = text.data() + text.size() - 1;
  while (at < end) {
    double value = 0;
    const auto [rest, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || (rest != end && *rest != ',')) return std::nullopt;
    numbers.push_back(value);
    at = rest == end ? end : rest + 1;
  }
  return numbers;
}

std::optional<JointVector> joints_of(std::string_view text) {
  const auto numbers = numbers_of(text);
  if (!numbers || numbers->size() > static_cast<std::size_t>(kMaxJoints)) return std::nullopt;
  return JointVector(
      Eigen::Map<const Eigen::VectorXd>(numbers->data(), static_cast<Eigen::Index>(numbers->size())));
}

}  // namespace truepose::daemon
