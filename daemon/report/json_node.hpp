#pragma once

#include <Eigen/Core>
#include <boost/json/fwd.hpp>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace truepose::report {

/// A value of a document together with the path to it, so that an error names the member. Every accessor
/// throws std::invalid_argument with one sentence where the value is missing or of another kind.
class Node {
 public:
  /// @param document  must live as long as the node
  /// @param kind      of document, as errors call it; a literal
  Node(const boost::json::object& document, std::string_view kind) : object_{&document}, kind_{kind} {}

  [[noreturn]] void fail(std::string_view expected) const;

  bool exists() const { return value_ != nullptr || object_ != nullptr; }
  bool is_null() const;
  bool is_object() const;
  /// A member that may be missing.
  Node operator[](std::string_view key) const;

  double number() const;  ///< finite
  long long integer() const;
  std::uint64_t natural() const;  ///< a whole number from 0, all 64 bits of it
  bool flag() const;
  std::string text() const;
  const boost::json::object& object() const;
  std::vector<Node> elements() const;
  std::vector<Node> elements_or_none() const { return exists() ? elements() : std::vector<Node>(); }
  std::vector<double> numbers() const;
  Eigen::Vector3d vector() const;  ///< [x, y, z]

 private:
  Node(const boost::json::value* value, std::string_view kind, std::string path)
      : value_{value}, kind_{kind}, path_{std::move(path)} {}

  const boost::json::value* value_ = nullptr;
  const boost::json::object* object_ = nullptr;  ///< of the document itself
  std::string_view kind_;
  std::string path_;
};

}  // namespace truepose::report
