#include "daemon/report/json_node.hpp"

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace truepose::report {

namespace json = boost::json;

void Node::fail(std::string_view expected) const {
  throw std::invalid_argument(std::string(kind_) + ": '" + path_ + "' is not " + std::string(expected));
}

bool Node::is_null() const { return value_ != nullptr && value_->is_null(); }

bool Node::is_object() const { return object_ != nullptr || (value_ != nullptr && value_->is_object()); }

Node Node::operator[](std::string_view key) const {
  return {object().if_contains(key), kind_, (path_.empty() ? "" : path_ + ".") + std::string(key)};
}

double Node::number() const {
  if (value_ == nullptr || !value_->is_number()) fail("a number");
  const double number = value_->to_number<double>();
  if (!std::isfinite(number)) fail("a finite number");
  return number;
}

long long Node::integer() const {
  // A document that was not read but made here has unsigned ones too.
  if (value_ != nullptr && value_->is_uint64() && std::in_range<long long>(value_->get_uint64()))
    return static_cast<long long>(value_->get_uint64());
  if (value_ == nullptr || !value_->is_int64()) fail("a whole number");
  return value_->get_int64();
}

std::uint64_t Node::natural() const {
  if (value_ != nullptr && value_->is_uint64()) return value_->get_uint64();
  const long long value = integer();
  if (value < 0) fail("a whole number from 0");
  return static_cast<std::uint64_t>(value);
}

bool Node::flag() const {
  if (value_ == nullptr || !value_->is_bool()) fail("true or false");
  return value_->get_bool();
}

std::string Node::text() const {
  if (value_ == nullptr || !value_->is_string()) fail("a text");
  return std::string(value_->get_string());
}

const json::object& Node::object() const {
  if (!is_object()) fail("an object");
  return object_ != nullptr ? *object_ : value_->get_object();
}

std::vector<Node> Node::elements() const {
  if (value_ == nullptr || !value_->is_array()) fail("an array");
  std::vector<Node> result;
  for (const json::value& element : value_->get_array()) {
    result.push_back({&element, kind_, path_ + "[" + std::to_string(result.size()) + "]"});
  }
  return result;
}

std::vector<double> Node::numbers() const {
  std::vector<double> numbers;
  for (const Node& element : elements()) numbers.push_back(element.number());
  return numbers;
}

Eigen::Vector3d Node::vector() const {
  const std::vector<double> xyz = numbers();
  if (xyz.size() != 3) fail("an array of three numbers");
  return {xyz[0], xyz[1], xyz[2]};
}

}  // namespace truepose::report
