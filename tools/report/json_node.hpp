#pragma once

#include <Eigen/Core>
#include <boost/json/fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace truepose::report {

/// A value of the document together with the path to it, so that an error names the member. Every accessor
/// throws std::invalid_argument with one sentence where the value is missing or of another kind.
class Node {
 public:
  /// @param value  null where there is no such member
  Node(const boost::json::value* value, std::string path) : value_{value}, path_{std::move(path)} {}

  [[noreturn]] void fail(std::string_view expected) const;

  bool exists() const { return value_ != nullptr; }
  bool is_object() const;
  /// A member that may be missing.
  Node find(std::string_view key) const;

  double number() const;  ///< finite
  long long integer() const;
  int count() const;
  bool flag() const;
  std::string text() const;
  const boost::json::object& object() const;
  std::vector<Node> elements() const;
  std::vector<double> numbers() const;
  std::vector<std::string> texts() const;
  Eigen::Vector3d vector() const;

 private:
  const boost::json::value* value_;
  std::string path_;
};

}  // namespace truepose::report
