#pragma once

#include <Eigen/Core>
#include <boost/json/fwd.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
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
  double number_or(double otherwise) const { return exists() ? number() : otherwise; }
  long long integer() const;
  std::uint64_t natural() const;  ///< a whole number from 0, all 64 bits of it
  long long integer_or(long long otherwise) const { return exists() ? integer() : otherwise; }
  int count() const;
  bool flag() const;
  std::string text() const;
  std::string text_or_empty() const { return exists() ? text() : std::string(); }
  const boost::json::object& object() const;
  std::vector<Node> elements() const;
  std::vector<Node> elements_or_none() const { return exists() ? elements() : std::vector<Node>(); }
  std::vector<double> numbers() const { return each(&Node::number); }
  std::vector<std::string> texts() const { return each(&Node::text); }
  Eigen::Vector3d vector() const;  ///< [x, y, z]
  /// What `read` makes of it, if it exists.
  template <typename Read>
  auto optionally(Read read) const -> std::optional<std::invoke_result_t<Read, const Node&>> {
    if (!exists()) return std::nullopt;
    return std::invoke(read, *this);
  }
  /// What `read` makes of each of its elements.
  template <typename Read>
  auto each(Read read) const -> std::vector<std::decay_t<std::invoke_result_t<Read, const Node&>>> {
    std::vector<std::decay_t<std::invoke_result_t<Read, const Node&>>> result;
    for (const Node& element : elements()) result.push_back(std::invoke(read, element));
    return result;
  }
  template <typename Read>
  auto each_or_none(Read read) const {
    return exists() ? each(read) : decltype(each(read))();
  }
  Eigen::Vector3d xyz() const;  ///< {"x", "y", "z"}

 private:
  Node(const boost::json::value* value, std::string_view kind, std::string path)
      : value_{value}, kind_{kind}, path_{std::move(path)} {}

  const boost::json::value* value_ = nullptr;
  const boost::json::object* object_ = nullptr;  ///< of the document itself
  std::string_view kind_;
  std::string path_;
};

}  // namespace truepose::report
