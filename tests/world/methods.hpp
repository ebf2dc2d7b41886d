#pragma once

#include <map>
#include <string>
#include <vector>

namespace truepose::world {

/// What proto/control/openrpc.json promises of the methods of the control port.
class Methods {
 public:
  Methods();

  std::vector<std::string> names() const;
  /// Whether it commands: it needs a role above viewer.
  bool commands(const std::string& method) const;
  /// Whether a client of this role may ask for it.
  bool allows(const std::string& role, const std::string& method) const;
  /// Whether it is carried out while another client has control.
  bool is_always_carried_out(const std::string& method) const;

 private:
  struct Method {
    int role = 0;  // by its place among the roles
    bool is_always_carried_out = false;
  };
  std::map<std::string, Method> methods_;
};

}  // namespace truepose::world
