#include "tools/report/json_node.hpp"

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cmath>
#include <stdexcept>

namespace truepose::report {

namespace json = boost::json;

void Node::fail(std::string_view expected) const {
  throw std::invalid_argument("calibration document: '" + path_ + "' is not " + std::string(expected));
}

bool Node::is_object() const { return exists() && value_->is_object(); }

Node Node::find(std::string_view key) const {
  return {object().if_contains(key), path_ + "." + std::string(key)};
}

double Node::number() const {
  if (!exists() || !value_->is_number()) fail("a number");
  const double number = value_->to_number<double>();
  if (!std::isfinite(number)) fail("a finite number");
  return number;
}

long long Node::integer() const {
  if (!exists() || !value_->is_int64()) fail("a whole number");
  return value_->get_int64();
}

int Node::count() const {
  const long long value = integer();
  if (!std::in_range<int>(value)) fail("a small whole number");
  return static_cast<int>(value);
}

bool Node::flag() const {
  if (!exists() || !value_->is_bool()) fail("true or false");
  return value_->get_bool();
}

std::string Node::text() const {
  if (!exists() || !value_->is_string()) fail("a text");
  return std::string(value_->get_string());
}

const json::object& Node::object() const {
  if (!is_object()) fail("an object");
  return value_->get_object();
}

std::vector<Node> Node::elements() const {
  if (!exists() || !value_->is_array()) fail("an array");
  std::vector<Node> result;
  for (const json::value& element : value_->get_array()) {
    result.emplace_back(&element, path_ + "[" + std::to_string(result.size()) + "]");
  }
  return result;
}

std::vector<double> Node::numbers() const {
  std::vector<double> result;
  for (const Node& element : elements()) result.push_back(element.number());
  return result;
}

std::vector<std::string> Node::texts() const {
  std::vector<std::string> result;
  for (const Node& element : elements()) result.push_back(element.text());
  return result;
}

Eigen::Vector3d Node::vector() const {
  const std::vector<double> xyz = numbers();
  if (xyz.size() != 3) fail("an array of three numbers");
  return {xyz[0], xyz[1], xyz[2]};
}

}  // namespace truepose::report
