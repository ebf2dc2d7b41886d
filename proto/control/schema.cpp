#include "proto/control/schema.hpp"

#include <boost/json/parse.hpp>
#include <map>

namespace truepose::control {

namespace {

using Roles = std::map<std::string, Role, std::less<>>;

Roles read_roles() {
  const std::string_view text = openrpc_text();
  const boost::json::value schema = boost::json::parse({text.data(), text.size()});
  Roles roles;
  for (const auto& method : schema.at("methods").as_array())
    roles[method.at("name").as_string().c_str()] = value_of(kRoles, method.at("x-role").as_string().c_str());
  return roles;
}

const Roles& roles() {
  static const Roles kRolesOfMethods = read_roles();
  return kRolesOfMethods;
}

}  // namespace

std::vector<std::string> schema_methods() {
  std::vector<std::string> names;
  for (const auto& [name, role] : roles()) names.push_back(name);
  return names;
}

std::optional<Role> role_of(std::string_view method) {
  const auto found = roles().find(method);
  if (found == roles().end()) return std::nullopt;
  return found->second;
}

}  // namespace truepose::control
