#include "daemon/replay/same_outcome.hpp"

#include <algorithm>
#include <boost/json/value.hpp>
#include <cmath>

#include "proto/control/json_text.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;

constexpr double kLastDigits = 1e-9;

bool same(const json::value& a, const json::value& b);

bool same(const json::object& a, const json::object& b) {
  return a.size() == b.size() && std::ranges::all_of(a, [&b](const auto& member) {
           const json::value* const other = b.if_contains(member.key());
           return other && same(member.value(), *other);
         });
}

bool same(double a, double b) {
  return std::abs(a - b) <= kLastDigits * std::max({1.0, std::abs(a), std::abs(b)});
}

bool same(const json::value& a, const json::value& b) {
  if (a.kind() != b.kind()) return false;
  if (a.is_object()) return same(a.get_object(), b.get_object());
  if (a.is_double()) return same(a.get_double(), b.get_double());
  if (!a.is_array()) return a == b;
  return std::ranges::equal(a.get_array(), b.get_array(),
                            [](const json::value& x, const json::value& y) { return same(x, y); });
}

}  // namespace

bool same_outcome(std::string_view recorded, std::string_view now) {
  const auto then = control::parse_json(recorded), other = control::parse_json(now);
  return then && other && same(*then, *other);
}

}  // namespace truepose::daemon
