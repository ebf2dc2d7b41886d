#include "tests/world/methods.hpp"

#include <algorithm>
#include <array>
#include <boost/json/parse.hpp>
#include <fstream>
#include <iterator>
#include <sstream>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace json = boost::json;

namespace {

/// Each may do what the ones before may. @return its place
int place_of(const std::string& role) {
  constexpr std::array kRoles{"viewer", "operator", "engineer", "admin"};
  return static_cast<int>(std::distance(kRoles.begin(), std::ranges::find(kRoles, role)));
}

}  // namespace

Methods::Methods() {
  std::ifstream file{TRUEPOSE_SOURCE_DIR "/proto/control/openrpc.json"};
  std::ostringstream text;
  text << file.rdbuf();
  const json::value contract = json::parse(text.str());
  for (const json::value& each : contract.as_object().at("methods").as_array()) {
    const json::object& method = each.as_object();
    methods_[text_at(method, "name")] = {place_of(text_at(method, "x-role")), method.contains("x-always")};
  }
}

std::vector<std::string> Methods::names() const {
  std::vector<std::string> names;
  for (const auto& [name, method] : methods_) names.push_back(name);
  return names;
}

bool Methods::commands(const std::string& method) const { return methods_.at(method).role > 0; }

bool Methods::allows(const std::string& role, const std::string& method) const {
  return place_of(role) >= methods_.at(method).role;
}

bool Methods::is_always_carried_out(const std::string& method) const {
  return methods_.at(method).is_always_carried_out;
}

}  // namespace truepose::world
